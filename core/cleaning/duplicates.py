"""Corners that a polygon passes twice, and polygons and triangles that are there twice."""

from __future__ import annotations

import numpy as np

from .polygons import Polygons


def find_repeated_corners(polygons: Polygons) -> np.ndarray:
    """Corners (n,) whose vertex their polygon has passed before."""
    owner = polygons.corner_polygon
    order = np.lexsort((polygons.corner, owner))
    corner, owner = polygons.corner[order], owner[order]
    again = (corner[1:] == corner[:-1]) & (owner[1:] == owner[:-1])
    return np.sort(order[1:][again])


def without_spikes(polygons: Polygons) -> Polygons:
    """The polygons with no corner equal to the next one, and none of the form a, b, a.

    Polygons may be left with fewer than three corners. Numbers of polygons stay.
    """
    while True:
        following = polygons.next_corner
        standing = polygons.corner[following] == polygons.corner
        if standing.any():
            polygons = polygons.kept(~_first_in_polygon(polygons, standing))
            continue
        second = following[following]
        spike = (polygons.corner[second] == polygons.corner) & (polygons.size > 2)[
            polygons.corner_polygon
        ]
        if not spike.any():
            return polygons
        gone = np.zeros(len(spike), bool)
        start = np.flatnonzero(_first_in_polygon(polygons, spike))
        gone[following[start]] = gone[second[start]] = True
        polygons = polygons.kept(~gone)


def _first_in_polygon(polygons, corner):
    """Of the marked corners the first one of each polygon."""
    marked = np.flatnonzero(corner)
    first = np.unique(polygons.corner_polygon[marked], return_index=True)[1]
    result = np.zeros(len(corner), bool)
    result[marked[first]] = True
    return result


def find_repeated_polygons(polygons: Polygons) -> np.ndarray:
    """Pairs (n, 2) of polygons with the same vertices: the first such, and the repetition."""
    pairs = [np.zeros((0, 2), np.int64)]
    for size in np.unique(polygons.size):
        number, vertex = polygons.of_size(size)
        pairs.append(number[find_repeated_rows(vertex)])
    pairs = np.concatenate(pairs)
    return pairs[np.argsort(pairs[:, 1], kind="stable")]


def find_repeated_rows(vertex: np.ndarray) -> np.ndarray:
    """Pairs (n, 2) of rows of vertex (m, size) that hold the same numbers: the first, the other."""
    vertex = np.sort(vertex, axis=1)
    order = np.lexsort(vertex.T)
    same = (vertex[order[1:]] == vertex[order[:-1]]).all(1)
    first = np.flatnonzero(np.concatenate([[True], ~same])) if len(order) else order
    group_first = np.repeat(order[first], np.diff(np.append(first, len(order))))
    again = group_first != order
    return np.stack([group_first[again], order[again]], axis=1)
