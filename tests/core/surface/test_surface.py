"""Connectivity, angles and frames of triangle surfaces."""

import numpy as np
import pytest

from core.errors import InputError
from core.surface.surface import (
    build_surface,
    connected_components,
    next_halfedge,
    previous_halfedge,
)
from tests.core import surfaces

MAKERS = {
    "disc": (lambda: surfaces.disc(6), 1, 1, 1),
    "holes": (lambda: surfaces.plate_with_holes(24), -4, 6, 1),
    "annulus": (lambda: surfaces.annulus(20, 4), 0, 2, 1),
    "octant": (lambda: surfaces.octant(7), 1, 1, 1),
    "sphere": (lambda: surfaces.sphere(4), 2, 0, 1),
    "torus": (lambda: surfaces.torus(12, 8), 0, 0, 1),
    "crumpled": (lambda: surfaces.crumpled(surfaces.torus(12, 8), 0.2), 0, 0, 1),
    "two": (lambda: surfaces.together(surfaces.disc(5), surfaces.annulus(14, 3)), 1, 3, 2),
}


@pytest.fixture(params=MAKERS)
def case(request):
    make, euler, loops, parts = MAKERS[request.param]
    return make(), euler, loops, parts


def test_topology(case):
    surface, euler, loops, parts = case
    assert surface.euler_characteristic == euler
    assert surface.loop_count == loops and surface.component_count == parts


def test_halfedges(case):
    surface = case[0]
    h = np.arange(len(surface.tail))
    assert np.array_equal(previous_halfedge(next_halfedge(h)), h)
    assert np.array_equal(surface.head, surface.tail[next_halfedge(h)])
    inner = surface.twin >= 0
    assert np.array_equal(surface.twin[surface.twin[inner]], h[inner])
    assert np.array_equal(surface.tail[surface.twin[inner]], surface.head[inner])


def test_total_curvature_is_that_of_gauss_and_bonnet(case):
    surface, euler, _, _ = case
    turning = (np.pi - surface.angle_sum)[surface.on_boundary].sum()
    assert surface.face_curvature.sum() == pytest.approx(2 * np.pi * euler - turning, abs=1e-9)


def test_fans_run_round_every_vertex(case):
    surface = case[0]
    for vertex in range(0, surface.vertex_count, 7):
        fan = surface.fan[surface.fan_offset[vertex] : surface.fan_offset[vertex + 1]]
        assert np.all(surface.tail[fan] == vertex)
        assert np.all(np.diff(surface.polar_angle[fan]) > 0) and surface.polar_angle[fan[0]] == 0
        assert np.array_equal(surface.twin[previous_halfedge(fan[:-1])], fan[1:])
        closing = surface.twin[previous_halfedge(fan[-1])]
        assert closing == (-1 if surface.on_boundary[vertex] else fan[0])


def test_transport_there_and_back_cancels(case):
    surface = case[0]
    inner = np.flatnonzero(surface.twin >= 0)
    total = surface.transport[inner] + surface.transport[surface.twin[inner]]
    assert np.abs((total + np.pi) % (2 * np.pi) - np.pi).max() < 1e-12


def test_boundary_loops_walk_with_the_surface_on_their_left(case):
    surface = case[0]
    assert np.array_equal(np.sort(surface.loop_halfedges), np.flatnonzero(surface.twin < 0))
    for first, last in zip(surface.loop_offset, surface.loop_offset[1:]):
        loop = surface.loop_halfedges[first:last]
        assert loop[0] == loop.min()
        assert np.array_equal(surface.head[loop], np.roll(surface.tail[loop], -1))


def test_corner_angles_are_exact():
    right = build_surface([[0, 0, 0], [1e-7, 0, 0], [0, 1e-7, 0]], [[0, 1, 2]])
    assert np.allclose(right.corner_angle, np.pi * np.array([1 / 2, 1 / 4, 1 / 4]), rtol=1e-14)
    needle = build_surface([[0, 0, 0], [1, 0, 0], [1, 1e-8, 0]], [[0, 1, 2]])
    assert needle.corner_angle[0] == pytest.approx(1e-8, rel=1e-12)
    assert needle.corner_angle.sum() == pytest.approx(np.pi, rel=1e-14)


def test_normals_of_a_sphere_point_outwards():
    surface = surfaces.sphere(6)
    assert (surface.vertex_normal * surface.points).sum(1).min() > 0.99


def test_an_edge_used_twice_in_one_direction_is_refused():
    points = np.eye(4, 3)
    with pytest.raises(InputError, match="edge between vertices 0 and 1"):
        build_surface(points, [[0, 1, 2], [0, 1, 3]])


def test_a_vertex_between_two_fans_is_refused():
    points = np.random.default_rng(0).normal(size=(5, 3))
    with pytest.raises(InputError, match="Vertex 0"):
        build_surface(points, [[0, 1, 2], [0, 3, 4]])


def test_connected_components_are_numbered_by_their_smallest_member():
    found = connected_components(7, np.array([6, 3, 1]), np.array([2, 4, 3]))
    assert found.tolist() == [0, 1, 2, 1, 1, 3, 2]
