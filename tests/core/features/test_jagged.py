"""Corners of jagged boundaries: noise makes none, true ones stay, clean boundaries are untouched."""

import numpy as np
import pytest

from core.cells.layout import trace_layout
from core.features.jagged import smooth_jagged
from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field
from core.field.distance import arrival_distance
from core.field.propagation import propagate
from core.field.relaxation import relax
from core.field.singularities import find_singularities
from core.surface.surface import build_surface
from tests.core import surfaces

KINK = np.radians(20)


def jagged_plate(n=24, amount=0.45, seed=2):
    """A square whose boundary vertices, save the corners, are thrown about."""
    surface = surfaces.plate(np.ones((n, n), bool), 1 / n, 0.1)
    corners = boundary_constraints(surface, KINK).corner
    noise = np.random.default_rng(seed).uniform(-amount, amount, surface.points.shape) / n
    noise[:, 2] = 0
    moved = np.where((surface.on_boundary & ~corners)[:, None], noise, 0)
    return build_surface(surface.points + moved, surface.triangles)


def fields(surface):
    """Singularities with and without smoothing, and the layout with it."""
    found = []
    plain = boundary_constraints(surface, KINK)
    for constraints in (plain, smooth_jagged(surface, plain)):
        angle = propagate(surface, constraints, arrival_distance(surface, constraints.fixed))
        field = build_cross_field(surface, relax(surface, constraints, angle, "diffused"), constraints)
        found.append(find_singularities(surface, field, constraints))
    return (*found, trace_layout(surface, constraints, field))


@pytest.mark.parametrize("seed", range(3))
def test_a_jagged_square_has_fewer_corners_and_singularities(seed):
    surface = jagged_plate(seed=seed)
    plain = boundary_constraints(surface, KINK)
    smooth = smooth_jagged(surface, plain)
    assert smooth.corner.sum() < plain.corner.sum()
    assert smooth.corner.sum() <= 8
    before, after, layout = fields(surface)
    assert len(after) <= len(before)
    assert after.index_sum == after.expected_index_sum == 4
    c = layout.complex
    assert c.node_count - c.arc_count + c.cell_count == 1


@pytest.mark.parametrize(
    "make",
    [
        lambda: surfaces.disc(9), lambda: surfaces.lshape(8), lambda: surfaces.plate_with_holes(24),
        lambda: surfaces.regular_polygon(3, 12), lambda: surfaces.annulus(60, 8),
        lambda: surfaces.sphere(4), lambda: surfaces.octant(12),
    ],
)
def test_clean_boundaries_are_left_alone(make):
    surface = make()
    constraints = boundary_constraints(surface, KINK)
    assert smooth_jagged(surface, constraints) is constraints


def test_crosses_of_a_jagged_straight_edge_follow_it():
    surface = jagged_plate(30, 0.4)
    constraints = smooth_jagged(surface, boundary_constraints(surface, KINK))
    field = build_cross_field(surface, constraints.angle, constraints)
    direction = field.direction(surface)[:, :2]
    far = surface.on_boundary & (np.abs(surface.points[:, 0] - 0.5) < 0.3)
    off = 0.25 * np.abs(np.angle(np.exp(4j * np.arctan2(direction[far, 1], direction[far, 0]))))
    assert np.degrees(off).mean() < 12


@pytest.mark.parametrize("seed", range(4))
def test_the_index_sum_is_exact_whatever_the_corners_are(seed):
    surface = jagged_plate(20, 0.49, seed)
    constraints = smooth_jagged(surface, boundary_constraints(surface, KINK))
    noise = np.random.default_rng(seed).uniform(-1, 1, surface.vertex_count)
    angle = np.where(constraints.fixed, constraints.angle, noise)
    found = find_singularities(surface, build_cross_field(surface, angle, constraints), constraints)
    assert found.index_sum == found.expected_index_sum


def test_cuts_keep_their_corners_and_the_rest_of_the_boundary_does_not():
    surface = jagged_plate()
    plain = boundary_constraints(surface, KINK)
    everywhere = smooth_jagged(surface, plain, surface.twin < 0)
    assert np.array_equal(everywhere.block_count, plain.block_count)
    low = surface.points[:, 1] < 0.3
    cut = (surface.twin < 0) & low[surface.tail] & low[surface.head]
    some, all_ = smooth_jagged(surface, plain, cut), smooth_jagged(surface, plain)
    high = surface.points[:, 1] > 0.6
    assert np.array_equal(some.block_count[high], all_.block_count[high])
    assert not np.array_equal(some.block_count[high], plain.block_count[high])
    ends = surface.tail[cut]
    assert np.array_equal(some.block_count[ends], plain.block_count[ends])


def test_stairs_are_not_noise():
    n = 8
    stairs = np.tri(n, dtype=bool)
    surface = surfaces.plate(np.kron(stairs, np.ones((2, 2), bool)), 1 / n)
    plain = boundary_constraints(surface, KINK)
    assert np.array_equal(smooth_jagged(surface, plain).block_count, plain.block_count)
    assert plain.corner.sum() == 2 * n + 2
