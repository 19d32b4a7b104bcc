"""Quad vertices placed in one cell and in several cells side by side."""

import numpy as np
import pytest

from core.quads.mapping import place_vertices
from core.quads.quality import scaled_jacobian
from core.surface.boundary import build_loops
from core.surface.projection import barycentric, surface_normal
from tests.core.patches import bump, flat, grid_parameters, octant
from tests.core.strips import strip, strip_layout


def place(shape, m, n, cuts, widths, height, jitter=0.2):
    surface, complex, cell_mesh = strip(shape, m, n, cuts, jitter)
    layout, length = strip_layout(complex, widths, height)
    return surface, layout, place_vertices(surface, complex, cell_mesh, layout, length)


def assert_on_surface(surface, placement):
    weight = barycentric(surface, placement.face, placement.point)
    assert weight.min() > -1e-9
    rebuilt = (surface.points[surface.triangles[placement.face]] * weight[:, :, None]).sum(1)
    assert np.abs(rebuilt - placement.point).max() < 1e-12
    loops = build_loops(surface)
    wall = np.flatnonzero(placement.loop >= 0)
    exact, _ = loops.point(placement.loop[wall], placement.loop_position[wall])
    assert np.abs(exact - placement.point[wall]).max() < 1e-12
    assert (placement.loop_position >= 0).all()


def test_square_becomes_the_regular_grid():
    surface, _layout, placement = place(flat, 12, 12, [], [5], 7, jitter=0.2)
    assert_on_surface(surface, placement)
    expected = flat(grid_parameters(5, 7))
    assert np.abs(placement.point - expected).max() < 0.03
    wall = placement.loop >= 0
    assert np.abs(placement.point - expected)[wall].max() < 1e-12
    assert placement.fixed.sum() == 4


def test_regular_triangulation_is_exact():
    _, _, placement = place(flat, 12, 12, [], [5], 7, jitter=0.0)
    assert np.abs(placement.point - flat(grid_parameters(5, 7))).max() < 1e-4


@pytest.mark.parametrize("shape", [flat, octant, bump])
@pytest.mark.parametrize("widths", [[6, 9], [15, 2]])
def test_two_cells_give_valid_quads(shape, widths):
    surface, layout, placement = place(shape, 20, 16, [8], widths, 11)
    assert_on_surface(surface, placement)
    normal = surface_normal(surface, placement.face, placement.point)
    assert scaled_jacobian(placement.point, layout.quad, normal).min() > 0.3
    assert (placement.loop == layout.vertex_loop).all()


def test_vanished_cell_merges_its_walls():
    surface, layout, placement = place(flat, 12, 6, [5, 7], [4, 0, 4], 3, jitter=0.0)
    assert_on_surface(surface, placement)
    points = placement.point.reshape(4, 9, 3)
    assert np.abs(points[:, 4, 0] - 0.5).max() < 1e-9  # midway between the walls of the lost cell
    assert scaled_jacobian(placement.point, layout.quad).min() > 0.9


def test_fixed_node_wins_over_the_wall_next_to_it():
    surface, _layout, placement = place(flat, 12, 6, [2], [0, 5], 3, jitter=0.0)
    points = placement.point.reshape(4, 6, 3)
    assert np.abs(points[[0, -1], 0, 0]).max() == 0
    assert_on_surface(surface, placement)


def test_needles_and_an_extreme_grid():
    surface, layout, placement = place(flat, 60, 3, [1, 59], [3, 40, 3], 30, jitter=0.2)
    assert_on_surface(surface, placement)
    assert scaled_jacobian(placement.point, layout.quad).min() > 0
