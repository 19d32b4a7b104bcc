"""Vertices that are one point in space become one vertex of the mesh.

Three rules. On request: all vertices within a distance. Always: the two ends of an edge without
length, and the vertices of loose faces, those that share no vertex with any other face, as in STL
files, whose faces would otherwise never meet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..surface.projection import expand_ranges
from ..surface.surface import connected_components
from .polygons import Polygons

_SHORT = 1e-10  # of the longest edge of its polygon: an edge that counts as a point
_LOOSE = 1e-6  # of the mesh's size: corners of loose faces this close are one
_LOOSE_EDGE = 0.1  # of the shortest edge of loose faces, which sets a lower limit
_MOST_PAIRS = 20_000_000  # pairs within the welding distance that memory allows


@dataclass(frozen=True)
class Weld:
    """Which vertices are one.

    target      (U,) int64, the vertex that each is merged into: the one of least number
    requested   number of vertices that went by the distance asked for
    loose       number that went because their faces were loose
    short       number that went with an edge without length
    """

    target: np.ndarray
    requested: int
    loose: int
    short: int


def find_weld(points: np.ndarray, polygons: Polygons, distance: float, repair: bool) -> Weld:
    """Vertices to merge.

    points    (U, 3) float64 in a box of size 1; only used ones matter
    distance  in the lengths of `points`; 0 welds nothing on request
    repair    False leaves all but the request undone

    Raises InputError for a distance that would weld far too much.
    """
    used = np.unique(polygons.corner)
    pairs = [_pairs_within(points, used, distance) if distance > 0 else np.zeros((0, 2), np.int64)]
    if repair:
        pairs.append(_loose_pairs(points, polygons))
        pairs.append(_short_edges(points, polygons))
    target, counts = np.arange(len(points)), []
    for some in pairs:
        if not len(some):
            counts.append(0)
            continue
        before = np.count_nonzero(target == np.arange(len(points)))
        first, second = target[some].T
        component = connected_components(len(points), first, second)
        target = np.unique(component, return_index=True)[1][component[target]]
        counts.append(before - np.count_nonzero(target == np.arange(len(points))))
    return Weld(target, *(counts + [0, 0])[:3])


def _loose_pairs(points, polygons):
    """Pairs (n, 2) of vertices of loose faces that lie in one place."""
    faces_at = np.bincount(polygons.corner, minlength=len(points))
    shared = np.bincount(polygons.corner_polygon, faces_at[polygons.corner] > 1, polygons.count)
    corner = (shared == 0)[polygons.corner_polygon]
    if not corner.any():
        return np.zeros((0, 2), np.int64)
    edge = np.linalg.norm(points[polygons.following] - points[polygons.corner], axis=1)[corner]
    shortest = edge[edge > _SHORT].min(initial=1.0)
    return _pairs_within(points, polygons.corner[corner], min(_LOOSE, _LOOSE_EDGE * shortest))


def _short_edges(points, polygons):
    """Pairs (n, 2) of the ends of edges without length."""
    start, end = polygons.corner, polygons.following
    length = np.linalg.norm(points[end] - points[start], axis=1)
    longest = np.zeros(polygons.count)
    np.maximum.at(longest, polygons.corner_polygon, length)
    short = (length <= _SHORT * longest[polygons.corner_polygon]) & (start != end)
    return np.stack([start[short], end[short]], axis=1)


def _pairs_within(points, member, distance):
    """Pairs (n, 2) of the given vertices (m,) that lie no farther apart than distance.

    Found through a grid whose cells are a little wider than the distance: only neighbouring cells
    are compared.
    """
    # At most a million cells along each axis, so that their numbers fit an int64.
    cell = np.floor((points[member] - points[member].min(0)) / (1.01 * max(distance, 1e-6)))
    cell = cell.astype(np.int64) + 1
    stride = np.cumprod([1, *(cell.max(0) + 2)[:2]])
    key = cell @ stride
    order = np.argsort(key, kind="stable")
    member, key = member[order], key[order]
    pairs = []
    for step in _half_of_the_neighbours() @ stride:
        first = np.searchsorted(key, key + step, side="left")
        last = np.searchsorted(key, key + step, side="right")
        if step == 0:
            first = np.arange(1, len(key) + 1)
        if (last - first).sum() > _MOST_PAIRS:
            raise InputError(
                f"The welding distance is so large that more than {_MOST_PAIRS:,} pairs of"
                " vertices lie within it; choose a distance shorter than the edges."
            )
        one, two = expand_ranges(first, last)
        near = np.linalg.norm(points[member[one]] - points[member[two]], axis=1) <= distance
        pairs.append(np.stack([member[one[near]], member[two[near]]], axis=1))
    return np.concatenate(pairs)


def _half_of_the_neighbours():
    """(14, 3) steps to the cell itself and to one of each opposite pair of neighbours."""
    step = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    return step[13:]
