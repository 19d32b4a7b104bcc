"""The corner rule on corners whose angles are known."""

import numpy as np
import pytest

from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field
from core.surface.surface import build_surface
from tests.core.surfaces import disc, lshape, regular_polygon, sphere


def wedge(angle, n=8):
    """Fan of n triangles round the origin (vertex 0) with the given angle."""
    t = np.linspace(0, angle, n + 1)
    rim = np.c_[np.cos(t), np.sin(t), np.zeros(n + 1)]
    triangles = [(0, k + 1, k + 2) for k in range(n)]
    return build_surface(np.concatenate([np.zeros((1, 3)), rim]), triangles)


@pytest.mark.parametrize(
    "degrees, blocks",
    [(5, 1), (44, 1), (90, 1), (134, 1), (136, 2), (180, 2), (224, 2), (226, 3), (270, 3),
     (316, 4), (352, 4)],
)
def test_corner_rule(degrees, blocks):
    surface = wedge(np.radians(degrees))
    constraints = boundary_constraints(surface, np.radians(20))
    assert constraints.block_count[0] == blocks
    # The branch nearest to either wall deviates from it by half of the corner's excess.
    excess = np.radians(degrees) - blocks * np.pi / 2
    from_wall = (constraints.angle[0] - excess / 2) / (np.pi / 2)
    assert from_wall == pytest.approx(np.rint(from_wall), abs=1e-12)


def test_square_corners_fit_exactly():
    surface = lshape(4)
    constraints = boundary_constraints(surface, np.radians(20))
    blocks = constraints.block_count[surface.on_boundary]
    assert sorted(blocks[blocks != 2]) == [1, 1, 1, 1, 1, 3]
    assert np.count_nonzero(constraints.corner) == 6
    assert not constraints.kink.any()
    assert np.array_equal(constraints.fixed, surface.on_boundary)
    field = build_cross_field(surface, constraints.angle, constraints)
    assert np.abs(field.rotation[surface.loop_halfedges]).max() < 1e-12


def test_kinks_are_flat_corners_that_turn_by_more_than_the_limit():
    surface = regular_polygon(9, 3)
    assert boundary_constraints(surface, np.radians(39)).kink.sum() == 9
    assert boundary_constraints(surface, np.radians(41)).kink.sum() == 0


def test_fine_circle_has_neither_corners_nor_kinks():
    constraints = boundary_constraints(disc(12), np.radians(20))
    assert not constraints.corner.any() and not constraints.kink.any()


def test_closed_surface_fixes_nothing():
    constraints = boundary_constraints(sphere(4), np.radians(20))
    assert not constraints.fixed.any()
    assert not constraints.block_count.any()
