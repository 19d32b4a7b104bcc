"""Halfedges, edges and straight mesh lines of a quad mesh.

Halfedge ``h = 4 * q + c`` runs from corner ``c`` to corner ``(c + 1) % 4`` of quad ``q``, which
lies on its left.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import CoarseLayoutError
from ..surface.surface import connected_components


def next_side(halfedge):
    """The following halfedge of the same quad; int or integer array."""
    return halfedge - 4 * (halfedge % 4 == 3) + 1


def previous_side(halfedge):
    """The preceding halfedge of the same quad; int or integer array."""
    return halfedge + 4 * (halfedge % 4 == 0) - 1


def opposite_side(halfedge):
    """The halfedge across the same quad; int or integer array."""
    return halfedge + 2 - 4 * (halfedge % 4 >= 2)


@dataclass(frozen=True)
class QuadConnectivity:
    """An oriented, edge-manifold quad mesh. Build it with `connect_quads`.

    quad          (Q, 4) int64, counter-clockwise
    vertex_count  P
    tail, head    (4 Q,) int64, end vertices of each halfedge
    twin          (4 Q,) int64, the opposite halfedge, -1 on the boundary
    edge          (4 Q,) int64, number of the undirected edge of each halfedge
    edge_vertex   (E, 2) int64, end vertices of the edges
    """

    quad: np.ndarray
    vertex_count: int
    tail: np.ndarray
    head: np.ndarray
    twin: np.ndarray
    edge: np.ndarray
    edge_vertex: np.ndarray

    @property
    def edge_count(self) -> int:
        return len(self.edge_vertex)

    @cached_property
    def boundary(self) -> np.ndarray:
        """(n,) int64, the boundary halfedges."""
        return np.flatnonzero(self.twin < 0)

    @cached_property
    def on_boundary(self) -> np.ndarray:
        """(P,) bool."""
        mask = np.zeros(self.vertex_count, bool)
        mask[self.tail[self.boundary]] = mask[self.head[self.boundary]] = True
        return mask

    @cached_property
    def face_count(self) -> np.ndarray:
        """(P,) int64, number of quads round each vertex."""
        return np.bincount(self.tail, minlength=self.vertex_count)

    @cached_property
    def irregular(self) -> np.ndarray:
        """(P,) bool, vertices without 4 quads inside or without 2 on the boundary."""
        return self.face_count != np.where(self.on_boundary, 2, 4)

    @cached_property
    def straight(self) -> np.ndarray:
        """(4 Q,) int64, the halfedge straight on at the head of each halfedge.

        At a regular interior vertex there is one; -1 at all other vertices.
        """
        regular = ~(self.irregular | self.on_boundary)[self.head]
        across = self.twin[next_side(np.arange(len(self.tail)))]
        return np.where(regular, next_side(across), -1)

    @cached_property
    def along_boundary(self) -> np.ndarray:
        """(n,) int64, the boundary halfedge that follows each of `boundary`."""
        leaving = np.full(self.vertex_count, -1)
        leaving[self.tail[self.boundary]] = self.boundary
        return leaving[self.head[self.boundary]]

    def edges_at(self, vertices) -> np.ndarray:
        """(n, 2) int64, the edges of all quads that touch the given vertices."""
        touched = np.isin(self.quad, vertices).any(1)
        return self.edge_vertex[np.unique(self.edge.reshape(-1, 4)[touched])]


def connect_quads(quad, vertex_count: int) -> QuadConnectivity:
    """Match the halfedges of a quad mesh.

    quad  (Q, 4) int64, consistently oriented, each edge in at most two quads

    Raises CoarseLayoutError where two halfedges run between the same vertices in the same
    direction or a quad meets a vertex twice.
    """
    quad = np.ascontiguousarray(quad, np.int64).reshape(-1, 4)
    tail, head = quad.ravel(), np.roll(quad, -1, axis=1).ravel()
    repeated = (np.diff(np.sort(quad, axis=1), axis=1) == 0).any(1)
    if repeated.any():
        raise CoarseLayoutError(
            f"{int(repeated.sum())} quads would meet a vertex twice; ask for more quads.",
            _sides(quad[repeated]),
        )
    key = tail * np.int64(vertex_count) + head
    order = np.argsort(key, kind="stable")
    ordered = key[order]
    doubled = order[1:][ordered[1:] == ordered[:-1]]
    if len(doubled):
        raise CoarseLayoutError(
            f"{len(doubled)} pairs of vertices would be joined by two edges; ask for more quads.",
            np.stack([tail[doubled], head[doubled]], 1),
        )
    reverse = head * np.int64(vertex_count) + tail
    place = np.minimum(np.searchsorted(ordered, reverse), len(key) - 1)
    twin = np.where(ordered[place] == reverse, order[place], -1) if len(key) else place
    first = np.flatnonzero((twin < 0) | (np.arange(len(key)) < twin))
    edge = np.empty(len(key), np.int64)
    edge[first] = np.arange(len(first))
    second = first[twin[first] >= 0]
    edge[twin[second]] = edge[second]
    ends = np.stack([tail[first], head[first]], 1)
    return QuadConnectivity(quad, vertex_count, tail, head, twin, edge, ends)


def vertex_fans(mesh: QuadConnectivity) -> np.ndarray:
    """(P,) int64, number of separate fans of quads round each vertex: 1 on a manifold."""
    inner = np.flatnonzero(mesh.twin >= 0)
    corner = connected_components(len(mesh.tail), inner, next_side(mesh.twin[inner]))
    fan_vertex = np.empty(int(corner.max(initial=-1)) + 1, np.int64)
    fan_vertex[corner] = mesh.tail
    return np.bincount(fan_vertex, minlength=mesh.vertex_count)


def _sides(quad) -> np.ndarray:
    return np.stack([quad.ravel(), np.roll(quad, -1, axis=1).ravel()], 1)
