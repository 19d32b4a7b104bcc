"""The index sum is what topology asks, on every surface and for every field."""

import numpy as np
import pytest

from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field
from core.field.singularities import find_singularities
from tests.core.surfaces import (
    annulus,
    crumpled,
    cylinder,
    disc,
    lshape,
    octant,
    plate,
    plate_with_holes,
    regular_polygon,
    sphere,
    together,
    torus,
    voxel_shell,
)

TWO_HOLES = np.array([[1, 1, 1, 1, 1], [1, 0, 1, 0, 1], [1, 1, 1, 1, 1]])

SURFACES = {
    "disc": (lambda: disc(6), 1),
    "triangle": (lambda: regular_polygon(3, 5), 1),
    "L": (lambda: lshape(5), 1),
    "octant": (lambda: octant(7), 1),
    "annulus": (lambda: annulus(21, 5), 0),
    "cylinder": (lambda: cylinder(15, 6), 0),
    "holes": (plate_with_holes, -4),
    "27 holes": (lambda: plate(np.kron(np.ones((3, 9)), np.pad([[0]], 1, constant_values=1))), -26),
    "sphere": (lambda: sphere(5), 2),
    "torus": (torus, 0),
    "genus 2": (lambda: voxel_shell(TWO_HOLES), -2),
    "genus 3": (lambda: voxel_shell(np.kron([[1, 1, 1]], np.pad([[0]], 1, constant_values=1))), -4),
    "crumpled disc": (lambda: crumpled(disc(6), 0.8), 1),
    "crumpled torus": (lambda: crumpled(torus(), 1.5), 0),
    "crumpled genus 2": (lambda: crumpled(voxel_shell(TWO_HOLES), 1.0), -2),
    "two parts": (lambda: together(sphere(3), annulus(12, 3), lshape(3)), 3),
}


def singularities_of(surface, angle):
    constraints = boundary_constraints(surface, 0.35)
    angle = np.where(constraints.fixed, constraints.angle, angle)
    field = build_cross_field(surface, angle, constraints)
    return find_singularities(surface, field, constraints)


@pytest.mark.parametrize("name", SURFACES)
def test_index_sum_is_four_chi(name):
    make, euler = SURFACES[name]
    surface = make()
    assert surface.euler_characteristic == euler
    for seed in range(4):
        angle = np.random.default_rng(seed).uniform(-9, 9, surface.vertex_count)
        found = singularities_of(surface, angle)
        assert found.expected_index_sum == 4 * euler
        assert found.index_sum == found.expected_index_sum
        assert np.array_equal(found.valence, 4 + found.k)


def test_positions_lie_inside_their_triangles():
    surface = octant(8)
    angle = np.random.default_rng(0).uniform(-9, 9, surface.vertex_count)
    found = singularities_of(surface, angle)
    assert len(found) > 0 and np.all(found.index != 0)
    corner = surface.points[surface.triangles[found.face]]
    weights = np.linalg.solve(np.swapaxes(corner, 1, 2), found.position[:, :, None])[:, :, 0]
    assert weights.min() > 0
    assert np.allclose(weights.sum(1), 1)


@pytest.mark.parametrize("quarters", [1, -1])
def test_field_that_turns_by_a_quarter_has_one_singularity_in_the_centre(quarters):
    surface = disc(7)
    around = np.arctan2(surface.points[:, 1] - 0.007, surface.points[:, 0] - 0.013)
    first = surface.fan[surface.fan_offset[:-1]]
    edge = surface.points[surface.head[first]] - surface.points[surface.tail[first]]
    found = singularities_of(surface, quarters * around / 4 - np.arctan2(edge[:, 1], edge[:, 0]))
    in_middle = np.linalg.norm(found.position, axis=1) < 0.6
    assert found.index[in_middle].tolist() == [quarters]
    assert found.valence[in_middle].tolist() == [4 - quarters]
    assert np.linalg.norm(found.position[in_middle]) < 0.2
