"""Arrival distance against exact distances, and against fast marching with a heap."""

import heapq
import time

import numpy as np
import pytest

from core.field.distance import arrival_distance
from core.surface.surface import build_surface
from tests.core.surfaces import (
    crumpled,
    cylinder,
    disc,
    lshape,
    octant,
    plate,
    regular_polygon,
    sphere,
    together,
    torus,
)


def square(n, jitter=0.2):
    return plate(np.ones((n, n)), 1 / n, jitter)


def vertex_mask(surface, vertex):
    return np.arange(surface.vertex_count) == vertex


def nearest_vertex(surface, place):
    return int(np.argmin(np.linalg.norm(surface.points - place, axis=1)))


def sequential_marching(surface, sources):
    """Fast marching one vertex at a time with a heap, on triangles as they are."""
    points, around = surface.points, [[] for _ in range(surface.vertex_count)]
    for triangle in surface.triangles.tolist():
        for c in range(3):
            around[triangle[c]].append((triangle[c - 2], triangle[c - 1]))
    distance = np.where(sources, 0.0, np.inf)
    heap = [(0.0, v) for v in np.flatnonzero(sources).tolist()]
    done = set()
    while heap:
        _, vertex = heapq.heappop(heap)
        if vertex in done:
            continue
        done.add(vertex)
        for pair in around[vertex]:
            for target, other in (pair, pair[::-1]):
                value = distance[vertex] + np.linalg.norm(points[target] - points[vertex])
                if other in done:
                    value = min(value, through_edge(points, distance, target, vertex, other))
                if target not in done and value < distance[target]:
                    distance[target] = value
                    heapq.heappush(heap, (value, target))
    return distance


def through_edge(points, distance, target, a, b):
    """Smallest distance over all points of the edge, by Fermat's principle and ternary search."""
    low, high = 0.0, 1.0

    def arrival(t):
        point = (1 - t) * points[a] + t * points[b]
        return (1 - t) * distance[a] + t * distance[b] + np.linalg.norm(points[target] - point)

    for _ in range(60):
        left, right = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, right) if arrival(left) < arrival(right) else (left, high)
    return arrival(0.5 * (low + high))


@pytest.mark.parametrize("n", [5, 16])
def test_plane_front_is_exact(n):
    """Acute elements and split corners carry a linear distance without error."""
    surface = square(n, 0.3)
    x = surface.points[:, 0]
    arrival = arrival_distance(surface, x == 0)
    inner = (surface.points[:, 1] > 0.3) & (surface.points[:, 1] < 0.7) & (x < 0.5)
    assert np.abs(arrival.distance - x)[inner].max() < 1e-12
    assert np.abs(arrival.distance - x).mean() < 0.01 / n


def test_distance_from_the_sides_of_a_square():
    errors = []
    for n in (16, 32, 64):
        surface = square(n)
        x, y = surface.points[:, 0], surface.points[:, 1]
        exact = np.minimum(np.minimum(x, 1 - x), np.minimum(y, 1 - y))
        error = np.abs(arrival_distance(surface, surface.on_boundary).distance - exact)
        assert error.max() < 0.5 / n
        errors.append(error.mean())
    assert errors[2] < 0.6 * errors[1] < 0.36 * errors[0]


def test_disc_converges():
    errors = []
    for rings in (8, 16, 32):
        surface = disc(rings)
        exact = 1 - np.linalg.norm(surface.points, axis=1)
        distance = arrival_distance(surface, surface.on_boundary).distance
        errors.append(np.abs(distance - exact).mean())
    assert errors[2] < 0.6 * errors[1] < 0.36 * errors[0]


@pytest.mark.parametrize(
    "make, centre, distance",
    [
        (square, (0.5, 0.5, 0), lambda p, c: np.linalg.norm(p - c, axis=1)),
        (square, (0, 0, 0), lambda p, c: np.linalg.norm(p - c, axis=1)),
        (sphere, (0, 0, 1), lambda p, c: np.arccos(np.clip(p @ c, -1, 1))),
        (octant, (0, 0, 1), lambda p, c: np.arccos(np.clip(p @ c, -1, 1))),
    ],
)
def test_single_source_converges(make, centre, distance):
    """At a point source the error is of order h log(1 / h): the front is a cone there."""
    errors = []
    for n in (8, 16, 40):
        surface = make(n)
        source = nearest_vertex(surface, centre)
        arrival = arrival_distance(surface, vertex_mask(surface, source))
        error = arrival.distance - distance(surface.points, surface.points[source])
        assert np.abs(error).max() < surface.edge_length.max()
        errors.append(np.abs(error).mean())
    assert errors[1] < 0.85 * errors[0] and errors[2] < 0.6 * errors[0]


def test_geodesics_bend_round_a_corner():
    errors = []
    for n in (8, 16, 32):
        surface = lshape(n)
        source = nearest_vertex(surface, (2, 0, 0))
        start, corner = surface.points[source], np.array([1.0, 1.0, 0])
        hidden = (surface.points[:, 0] < 1) & (surface.points[:, 1] > 1.2)
        hidden &= (surface.points - corner)[:, :2] @ [1, 1] > 0.05
        exact = np.linalg.norm(corner - start) + np.linalg.norm(surface.points - corner, axis=1)
        arrival = arrival_distance(surface, vertex_mask(surface, source))
        errors.append(np.abs(arrival.distance - exact)[hidden].mean())
    assert errors[2] < 0.8 * errors[1] < 0.7 * errors[0]


def test_ring_round_a_cylinder():
    surface = cylinder(40, 30, height=3.0)
    height = surface.points[:, 2]
    arrival = arrival_distance(surface, height == 0)
    assert np.abs(arrival.distance - height).max() < 1e-12


@pytest.mark.parametrize("ratio, shear", [(8, 0), (6, 0.7), (15, 0.2)])
def test_needles_converge(ratio, shear):
    errors = []
    for n in (16, 32, 64):
        surface = square(n)
        points = surface.points.copy()
        points[:, 0] += shear * points[:, 1]
        points[:, 1] /= ratio
        surface = build_surface(points, surface.triangles)
        source = nearest_vertex(surface, points.mean(0))
        exact = np.linalg.norm(points - points[source], axis=1)
        arrival = arrival_distance(surface, vertex_mask(surface, source))
        errors.append(np.abs(arrival.distance - exact).mean())
        assert errors[-1] < 0.3 * surface.edge_length.max()
    assert errors[2] < 0.65 * errors[0]


@pytest.mark.parametrize(
    "surface", [octant(14), sphere(7), regular_polygon(6, 12, 0.1), square(12, 0.0)]
)
def test_agrees_with_marching_by_heap(surface):
    """On acute triangles, where both solve the same equations."""
    assert surface.corner_angle.max() < np.radians(100)
    sources = surface.on_boundary
    if not sources.any():
        sources = vertex_mask(surface, 3)
    expected = sequential_marching(surface, sources)
    difference = np.abs(arrival_distance(surface, sources).distance - expected)
    assert difference.max() < 0.1 * surface.mean_edge_length
    assert difference.mean() < 0.02 * surface.mean_edge_length


@pytest.mark.parametrize(
    "surface",
    [crumpled(sphere(8), 1.0), crumpled(octant(12), 1.0), torus(), square(20, 0.45), lshape(9)],
)
def test_parents_are_strictly_nearer(surface):
    sources = surface.on_boundary if surface.loop_count else vertex_mask(surface, 5)
    arrival = arrival_distance(surface, sources)
    assert np.isfinite(arrival.distance).all()
    other = ~arrival.source
    nearer = arrival.distance[arrival.parent[other]] < arrival.distance[other, None]
    assert nearer.all()
    assert np.array_equal(arrival.source, sources)
    assert (arrival.distance[sources] == 0).all()
    assert (arrival.parent[sources] == np.flatnonzero(sources)[:, None]).all()
    single = other & (arrival.parent[:, 0] == arrival.parent[:, 1])
    assert (arrival.base[single] == 0).all() and (arrival.base[other & ~single] > 0).all()
    assert (arrival.apex[other, 0] ** 2 + arrival.apex[other, 1] ** 2 > 0).all()


def test_distance_never_exceeds_the_way_along_edges():
    surface = crumpled(octant(12), 1.0)
    distance = arrival_distance(surface, surface.on_boundary).distance
    longest = distance[surface.tail] + surface.edge_length
    assert (distance[surface.head] <= longest + 1e-12).all()


def test_components_without_source_start_at_their_first_vertex():
    surface = together(disc(4), sphere(4), octant(4))
    arrival = arrival_distance(surface, surface.on_boundary)
    started = np.flatnonzero(arrival.source & ~surface.on_boundary)
    assert started.tolist() == [disc(4).vertex_count]
    assert np.isfinite(arrival.distance).all()


def test_scale_and_numbering_do_not_matter():
    surface = lshape(8)
    arrival = arrival_distance(surface, surface.on_boundary)
    order = np.random.default_rng(0).permutation(surface.vertex_count)
    place = np.argsort(order)
    moved = build_surface(1e-6 * surface.points[order], place[surface.triangles])
    again = arrival_distance(moved, moved.on_boundary)
    assert 1e6 * again.distance == pytest.approx(arrival.distance[order], abs=1e-9)


def test_hundred_thousand_triangles_in_a_second():
    surface = square(224)
    start = time.process_time()
    arrival_distance(surface, surface.on_boundary)
    assert time.process_time() - start < 1.0
