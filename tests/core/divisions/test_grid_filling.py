"""Filling blocks: what straight sides give, and first cells at walls."""

import numpy as np
import pytest

from core.divisions.grid_filling import fill_grid
from core.divisions.smooth_curves import sample_line


def square(count):
    line = np.linspace(0, 1, count + 1)
    x, y = np.meshgrid(line, line)
    return np.stack([x, y, 0 * x], axis=-1)


def sides_of(grid, along, across):
    """Four sides, counter-clockwise, with nodes at indices along and across of an old grid."""
    first, second = sample_line(grid[0], along), sample_line(grid[:, -1], across)
    third, fourth = sample_line(grid[-1, ::-1], along), sample_line(grid[::-1, 0], across)
    return [(along, first), (across, second), (along, third), (across, fourth)]


def test_equal_divisions_of_a_square_are_equal_squares():
    index = np.linspace(0, 4, 9)
    point, row, column = fill_grid(square(4), sides_of(square(4), index, index))
    assert np.allclose(point, square(8), atol=1e-14)
    assert np.allclose(row[:, 3], index) and np.allclose(column[2], index)


@pytest.mark.parametrize("side", range(4))
@pytest.mark.parametrize("height", [1e-3, 0.05, 0.2])
def test_the_first_cells_beside_a_wall_are_as_long_as_the_rule_says(side, height):
    index = np.linspace(0, 4, 9)
    walls = [None] * 4
    walls[side] = lambda row, leaving: np.full(len(row), height)
    point, _, _ = fill_grid(square(4), sides_of(square(4), index, index), walls)
    turned = np.rot90(point, side)
    cell = np.linalg.norm(np.diff(turned, axis=0), axis=2)[:, 1:-1]
    assert np.allclose(cell[0], height, rtol=1e-9)
    assert (cell > 0).all()


def test_both_walls_of_a_block_are_met():
    index = np.linspace(0, 4, 9)

    def rule(row, leaving):
        return np.full(len(row), 0.01)

    walls = [rule, None, rule, None]
    point, _, _ = fill_grid(square(4), sides_of(square(4), index, index), walls)
    cell = np.diff(point[..., 1], axis=0)[:, 1:-1]
    assert np.allclose(cell[0], 0.01) and np.allclose(cell[-1], 0.01)
    assert (cell > 0).all() and np.allclose(cell, cell[::-1])


def test_a_height_without_room_leaves_the_other_nodes_in_order():
    index = np.linspace(0, 4, 9)
    walls = [lambda row, leaving: np.full(len(row), 5.0), None, None, None]
    point, _, _ = fill_grid(square(4), sides_of(square(4), index, index), walls)
    assert (np.diff(point[..., 1], axis=0) > 0).all()
