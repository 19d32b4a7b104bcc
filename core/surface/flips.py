"""The other diagonal in the quad of two triangles, many at a time."""

from __future__ import annotations

import numpy as np

from .surface import next_halfedge, previous_halfedge


def independent_flips(triangles: np.ndarray, halfedge: np.ndarray, twin: np.ndarray) -> np.ndarray:
    """Of the given inner halfedges (n,) some that can be flipped at once.

    triangles (F, 3) int64, twin (3F,) int64. No two of them share a triangle, and no flip gives a
    second edge with the same ends.
    """
    vertex = triangles.ravel()
    one, two = vertex[previous_halfedge(halfedge)], vertex[previous_halfedge(twin[halfedge])]
    stride = np.int64(vertex.max(initial=0) + 1)
    head = vertex[next_halfedge(np.arange(len(vertex)))]
    there = np.minimum(vertex, head) * stride + np.maximum(vertex, head)
    wanted = np.minimum(one, two) * stride + np.maximum(one, two)
    good = ~np.isin(wanted, there) & (one != two)
    first = np.unique(wanted[good], return_index=True)[1]
    halfedge = halfedge[good][np.sort(first)]
    # Of flips that share a triangle the one of least number is done.
    face = np.stack([halfedge // 3, twin[halfedge] // 3])
    least = np.full(len(triangles), len(vertex))
    for row in face:
        np.minimum.at(least, row, halfedge)
    return halfedge[(least[face] == halfedge).all(0)]


def flip(triangles: np.ndarray, halfedge: np.ndarray, twin: np.ndarray) -> None:
    """Put the other diagonal into pairs of triangles, in place.

    halfedge, twin  (n,) int64, the two sides of each diagonal to be replaced
    """
    vertex = triangles.ravel()
    tail, head = vertex[halfedge], vertex[twin]
    apex, beyond = vertex[previous_halfedge(halfedge)], vertex[previous_halfedge(twin)]
    triangles[halfedge // 3] = np.stack([apex, tail, beyond], axis=1)
    triangles[twin // 3] = np.stack([head, apex, beyond], axis=1)


def flip_values(value: np.ndarray, halfedge: np.ndarray, twin: np.ndarray, inside) -> None:
    """Move values of halfedges (3F,) along with `flip`, in place; new edges get `inside`."""
    before = value.copy()
    one, two = 3 * (halfedge // 3), 3 * (twin // 3)
    value[one] = before[previous_halfedge(halfedge)]
    value[one + 1] = before[next_halfedge(twin)]
    value[two] = before[next_halfedge(halfedge)]
    value[two + 2] = before[previous_halfedge(twin)]
    value[one + 2] = value[two + 1] = inside
