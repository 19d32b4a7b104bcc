"""Smooth curves: points are met, circles nearly, straight lines exactly; no kinks."""

import numpy as np
import pytest

from core.divisions.smooth_curves import sample_curve, sample_grid, sample_line


def arc(angle):
    return np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)


def test_points_are_met_at_their_indices():
    point = np.random.default_rng(3).normal(size=(6, 3))
    assert np.allclose(sample_curve(point, np.arange(6.0)), point)
    assert np.allclose(sample_line(point, np.arange(6.0)), point)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_straight_lines_stay_straight_however_uneven(count):
    place = np.cumsum(np.r_[0, 7.0 ** np.arange(count)])
    point = place[:, None] * [1.0, 2.0, 3.0]
    sample = sample_curve(point, np.linspace(0, count, 31))
    assert np.allclose(np.cross(sample, [1.0, 2.0, 3.0]), 0, atol=1e-9 * place[-1])
    assert (np.diff(sample[:, 0]) > 0).all()


def test_a_circle_is_followed_closer_than_by_its_chords():
    point = arc(np.linspace(0, 1, 6))
    index = np.linspace(0, 5, 101)
    smooth = np.abs(np.linalg.norm(sample_curve(point, index), axis=1) - 1).max()
    straight = np.abs(np.linalg.norm(sample_line(point, index), axis=1) - 1).max()
    assert smooth < straight / 10


def test_rows_and_columns_of_a_grid_are_smooth_curves():
    grid = np.random.default_rng(4).normal(size=(4, 5, 3))
    along, across = np.linspace(0, 4, 23), np.linspace(0, 3, 17)
    for j in range(4):
        assert np.allclose(sample_grid(grid, j + 0 * along, along), sample_curve(grid[j], along))
    for i in range(5):
        on_column = sample_grid(grid, across, i + 0 * across)
        assert np.allclose(on_column, sample_curve(grid[:, i], across))


def test_a_ring_has_no_kinks_across_its_old_points():
    radius = np.linspace(1, 2, 4)[:, None, None]
    grid = radius * arc(np.linspace(0, 1, 6))
    near = 3 + np.array([-1e-4, 0, 1e-4])
    for row in (0.0, 0.4, 1.7):
        step = np.diff(sample_grid(grid, row + 0 * near, near), axis=0)
        turn = np.cross(step[0], step[1])[2] / np.linalg.norm(step, axis=1).prod()
        assert abs(turn) < 1e-3
