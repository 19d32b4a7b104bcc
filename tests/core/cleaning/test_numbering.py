"""The order of elements follows from the shape: the same for every file that holds it."""

import numpy as np
import pytest

from core.cleaning.cleaning import clean
from core.cleaning.numbering import numbered, walk
from core.pipeline import decompose
from core.settings import Settings
from tests.core import creased
from tests.core.surfaces import annulus, crumpled, plate_with_holes, sphere, together, torus

SHAPES = {
    "plate": plate_with_holes(),
    "scan": crumpled(sphere(6), 0.02),
    "torus": crumpled(torus(), 0.02),
    "two parts": together(crumpled(annulus(24, 6), 0.01), crumpled(torus(), 0.01)),
}


def shuffled(points, triangles, seed):
    """The same surface in another order: vertices, triangles, and where each triangle starts."""
    random = np.random.default_rng(seed)
    vertex = random.permutation(len(points))
    triangles = np.argsort(vertex)[triangles[random.permutation(len(triangles))]]
    start = random.integers(3, size=(len(triangles), 1))
    return points[vertex], np.take_along_axis(triangles, (start + np.arange(3)) % 3, 1)


def turned(points, seed):
    """Points turned, moved and made larger."""
    rotation = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    return 1000 * points @ rotation.T + [3, -4, 500]


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("seed", range(3))
def test_same_order_whatever_the_file(name, seed):
    shape = SHAPES[name]
    here = numbered(clean(shape.points, shape.triangles))
    there = numbered(clean(*shuffled(shape.points, shape.triangles, seed)))
    assert np.array_equal(here.points, there.points)
    assert np.array_equal(here.triangles, there.triangles)


@pytest.mark.parametrize("name", SHAPES)
def test_same_order_wherever_it_lies(name):
    shape = SHAPES[name]
    points, triangles = shuffled(turned(shape.points, 7), shape.triangles, 8)
    here, there = numbered(clean(shape.points, shape.triangles)), numbered(clean(points, triangles))
    assert np.array_equal(here.triangles, there.triangles)


@pytest.mark.parametrize("name", SHAPES)
def test_it_is_the_same_mesh(name):
    shape = SHAPES[name]
    before = clean(shape.points, shape.triangles)
    after = numbered(before)
    assert np.array_equal(after.points, shape.points[after.vertex_origin])
    given = np.sort(shape.triangles[after.face_origin], axis=1)
    assert np.array_equal(given, np.sort(after.vertex_origin[after.triangles], axis=1))
    assert np.array_equal(np.sort(after.face_origin), np.arange(shape.face_count))
    a, b, c = (after.points[after.triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    assert ((normal * shape.face_normal[after.face_origin]).sum(1) > 0).all()


def test_the_walk_goes_from_neighbour_to_neighbour_and_part_by_part():
    shape = SHAPES["two parts"]
    entry = walk(shape.points, shape.triangles)
    assert np.array_equal(np.sort(entry // 3), np.arange(shape.face_count))
    part = shape.component[entry // 3]
    starts = np.flatnonzero(np.diff(part, prepend=-1))
    assert len(starts) == shape.component_count
    place = np.empty(shape.face_count, np.int64)
    place[entry // 3] = np.arange(shape.face_count)
    entered = np.delete(np.arange(shape.face_count), starts)
    came_from = shape.twin[entry[entered]]
    assert (came_from >= 0).all() and (place[came_from // 3] < entered).all()


def test_creases_and_blocks_do_not_depend_on_the_order():
    shape = creased.block()
    settings = Settings(quad_count=600)
    results = [
        decompose(points, triangles, settings)
        for points, triangles in (
            (shape.points, shape.triangles),
            shuffled(shape.points, shape.triangles, 1),
            shuffled(turned(shape.points, 2), shape.triangles, 3),
        )
    ]
    assert len({r.blocks.count for r in results}) == 1
    assert len({len(r.quads.quads) for r in results}) == 1
    assert len({len(r.singularities) for r in results}) == 1
