"""Principal directions against known ones; guides that lead the field and never add to noise."""

import numpy as np
import pytest

from core.features.curvature import guide_by_curvature, principal_directions
from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field, direction_vectors
from core.field.distance import arrival_distance
from core.field.propagation import propagate
from core.field.relaxation import relax
from tests.core import surfaces

KINK = np.radians(20)


def relaxed(surface, guided=True):
    constraints = boundary_constraints(surface, KINK)
    if guided:
        constraints = guide_by_curvature(surface, constraints)
    angle = propagate(surface, constraints, arrival_distance(surface, constraints.fixed))
    return build_cross_field(surface, relax(surface, constraints, angle, "diffused"), constraints)


def off_axis(surface, angle, axis):
    """(V,) degrees between the crosses and given tangent directions (V, 3), at most 45."""
    direction = direction_vectors(surface, angle)
    turn = np.arctan2(
        (np.cross(axis, direction) * surface.vertex_normal).sum(1), (axis * direction).sum(1)
    )
    return np.degrees(0.25 * np.abs(np.angle(np.exp(4j * turn))))


def round_the_axis(surface):
    axis = np.cross([0, 0, 1.0], surface.points)
    return axis / np.linalg.norm(axis, axis=1, keepdims=True)


def test_curvatures_of_a_cylinder():
    surface = surfaces.cylinder(48, 24)
    angle, difference, total = principal_directions(surface)
    inside = np.abs(surface.points[:, 2] - 1) < 0.4
    assert off_axis(surface, angle, round_the_axis(surface))[inside].max() < 3
    assert difference[inside] == pytest.approx(1, abs=0.1)
    assert total[inside] == pytest.approx(1, abs=0.1)


def test_a_sphere_has_no_preferred_direction():
    surface = surfaces.sphere(8)
    _, difference, total = principal_directions(surface)
    assert total.mean() == pytest.approx(2, rel=0.1)
    assert np.median(difference / total) < 0.1
    constraints = boundary_constraints(surface, KINK)
    assert guide_by_curvature(surface, constraints).guide is None or np.abs(
        guide_by_curvature(surface, constraints).guide
    ).mean() < 1


def test_a_torus_follows_its_circles_without_singularity():
    surface = surfaces.torus(36, 24)
    field = relaxed(surface)
    assert not field.index.any()
    assert off_axis(surface, field.angle, round_the_axis(surface)).max() < 5


@pytest.mark.parametrize("amount", [0.02, 0.05, 0.1])
def test_noise_adds_no_singularities(amount):
    smooth, noisy = surfaces.torus(36, 24), surfaces.crumpled(surfaces.torus(36, 24), amount)
    assert np.count_nonzero(relaxed(smooth).index) == 0
    plain = np.count_nonzero(relaxed(noisy, guided=False).index)
    assert np.count_nonzero(relaxed(noisy).index) <= plain
    sphere = surfaces.crumpled(surfaces.sphere(10), amount)
    assert np.count_nonzero(relaxed(sphere).index) <= np.count_nonzero(
        relaxed(sphere, guided=False).index
    ) + 2


def test_surfaces_with_boundary_are_left_alone():
    surface = surfaces.annulus(24, 5)
    constraints = boundary_constraints(surface, KINK)
    assert guide_by_curvature(surface, constraints) is constraints


def test_only_the_closed_part_is_guided():
    surface = surfaces.together(surfaces.disc(6), surfaces.torus(24, 16))
    constraints = guide_by_curvature(surface, boundary_constraints(surface, KINK))
    part = np.zeros(surface.vertex_count, int)
    part[surface.tail] = np.repeat(surface.component, 3)
    assert np.all(constraints.guide[part == 0] == 0)
    assert np.all(constraints.guide[part == 1] != 0)
    field = relaxed(surface)
    assert np.count_nonzero(field.index[surface.component == 1]) == 0
    assert field.index.sum() == 4


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_scale_does_not_matter(factor):
    surface = surfaces.torus(30, 20)
    moved = surfaces.build_surface(factor * surface.points, surface.triangles)
    first = guide_by_curvature(surface, boundary_constraints(surface, KINK)).guide
    second = guide_by_curvature(moved, boundary_constraints(moved, KINK)).guide
    assert np.allclose(first, second * factor**2, rtol=1e-6)


@pytest.mark.parametrize("mode", ["none", "harmonic"])
def test_other_relaxations_accept_a_guide(mode):
    surface = surfaces.torus(20, 12)
    constraints = guide_by_curvature(surface, boundary_constraints(surface, KINK))
    angle = relax(surface, constraints, np.zeros(surface.vertex_count), mode)
    field = build_cross_field(surface, angle, constraints)
    assert field.index.sum() == 0 and np.isfinite(field.angle).all()
