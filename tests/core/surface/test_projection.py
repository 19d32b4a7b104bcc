"""Walks and closest points against planes, spheres, cylinders and brute force."""

import numpy as np
import pytest

from core.surface.projection import barycentric, closest_point, plane_normal, surface_normal, walk
from core.surface.surface import build_surface
from tests.core.patches import annulus, bump, flat, octant, patch


def places(surface, count, seed=0):
    generator = np.random.default_rng(seed)
    face = generator.integers(0, surface.face_count, count)
    weight = generator.dirichlet([1, 1, 1], count)
    return (surface.points[surface.triangles[face]] * weight[:, :, None]).sum(1), face


def distance_to_surface(surface, points):
    """Smallest distance to any triangle, by brute force."""
    best = np.full(len(points), np.inf)
    for a, b, c in surface.points[surface.triangles]:
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        height = (points - a) @ normal
        foot = points - height[:, None] * normal
        inside = np.ones(len(points), bool)
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= np.cross(q - p, foot - p) @ normal >= 0
            t = np.clip(((points - p) @ (q - p)) / ((q - p) @ (q - p)), 0, 1)
            best = np.minimum(best, np.linalg.norm(points - p - t[:, None] * (q - p), axis=1))
        best = np.where(inside, np.minimum(best, np.abs(height)), best)
    return best


def assert_in_face(surface, point, face, tolerance=1e-12):
    weight = barycentric(surface, face, point)
    assert weight.min() > -1e-7
    rebuilt = (surface.points[surface.triangles[face]] * weight[:, :, None]).sum(1)
    assert np.abs(rebuilt - point).max() <= tolerance * max(surface.diameter, 1)


def test_walk_in_the_plane_is_addition():
    surface = patch(flat, 20, jitter=0.2)
    point, face = places(surface, 500)
    goal = flat(np.random.default_rng(1).uniform(0.01, 0.99, (500, 2)))
    end, end_face = walk(surface, point, face, goal - point)
    assert np.abs(end - goal).max() < 1e-12
    assert_in_face(surface, end, end_face)


def test_walk_stops_at_the_boundary():
    surface = patch(flat, 10, jitter=0.2)
    point, face = places(surface, 200)
    end, end_face = walk(surface, point, face, np.tile([5.0, 0, 0], (200, 1)))
    assert np.abs(end[:, 0] - 1).max() < 1e-12
    assert np.abs(end[:, 1] - point[:, 1]).max() < 1e-12
    assert_in_face(surface, end, end_face)


def test_walk_stops_at_walls():
    surface = patch(flat, 10)
    line = np.isclose(surface.points[:, 0], 0.5)
    wall = line[surface.tail] & line[surface.head]
    point, face = places(surface, 200)
    end, _ = walk(surface, point, face, np.tile([5.0, 0, 0], (200, 1)), wall)
    left = surface.points[surface.triangles[face], 0].mean(1) < 0.5
    assert np.abs(end[:, 0] - np.where(left, 0.5, 1.0)).max() < 1e-12


def test_walk_round_a_cylinder_keeps_height_and_length():
    def cylinder(parameter):
        angle = np.pi * parameter[:, 0]
        return np.column_stack([np.cos(angle), np.sin(angle), parameter[:, 1]])

    surface = patch(cylinder, 40, 10)
    start, face = closest_point(surface, [[np.cos(0.2), np.sin(0.2), 0.55]])
    end, _ = walk(surface, start, face, [[-np.sin(0.2), np.cos(0.2), 0.0]])
    angle = np.arctan2(end[0, 1], end[0, 0])
    assert end[0, 2] == pytest.approx(start[0, 2], abs=1e-9)
    assert angle == pytest.approx(1.2, abs=5e-3)


def test_walk_back_returns():
    surface = patch(bump, 24, jitter=0.2)
    point, face = places(surface, 300, seed=3)
    inside = (np.abs(point[:, :2] - 0.5) < 0.3).all(1)
    point, face = point[inside], face[inside]
    move = 0.1 * np.random.default_rng(2).normal(size=point.shape) / 3
    end, end_face = walk(surface, point, face, move)
    assert_in_face(surface, end, end_face)
    assert np.linalg.norm(end - point, axis=1).max() < np.linalg.norm(move, axis=1).max() + 1e-12


def test_walk_of_length_zero_and_through_vertices():
    surface = patch(flat, 4)
    vertex = surface.points[surface.triangles[:, 0]]
    end, _ = walk(surface, vertex, np.arange(surface.face_count), np.zeros_like(vertex))
    assert np.abs(end - vertex).max() < 1e-15
    middle = np.tile([[0.5, 0.5, 0.0]], (8, 1))
    touching = (surface.points[surface.triangles] == middle[0]).all(2).any(1)
    face = np.full(8, np.flatnonzero(touching)[0])
    angle = np.arange(8) * np.pi / 4
    move = 0.25 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    assert np.abs(walk(surface, middle, face, move)[0] - middle - move).max() < 1e-12


@pytest.mark.parametrize("shape", [flat, octant, bump])
def test_closest_point_is_the_closest(shape):
    surface = patch(shape, 9, jitter=0.2)
    points = np.random.default_rng(4).uniform(-1, 2, (300, 3))
    place, face = closest_point(surface, points)
    found = np.linalg.norm(points - place, axis=1)
    assert np.abs(found - distance_to_surface(surface, points)).max() < 1e-12
    assert_in_face(surface, place, face)


def test_descent_agrees_with_the_global_search_near_the_surface():
    surface = patch(octant, 30, jitter=0.2)
    point, face = places(surface, 400)
    lifted = point * 1.05
    near = closest_point(surface, lifted, np.full(400, face[0]))
    anywhere = closest_point(surface, lifted)
    gap = np.linalg.norm(lifted - near[0], axis=1) - np.linalg.norm(lifted - anywhere[0], axis=1)
    assert gap.min() > -1e-12 and gap.max() < 1e-4  # facets make shallow local minima
    assert np.mean(gap < 1e-12) > 0.95


def test_single_triangle_and_no_points():
    surface = build_surface([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    place, face = closest_point(surface, [[2, 2, 1], [-1, -1, 0], [0.2, 0.2, 3]])
    assert np.allclose(place, [[0.5, 0.5, 0], [0, 0, 0], [0.2, 0.2, 0]])
    assert (face == 0).all()
    empty, no_face = closest_point(surface, np.zeros((0, 3)))
    assert empty.shape == (0, 3) and no_face.shape == (0,)
    assert walk(surface, empty, no_face, empty)[0].shape == (0, 3)


def test_normals_and_planarity():
    surface = patch(octant, 30)
    point, face = places(surface, 100)
    radial = point / np.linalg.norm(point, axis=1, keepdims=True)
    assert (surface_normal(surface, face, point) * radial).sum(1).min() > 0.999
    assert plane_normal(surface) is None
    assert plane_normal(patch(bump, 9)) is None
    assert np.allclose(plane_normal(patch(annulus, 24, 4, closed=True)), [0, 0, 1])
