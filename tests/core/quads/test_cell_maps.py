"""Cells on rectangles and squares: nothing turns over, sides where they belong."""

import numpy as np
import pytest

from core.quads.cell_maps import map_cells, map_to_squares, squares_to_rectangles
from tests.core.patches import bump, flat
from tests.core.strips import strip, strip_layout


def areas(image, triangle):
    a, b, c = (image[triangle[:, k]] for k in range(3))
    return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])


def test_no_triangle_turns_over():
    surface, complex, cell_mesh = strip(bump, 20, 16, [3, 4, 11], 0.2)
    layout, length = strip_layout(complex, [1, 9, 2, 4], 6)
    image, live = map_cells(complex, cell_mesh, layout.cell_shape, length)
    area = areas(image, cell_mesh.triangle[live])
    assert len(live) == surface.face_count
    assert area.min() > -1e-12
    assert area.sum() == pytest.approx(16 * 6)


def test_every_square_is_filled_once():
    _, complex, cell_mesh = strip(bump, 20, 16, [3, 4, 11], 0.2)
    area = areas(map_to_squares(complex, cell_mesh), cell_mesh.triangle)
    assert area.min() > -1e-12
    assert np.allclose(np.bincount(cell_mesh.triangle_cell, area), 1)


def test_squares_of_a_regular_strip_become_the_rectangles():
    # With one arc on each side the blended shifts are a scaling: the two maps agree.
    _, complex, cell_mesh = strip(flat, 12, 12, [4], 0.0)
    layout, length = strip_layout(complex, [5, 3], 7)
    square = map_to_squares(complex, cell_mesh)
    image, live = squares_to_rectangles(complex, cell_mesh, square, layout.cell_shape, length)
    exact, exact_live = map_cells(complex, cell_mesh, layout.cell_shape, length)
    assert np.array_equal(live, exact_live)
    assert np.abs(image - exact).max() < 1e-3


@pytest.mark.parametrize("widths", [[1, 9, 2, 4], [3, 0, 8, 1]])
def test_rectangles_from_squares_fill_the_cells(widths):
    _, complex, cell_mesh = strip(bump, 20, 16, [3, 4, 11], 0.2)
    layout, length = strip_layout(complex, widths, 6)
    square = map_to_squares(complex, cell_mesh)
    image, live = squares_to_rectangles(complex, cell_mesh, square, layout.cell_shape, length)
    area = areas(image, cell_mesh.triangle[live])
    assert area.min() > -1e-12
    assert area.sum() == pytest.approx(sum(widths) * 6)
    walls, _ = map_cells(complex, cell_mesh, layout.cell_shape, length)
    wall = cell_mesh.wall_point
    assert np.array_equal(image[wall], walls[wall])
