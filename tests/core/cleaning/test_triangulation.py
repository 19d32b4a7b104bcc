"""Polygons cut into triangles: areas, orientation, no edge twice."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cleaning.polygons import as_polygons
from core.cleaning.triangulation import triangulate
from core.errors import InputError
from core.surface.surface import build_surface


def flat(points):
    return np.c_[np.asarray(points, float), np.zeros(len(points))]


def cut(points, polygons):
    points = np.asarray(points, float)
    return triangulate(points, as_polygons(polygons))


def areas(points, triangles):
    a, b, c = (np.asarray(points, float)[triangles[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)[:, 2]


def polygon_area(points):
    x, y = np.asarray(points, float)[:, :2].T
    return 0.5 * (x * np.roll(y, -1) - np.roll(x, -1) * y).sum()


def star(size, inner, turn=0.1):
    radius = np.where(np.arange(size) % 2, inner, 1.0)
    angle = 2 * np.pi * np.arange(size) / size + turn
    return flat(np.c_[radius * np.cos(angle), radius * np.sin(angle)])


SHAPES = {
    "square": flat([(0, 0), (1, 0), (1, 1), (0, 1)]),
    "dart": flat([(0, 0), (2, 1), (0, 2), (0.3, 1)]),
    "dart turned": flat([(2, 1), (0, 2), (0.3, 1), (0, 0)]),
    "quad with a flat corner": flat([(0, 0), (1, 0), (2, 0), (1, 3)]),
    "quad with a flat corner, turned": flat([(1, 0), (2, 0), (1, 3), (0, 0)]),
    "L": flat([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]),
    "comb": flat(
        [(0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (5, 1), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3),
         (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
    ),
    "triangle with points on its sides": flat(
        [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (3, 1), (2, 2), (0, 4), (0, 3), (0, 2), (0, 1)]
    ),
    "star": star(16, 0.3),
    "thin star": star(40, 0.05),
    "spiral": flat(
        [(0, 0), (6, 0), (6, 6), (0, 6), (0, 2), (4, 2), (4, 4), (2, 4), (2, 3), (3, 3), (3, 2.5),
         (1, 2.5), (1, 5), (5, 5), (5, 1), (0, 1)]
    ),
    "circle": star(200, 1.0),
}  # fmt: skip


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("turn", [0, 3])
def test_pieces_fill_the_polygon_without_overlap(name, turn):
    points = SHAPES[name]
    polygon = np.roll(np.arange(len(points)), turn)
    triangles, origin = cut(points, [polygon])
    assert len(triangles) == len(points) - 2
    assert not origin.any()
    assert areas(points, triangles).min() > 0
    assert areas(points, triangles).sum() == pytest.approx(polygon_area(points), rel=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_orientation_and_plane_do_not_matter(name):
    points = SHAPES[name]
    rotation = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    polygon = np.arange(len(points))[::-1]
    triangles, _ = cut(points @ rotation.T, [polygon])
    assert areas(points, triangles).max() < 0
    assert areas(points, triangles).sum() == pytest.approx(-polygon_area(points), rel=1e-12)


@settings(deadline=None, max_examples=60)
@given(st.lists(st.floats(0.1, 1), min_size=4, max_size=24))
def test_star_shaped_polygons(radius):
    angle = 2 * np.pi * np.arange(len(radius)) / len(radius)
    points = flat(np.c_[radius * np.cos(angle), radius * np.sin(angle)])
    triangles, _ = cut(points, [np.arange(len(radius))])
    assert areas(points, triangles).sum() == pytest.approx(polygon_area(points), rel=1e-9)
    assert areas(points, triangles).min() > -1e-9


def test_polygons_of_all_sizes_keep_their_order():
    sizes = [4, 3, 7, 4, 5, 3, 12, 5]
    points, polygons = [], []
    for number, size in enumerate(sizes):
        polygons.append(list(range(len(points), len(points) + size)))
        points.extend(star(size, 1.0)[:, :3] + [3 * number, 0, 0])
    triangles, origin = cut(points, polygons)
    assert origin.tolist() == [n for n, size in enumerate(sizes) for _ in range(size - 2)]
    for number, polygon in enumerate(polygons):
        assert set(triangles[origin == number].ravel()) == set(polygon)


def test_triangles_stay_as_they_are():
    points = np.random.default_rng(0).random((6, 3))
    triangles, origin = cut(points, [[2, 0, 1], [3, 5, 4]])
    assert triangles.tolist() == [[2, 0, 1], [3, 5, 4]]
    assert origin.tolist() == [0, 1]


def test_shorter_way_across_a_quad():
    points = flat([(0, 0), (3, -1), (6, 0), (3, 1)])
    triangles, _ = cut(points, [[0, 1, 2, 3]])
    assert all({1, 3} <= set(t) for t in triangles.tolist())


def test_two_quads_that_share_two_edges():
    """A vertex with two quads: the same diagonal in both would be an edge of four triangles."""
    points = [(0, 0, 0), (1, 1, 0), (2, 0, 0), (1, -1, 0.2), (1, 3, 0.2)]
    triangles, _ = cut(points, [[0, 3, 2, 1], [2, 4, 0, 1]])
    surface = build_surface(points, triangles)
    assert surface.euler_characteristic == 1


def test_pillow_of_two_polygons():
    """Two polygons back to back: every diagonal may be used on one side only."""
    points = star(8, 1.0)
    triangles, _ = cut(points, [list(range(8)), list(range(8))[::-1]])
    surface = build_surface(points, triangles)
    assert surface.euler_characteristic == 2 and surface.loop_count == 0


def test_diagonal_that_is_an_edge_elsewhere():
    points = flat([(0, 0), (1, -0.1), (1, 1), (0, 1.1), (2, 2)])
    alone, _ = cut(points, [[0, 1, 2, 3]])
    beside, origin = cut(points, [[0, 1, 2, 3], [0, 2, 4]])
    assert all({0, 2} <= set(t) for t in alone.tolist())
    assert all({1, 3} <= set(t) for t in beside[origin == 0].tolist())


def test_quad_whose_corners_are_all_joined_is_refused():
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 3), (0, 0, -3)]
    with pytest.raises(InputError, match="Polygon 0 cannot be cut"):
        cut(points, [[0, 1, 2, 3], [0, 2, 4], [1, 3, 5]])


def test_grid_of_quads_in_little_time():
    n = 320
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], -1)
    grid = np.stack(np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"), -1)
    points = flat(grid.reshape(-1, 2))
    start = time.process_time()
    triangles, _ = cut(points, quads.reshape(-1, 4))
    assert time.process_time() - start < 1.0
    assert areas(points, triangles).min() == pytest.approx(0.5)
