"""Polygons cut into triangles, concave ones too, without a diagonal that repeats an edge.

All polygons of one size are cut together: in each step every polygon loses its best ear, an ear
being a triangle of three consecutive corners that lies inside the polygon and holds no other
corner. A diagonal that joins vertices already joined elsewhere would give two halfedges with the
same ends, so such ears are passed over.
"""

from __future__ import annotations

import numpy as np

from ..errors import InputError
from .polygons import Polygons

_BLOCKED = -4.0  # added to the shape of an ear that other corners lie in
_REPEATED = -100.0  # shape of an ear whose diagonal repeats an edge
_INSIDE = 1e-12  # of the squared size of the polygon; closer than this counts as inside


def triangulate(
    points: np.ndarray, polygons: Polygons, may_repeat: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (F, 3) int64 and the polygon (F,) int64 of each, in ascending order.

    points      (V, 3) float64, finite and of moderate size
    polygons    at least three corners each, no vertex twice in a polygon
    may_repeat  repeat an edge where there is no other way, instead of raising InputError

    Triangles are oriented as their polygons. Raises InputError for a polygon that cannot be cut
    without repeating an edge.
    """
    if (polygons.size == 3).all():
        return polygons.corner.reshape(-1, 3), np.arange(polygons.count)
    forbidden = np.unique(_key(polygons.corner, polygons.following, len(points)))
    todo = np.ones(polygons.count, bool)
    triangles, origin = [], []
    while todo.any():
        new, new_origin, diagonal, owner = _cut(points, polygons, todo, forbidden, may_repeat)
        # Of several polygons that chose the same diagonal, the one of least number keeps it.
        order = np.argsort(owner, kind="stable")
        diagonal, owner = diagonal[order], owner[order]
        _, kept = np.unique(diagonal, return_index=True)
        todo = np.zeros(polygons.count, bool)
        todo[np.delete(owner, kept)] = True
        triangles.append(new[~todo[new_origin]])
        origin.append(new_origin[~todo[new_origin]])
        forbidden = np.union1d(forbidden, diagonal[~todo[owner]])
    triangles, origin = np.concatenate(triangles), np.concatenate(origin)
    order = np.argsort(origin, kind="stable")
    return triangles[order], origin[order]


def _key(first, second, vertex_count):
    """One number for each undirected edge."""
    return np.minimum(first, second) * np.int64(vertex_count) + np.maximum(first, second)


def _cut(points, polygons, chosen, forbidden, may_repeat):
    """Triangles, their polygons, the diagonals used (as keys) and their polygons."""
    results = []
    for size in np.unique(polygons.size[chosen]):
        number, vertex = polygons.of_size(size)
        number, vertex = number[chosen[number]], vertex[chosen[number]]
        results.append(_cut_ears(points, number, vertex, forbidden, may_repeat))
    return tuple(np.concatenate(column) for column in zip(*results))


def _cut_ears(points, number, vertex, forbidden, may_repeat):
    """The same as `_cut` for polygons of one size; vertex (n, size)."""
    row, triangles, diagonals = np.arange(len(number)), [], []
    if vertex.shape[1] > 3:
        plane = _in_own_plane(points[vertex])
        shape = _ear_shapes(plane, vertex, forbidden, len(points))
    while vertex.shape[1] > 3:
        shape = _refreshed(shape, plane, vertex, forbidden, len(points))
        # The two ways to cut a quad: an ear is as good as the worse of both halves.
        value = np.minimum(shape, np.roll(shape, 2, axis=1)) if vertex.shape[1] == 4 else shape
        ear = _first_best(value)
        if not may_repeat:
            _refuse_repetition(value[row, ear], number)
        before, after = (ear - 1) % vertex.shape[1], (ear + 1) % vertex.shape[1]
        triangles.append(np.stack([vertex[row, c] for c in (before, ear, after)], axis=1))
        diagonals.append(_key(vertex[row, before], vertex[row, after], len(points)))
        keep = np.arange(vertex.shape[1]) != ear[:, None]
        shrunk = (len(row), vertex.shape[1] - 1)
        vertex, plane, shape = (a[keep].reshape(shrunk) for a in (vertex, plane, shape))
        if vertex.shape[1] > 3:
            for corner in ((ear - 1) % shrunk[1], ear % shrunk[1]):
                shape[row, corner] = _ear_shape(plane, vertex, forbidden, len(points), corner)
    triangles.append(vertex)
    cuts = np.concatenate([*diagonals, np.zeros(0, np.int64)])
    origin = np.tile(number, len(triangles))
    return np.concatenate(triangles), origin, cuts, np.tile(number, len(diagonals))


def _first_best(value):
    """Column of the largest value in each row; the first one among nearly equal ones."""
    return np.argmax(value >= value.max(1, keepdims=True) - 1e-9, axis=1)


def _refuse_repetition(value, number):
    impossible = value <= _REPEATED / 2
    if impossible.any():
        raise InputError(
            f"Polygon {number[np.argmax(impossible)]} cannot be cut into triangles because its"
            " neighbours already join its corners; triangulate it by hand or add a vertex in it."
        )


def _refreshed(shape, plane, vertex, forbidden, vertex_count):
    """Shapes judged anew in polygons without any free ear: an ear once blocked may be free now."""
    stuck = np.flatnonzero(shape.max(1) <= 0)
    if len(stuck):
        shape[stuck] = _ear_shapes(plane[stuck], vertex[stuck], forbidden, vertex_count)
    return shape


def _ear_shapes(plane, vertex, forbidden, vertex_count):
    """(n, size) shapes of all ears."""
    count, size = vertex.shape
    ears = (np.full(count, c) for c in range(size))
    return np.stack([_ear_shape(plane, vertex, forbidden, vertex_count, e) for e in ears], axis=1)


def _ear_shape(plane, vertex, forbidden, vertex_count, ear):
    """(n,) shape of one ear of each polygon: doubled area over the longest edge squared.

    Equilateral gives 0.87, reflex corners a negative value.
    """
    row, size = np.arange(len(ear)), vertex.shape[1]
    before, after = (ear - 1) % size, (ear + 1) % size
    a, b, c = plane[row, before], plane[row, ear], plane[row, after]
    longest = np.maximum(np.maximum(np.abs(b - a), np.abs(c - b)), np.abs(a - c)) ** 2
    shape = _cross(b - a, c - a) / np.maximum(longest, 1e-300)
    if size > 4:
        slack = _INSIDE * longest
        inside = np.ones(plane.shape, bool)
        for p, q in ((a, b), (b, c), (c, a)):
            inside &= _cross((q - p)[:, None], plane - p[:, None]) >= -slack[:, None]
            # A bridge to a hole passes the same place twice.
            inside &= plane != p[:, None]
        for own in (before, ear, after):
            inside[row, own] = False
        shape = shape + _BLOCKED * inside.any(1)
    key = _key(vertex[row, before], vertex[row, after], vertex_count)
    place = np.minimum(np.searchsorted(forbidden, key), len(forbidden) - 1)
    return np.where(forbidden[place] == key, _REPEATED, shape)


def _in_own_plane(corner):
    """(n, size) complex: polygons (n, size, 3) seen against their (Newell) normals."""
    corner = corner - corner.mean(1, keepdims=True)
    normal = np.cross(corner, np.roll(corner, -1, axis=1)).sum(1)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    least = np.eye(3)[np.argmin(np.abs(normal), axis=1)]
    first = np.cross(least, normal)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-300)
    second = np.cross(normal, first)
    real, imaginary = (np.einsum("nki,ni->nk", corner, axis) for axis in (first, second))
    return real + 1j * imaginary


def _cross(a, b):
    return (np.conj(a) * b).imag
