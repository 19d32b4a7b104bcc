"""Matching of crosses: exact antisymmetry, integers, walls, and directions in space."""

import numpy as np
import pytest

from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field, edge_rotations, wrap
from core.surface.surface import build_surface
from tests.core.surfaces import annulus, crumpled, disc, lshape, octant, plate, sphere, torus

SURFACES = {
    "disc": lambda: disc(5),
    "octant": lambda: octant(6),
    "torus": torus,
    "crumpled sphere": lambda: crumpled(sphere(5), 0.6),
    "one triangle": lambda: build_surface([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
}


def random_field(surface, seed):
    constraints = boundary_constraints(surface, 0.35)
    angle = np.random.default_rng(seed).uniform(-10, 10, surface.vertex_count)
    angle = np.where(constraints.fixed, constraints.angle, angle)
    return build_cross_field(surface, angle, constraints), constraints


def test_wrap_ends():
    quarter = np.pi / 2
    assert wrap(np.pi / 4) == pytest.approx(np.pi / 4)
    assert wrap(-np.pi / 4) == pytest.approx(np.pi / 4)
    values = np.linspace(-20, 20, 1001)
    assert np.abs(wrap(values)).max() <= np.pi / 4 + 1e-12
    assert np.allclose(np.rint((values - wrap(values)) / quarter) * quarter, values - wrap(values))


@pytest.mark.parametrize("name", SURFACES)
@pytest.mark.parametrize("seed", range(3))
def test_matching_is_consistent(name, seed):
    surface = SURFACES[name]()
    field, _ = random_field(surface, seed)
    inner = np.flatnonzero(surface.twin >= 0)
    twin = surface.twin[inner]
    assert np.array_equal(field.rotation[inner], -field.rotation[twin])
    assert np.array_equal(field.turn[inner] + field.turn[twin], np.full(len(inner), -4))
    at_head = field.angle[surface.head] - surface.reverse_angle - np.pi
    at_tail = field.angle[surface.tail] - surface.polar_angle
    assert np.allclose(at_head - at_tail, field.rotation + field.turn * np.pi / 2, atol=1e-11)
    total = field.rotation.reshape(-1, 3).sum(1) + surface.face_curvature
    assert np.allclose(total, field.index * np.pi / 2, atol=1e-11)


def test_a_singularity_of_two_quads_becomes_two_of_three():
    """So few triangles, each so curved, that crosses of pure noise turn half round some of them."""
    spike = sphere(2)
    spike = build_surface(spike.points * (1, 1, 9), spike.triangles)
    sharp = 0
    for seed in range(40):
        field, _ = random_field(spike, seed)
        plain = edge_rotations(spike, field.angle).reshape(-1, 3).sum(1) + spike.face_curvature
        plain = np.rint(plain / (np.pi / 2)).astype(int)
        sharp += (plain >= 2).sum()
        assert field.index.max() <= 1 and field.index.sum() == plain.sum() == 8
        assert np.abs(field.index - plain).sum() == 2 * np.maximum(plain - 1, 0).sum()
        assert np.array_equal(field.rotation, -field.rotation[spike.twin])
        total = field.rotation.reshape(-1, 3).sum(1) + spike.face_curvature
        assert np.allclose(total, field.index * np.pi / 2, atol=1e-11)
    assert sharp > 0


def test_ties_do_not_break_antisymmetry():
    surface = plate(np.ones((6, 6)))
    constraints = boundary_constraints(surface, 0.35)
    inside = ~surface.on_boundary
    angle = constraints.angle.copy()
    angle[inside] = np.pi / 4 * (np.arange(inside.sum()) % 2)
    field = build_cross_field(surface, angle, constraints)
    inner = np.flatnonzero(surface.twin >= 0)
    assert np.array_equal(field.rotation[inner], -field.rotation[surface.twin[inner]])


def test_same_branch_follows_the_wall():
    surface = crumpled(disc(3), 0.5)
    field, constraints = random_field(surface, 0)
    wall = surface.loop_halfedges
    leaving = wrap(field.angle - 0.0)
    arriving = wrap(field.angle - surface.angle_sum - np.pi)
    turned = arriving[surface.head[wall]] - leaving[surface.tail[wall]]
    assert np.allclose(field.rotation[wall], turned)
    assert np.abs(leaving[constraints.fixed]).max() <= np.pi / 4


def test_uniform_field_in_the_plane_does_not_turn():
    surface = lshape(5)
    along_x = np.array([0.3, 0.9539392014169457, 0])
    edge = surface.points[surface.head] - surface.points[surface.tail]
    first = surface.fan[surface.fan_offset[:-1]]
    angle = np.arctan2(along_x[1], along_x[0]) - np.arctan2(edge[first, 1], edge[first, 0])
    field = build_cross_field(surface, angle, boundary_constraints(surface, 0.35))
    inner = surface.twin >= 0
    assert np.abs(field.rotation[inner]).max() < 1e-12
    assert np.allclose(field.direction(surface), along_x, atol=1e-12)


@pytest.mark.parametrize("make", [lambda: octant(8), torus, lambda: crumpled(annulus(20, 6), 0.3)])
def test_directions_are_unit_tangent_vectors(make):
    surface = make()
    field, _ = random_field(surface, 1)
    direction = field.direction(surface)
    assert np.allclose(np.linalg.norm(direction, axis=1), 1)
    assert np.abs((direction * surface.vertex_normal).sum(1)).max() < 1e-12


def test_walls_of_the_octant_are_followed_in_space():
    surface = octant(16)
    constraints = boundary_constraints(surface, 0.35)
    field = build_cross_field(surface, constraints.angle, constraints)
    wall = surface.loop_halfedges
    along = surface.points[surface.head[wall]] - surface.points[surface.tail[wall]]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    cosine = np.abs((along * field.direction(surface)[surface.tail[wall]]).sum(1))
    assert np.minimum(cosine, np.sqrt(np.maximum(0, 1 - cosine**2))).max() < 0.06
