"""The working surface lies where the given one lies, is fine enough, and knows where it is from."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cleaning.cleaning import clean
from core.surface.resolution import ENOUGH, LEAST_WANTED, MOST, WANTED, refine
from core.surface.surface import build_surface
from tests.core.surfaces import crumpled, cylinder, disc, lshape, octant, sphere, together, torus


def prepared(points, polygons):
    mesh = clean(points, polygons)
    return build_surface(mesh.points, mesh.triangles), mesh.face_origin


def ring(sides, radius=1.0, height=0.0):
    angle = 2 * np.pi * np.arange(sides) / sides
    return np.c_[radius * np.cos(angle), radius * np.sin(angle), np.full(sides, height)]


def capped_cylinder(sides, radius=1.0, height=2.0):
    points = np.concatenate([ring(sides, radius), ring(sides, radius, height)])
    around = np.arange(sides)
    after = (around + 1) % sides
    walls = np.stack([around, after, sides + after, sides + around], 1).tolist()
    return points, [around[::-1].tolist(), (sides + around).tolist(), *walls]


SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
CUBE = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
CUBE_FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]

COARSE = {
    "one quad": (SQUARE, [[0, 1, 2, 3]]),
    "one triangle": (SQUARE[:3], [[0, 1, 2]]),
    "bent quad": (SQUARE + [[0, 0, 0.3], [0, 0, 0], [0, 0, 0.3], [0, 0, 0]], [[0, 1, 2, 3]]),
    "cube": (CUBE, CUBE_FACES),
    "dodecagon": (ring(12), [list(range(12))]),
    "cylinder": capped_cylinder(32),
    "long cylinder": capped_cylinder(32, 0.05, 5.0),
    "crumpled": (crumpled(sphere(3), 0.3).points, sphere(3).triangles.tolist()),
    "two": (together(octant(2), disc(2)).points, together(octant(2), disc(2)).triangles.tolist()),
}


@pytest.mark.parametrize("name", COARSE)
def test_coarse_meshes_become_fine_enough(name):
    given, polygon = prepared(*COARSE[name])
    fine = refine(given, polygon)
    surface = fine.surface
    faces = np.bincount(surface.component)
    assert faces.min() >= LEAST_WANTED / 2
    assert faces.max() >= WANTED / 2
    assert surface.face_count < 20 * WANTED
    # No edge is longer than that of the equilateral triangles that would be half as many.
    area = np.bincount(surface.component, surface.face_area)
    most = np.sqrt(4 / np.sqrt(3) * area / (LEAST_WANTED / 2))
    assert (surface.edge_length <= np.repeat(most[surface.component], 3)).all()


@pytest.mark.parametrize("name", COARSE)
def test_the_surface_does_not_move(name):
    given, polygon = prepared(*COARSE[name])
    fine = refine(given, polygon)
    surface = fine.surface
    assert np.array_equal(surface.points[: given.vertex_count], given.points)
    assert surface.euler_characteristic == given.euler_characteristic
    assert (surface.loop_count, surface.component_count) == (
        given.loop_count,
        given.component_count,
    )
    # Each polygon keeps its area, the triangles of a polygon their plane.
    before = np.bincount(polygon, given.face_area)
    assert np.bincount(fine.face_origin, surface.face_area) == pytest.approx(before)
    volume = [
        np.einsum("ni,ni->n", s.points[s.triangles].sum(1), np.cross(*edges(s))).sum()
        for s in (given, surface)
    ]
    assert volume[0] == pytest.approx(volume[1], abs=1e-9)


def edges(surface):
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    return b - a, c - a


@pytest.mark.parametrize("name", COARSE)
def test_halfedges_know_the_one_they_lie_on(name):
    given, polygon = prepared(*COARSE[name])
    fine = refine(given, polygon)
    surface, origin = fine.surface, fine.halfedge_origin
    lies = origin >= 0
    start, step = given.points[given.tail[origin[lies]]], direction(given)[origin[lies]]
    for end in (surface.tail, surface.head):
        off = surface.points[end[lies]] - start
        assert np.abs(np.cross(off, step)).max() < 1e-12
    assert (direction(surface)[lies] * step).sum(1).min() > 0.999
    # Edges between polygons are covered from end to end, on both sides.
    beyond = np.where(given.twin >= 0, polygon[given.twin // 3], -1)
    between = beyond != np.repeat(polygon, 3)
    covered = np.bincount(origin[lies], surface.edge_length[lies], len(given.twin))
    assert covered[between] == pytest.approx(given.edge_length[between])
    marked = fine.on_edges(between)
    assert np.array_equal(marked[surface.twin >= 0], marked[surface.twin[surface.twin >= 0]])


def direction(surface):
    step = surface.points[surface.head] - surface.points[surface.tail]
    return step / surface.edge_length[:, None]


@pytest.mark.parametrize(
    "surface", [torus(40, 30), octant(24), disc(14), sphere(12), cylinder(60, 30), lshape(16)]
)
def test_fine_meshes_pass_untouched(surface):
    assert surface.face_count >= ENOUGH
    polygon = np.arange(surface.face_count)
    fine = refine(surface, polygon)
    assert fine.surface is surface
    assert fine.face_origin is polygon
    assert np.array_equal(fine.halfedge_origin, np.arange(3 * surface.face_count))


def test_only_the_coarse_component_is_refined():
    surface = together(octant(20), octant(2))
    fine = refine(surface, np.arange(surface.face_count))
    count = np.bincount(fine.surface.component)
    assert count[0] == 400 or count[0] > ENOUGH
    assert count[1] > WANTED / 2


def sheared(columns, rows, shear):
    """A flat parallelogram of obtuse needles, each triangle a polygon of its own."""
    i, j = np.meshgrid(np.arange(columns + 1), np.arange(rows + 1), indexing="ij")
    points = np.c_[(i + shear * j).ravel(), j.ravel(), np.zeros(i.size)]
    first = (i * (rows + 1) + j)[:-1, :-1].ravel()
    a, b, c, d = first, first + rows + 1, first + rows + 2, first + 1
    return build_surface(points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


def test_flat_needles_are_flipped_and_kept_edges_are_not():
    surface = sheared(60, 8, 6)
    polygon = np.arange(surface.face_count)
    fine = refine(surface, polygon)
    before, after = (np.median(s.corner_angle.max()) for s in (surface, fine.surface))
    assert after < before - 0.2
    assert fine.surface.face_area.sum() == pytest.approx(surface.face_area.sum())
    kept = np.ones(len(surface.twin), bool)
    fine = refine(surface, polygon, kept)
    covered = np.bincount(
        fine.halfedge_origin[fine.halfedge_origin >= 0],
        fine.surface.edge_length[fine.halfedge_origin >= 0],
        len(surface.twin),
    )
    assert covered == pytest.approx(surface.edge_length)


@pytest.mark.parametrize("noise, flips", [(1e-8, True), (1e-5, False)])
def test_flat_but_for_rounding_counts_as_flat(noise, flips):
    """Coordinates of single precision, as STL and PLY files hold them, are as far from flat."""
    flat = sheared(60, 8, 6)
    points = flat.points / flat.diameter
    points[:, 2] = noise * np.random.default_rng(4).uniform(-1, 1, len(points))
    surface = build_surface(points, flat.triangles)
    fine = refine(surface, np.arange(surface.face_count)).surface
    assert (np.median(fine.corner_angle.max()) < surface.corner_angle.max() - 0.2) == flips
    assert np.ptp(fine.points[:, 2]) <= 2 * noise


def test_extreme_proportions_stay_bounded():
    strip = SQUARE * [1e6, 1, 1]
    surface, polygon = prepared(strip, [[0, 1, 2, 3]])
    assert refine(surface, polygon).surface.face_count <= MOST + 2
    fan = build_surface(
        np.concatenate([[(0, 0, 1e4)], ring(200)]),
        [(0, k + 1, (k + 1) % 200 + 1) for k in range(200)],
    )
    assert refine(fan, np.arange(200)).surface.face_count <= MOST + 2


def test_many_small_components():
    surface = together(*[octant(1)] * 30)
    fine = refine(surface, np.arange(30)).surface
    assert fine.component_count == 30 and fine.face_count <= MOST


@settings(deadline=None, max_examples=20, derandomize=True)
@given(st.integers(0, 10**6), st.integers(3, 14))
def test_random_star_polygons(seed, corners):
    """Any star-shaped polygon: same area, same outline, every triangle counter-clockwise."""
    random = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(corners) + 0.4 * random.random(corners)) / corners
    radius = 10.0 ** random.uniform(-1, 0, corners)
    points = np.c_[radius * np.cos(angle), radius * np.sin(angle), np.zeros(corners)]
    surface, polygon = prepared(points, [list(range(corners))])
    fine = refine(surface, polygon).surface
    assert fine.face_area.sum() == pytest.approx(surface.face_area.sum())
    length = [s.edge_length[s.loop_halfedges].sum() for s in (surface, fine)]
    assert length[0] == pytest.approx(length[1])
    assert fine.face_normal[:, 2].min() > 0.9
    assert WANTED / 2 < fine.face_count < MOST
