"""Polygons as flat arrays, from everything a caller may hand over."""

import numpy as np
import pytest

from core.cleaning.polygons import Polygons, as_polygons
from core.errors import InputError

MIXED = [[0, 1, 2], [2, 1, 3, 4], [4, 3, 5, 6, 7], [7, 6, 8]]


@pytest.mark.parametrize(
    "given", [MIXED, tuple(map(tuple, MIXED)), [np.array(p, np.int32) for p in MIXED]]
)
def test_lists_of_any_kind(given):
    polygons = as_polygons(given)
    assert polygons.count == 4
    assert polygons.size.tolist() == [3, 4, 5, 3]
    assert polygons.as_lists() == MIXED
    assert polygons.corner_polygon.tolist() == [0] * 3 + [1] * 4 + [2] * 5 + [3] * 3
    assert polygons.following[:7].tolist() == [1, 2, 0, 1, 3, 4, 2]


@pytest.mark.parametrize("kind", [np.int8, np.uint32, np.int64, np.float64])
@pytest.mark.parametrize("size", [3, 4])
def test_arrays_come_back_as_arrays(kind, size):
    given = np.arange(5 * size).reshape(5, size).astype(kind)
    polygons = as_polygons(given)
    assert polygons.corner.dtype == np.int64
    assert np.array_equal(polygons.as_lists(), given)


def test_polygons_of_one_size():
    number, vertex = as_polygons(MIXED).of_size(3)
    assert number.tolist() == [0, 3]
    assert vertex.tolist() == [[0, 1, 2], [7, 6, 8]]
    assert as_polygons(MIXED).of_size(9)[1].shape == (0, 9)


def test_empty_polygons_do_not_disturb_their_neighbours():
    polygons = as_polygons([[], [0, 1, 2], [], [2, 1, 3], []])
    assert polygons.following.tolist() == [1, 2, 0, 1, 3, 2]


@pytest.mark.parametrize("given", [[], np.zeros((0, 3), int), np.zeros((0, 4))])
def test_no_polygons(given):
    polygons = as_polygons(given)
    assert polygons.count == 0 and len(polygons.corner) == 0


def test_given_polygons_are_handed_back():
    polygons = Polygons(np.array([0, 1, 2]), np.array([0, 3]))
    assert as_polygons(polygons) is polygons


@pytest.mark.parametrize(
    "given, message",
    [
        ([[0, 1, 2], [0, 1.5, 2]], "Polygon 1 refers to vertex 1.5"),
        ([[0, 1, np.nan]], "Polygon 0 refers to vertex nan"),
        ([[0, 1, np.inf]], "Polygon 0 refers to vertex inf"),
        ([["a", "b", "c"]], "Polygon 0 refers to vertex a"),
        ([3, 4], "neither an array"),
        ([[[0, 1], [2]]], "neither an array"),
    ],
)
def test_what_are_no_vertex_numbers(given, message):
    with pytest.raises(InputError, match=message):
        as_polygons(given)
