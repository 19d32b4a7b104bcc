"""A quad mesh cut along some of its edges: chains between corners, and the grids that are left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import LayoutError
from ..quads.quad_connectivity import QuadConnectivity, opposite_side, previous_side


@dataclass(frozen=True)
class Chains:
    """The cut edges as chains between block corners; closed chains are told apart.

    chain   (E,) int64 chain of each edge, -1 where the edge is not cut or its chain is closed
    closed  (E,) bool, edges of chains without any corner
    offset, vertex   chain c is vertex[offset[c]:offset[c + 1]], both ends included
    """

    chain: np.ndarray
    closed: np.ndarray
    offset: np.ndarray
    vertex: np.ndarray

    @property
    def ends(self) -> np.ndarray:
        """(chains, 2) int64, both ends, the smaller first."""
        start, end = self.vertex[self.offset[:-1]], self.vertex[self.offset[1:] - 1]
        return np.sort(np.stack([start, end], 1), axis=1)


@dataclass(frozen=True)
class Grids:
    """The parts between the cut edges, each a structured grid.

    quad_block   (Q,) int64, grid of each quad
    shape        (B, 2) int64, quads along the first and second direction
    offset       (B + 1,) int64; grid b is vertex[offset[b]:offset[b + 1]]
    vertex       .reshape(n + 1, m + 1): rows along the first direction, counter-clockwise
    base         (Q,) int64, the halfedge of each quad along the first direction, on its lower side
    column, row  (Q,) int64, place of each quad in its grid
    """

    quad_block: np.ndarray
    shape: np.ndarray
    offset: np.ndarray
    vertex: np.ndarray
    base: np.ndarray
    column: np.ndarray
    row: np.ndarray

    @property
    def corner(self) -> np.ndarray:
        """(B, 4) int64, vertices of the corners, counter-clockwise."""
        first, last, m = self.offset[:-1], self.offset[1:] - 1, self.shape[:, 0]
        return self.vertex[np.stack([first, first + m, last, last - m], 1)]

    @property
    def corner_halfedge(self) -> np.ndarray:
        """(B, 4) int64, the halfedge from each corner along the side that starts there."""
        m, n = self.shape[self.quad_block].T
        left, right = self.column == 0, self.column == m - 1
        bottom, top = self.row == 0, self.row == n - 1
        result = np.empty((len(self.shape), 4), np.int64)
        for side, mask in enumerate((left & bottom, right & bottom, right & top, left & top)):
            result[self.quad_block[mask], side] = turned(self.base[mask], side)
        return result


def turned(halfedge, sides):
    """The halfedges of the same quads, so many sides further on counter-clockwise."""
    return halfedge - halfedge % 4 + (halfedge + sides) % 4


def edges_between(mesh: QuadConnectivity, pairs) -> np.ndarray:
    """(E,) bool, the edges whose end vertices are among the given pairs (n, 2)."""
    pairs = np.sort(np.asarray(pairs, np.int64).reshape(-1, 2), axis=1)
    ends = np.sort(mesh.edge_vertex, axis=1)
    span = np.array([mesh.vertex_count, 1])
    return np.isin(ends @ span, pairs @ span)


def cut_corners(mesh: QuadConnectivity, cut) -> np.ndarray:
    """(P,) bool, vertices where a single quad lies between two cut edges; cut (E,) bool."""
    corner = np.zeros(mesh.vertex_count, bool)
    before = previous_side(np.arange(len(mesh.tail)))
    corner[mesh.tail[cut[mesh.edge] & cut[mesh.edge[before]]]] = True
    return corner


def find_chains(mesh: QuadConnectivity, straight, cut, corner=None) -> Chains:
    """Order the cut edges into chains from corner to corner.

    straight  (4 Q,) int64, the halfedge with which a chain goes on inside, -1 where it ends
    cut       (E,) bool
    corner    (P,) bool, where chains end; those of `cut_corners` by default
    """
    corner = cut_corners(mesh, cut) if corner is None else corner
    # Darts: 2 * edge walks an edge as in edge_vertex, 2 * edge + 1 backwards.
    dart = 2 * mesh.edge + (mesh.tail != mesh.edge_vertex[mesh.edge, 0])
    tail = mesh.edge_vertex.ravel()
    following = np.arange(2 * mesh.edge_count)
    onward = np.flatnonzero(cut[mesh.edge] & (straight >= 0) & ~corner[mesh.head])
    following[dart[onward]] = dart[straight[onward]]
    plain = ~corner[mesh.head[mesh.boundary]]
    here, there = dart[mesh.boundary[plain]], dart[mesh.along_boundary[plain]]
    following[here], following[there ^ 1] = there, here ^ 1
    last, steps = to_the_end(following)
    used = np.flatnonzero(np.repeat(cut, 2))
    begin = used[corner[tail[used]]]
    # Both directions of a chain begin at a corner: keep the one with the smaller first dart.
    begin = begin[begin < (last[begin] ^ 1)]
    number = np.full(2 * mesh.edge_count, -1)
    number[last[begin]] = np.arange(len(begin))
    number = np.where(following[last] == last, number[last], -1)
    darts = np.flatnonzero(np.repeat(cut, 2) & (number >= 0))
    darts = darts[np.lexsort([-steps[darts], number[darts]])]
    chain = np.full(mesh.edge_count, -1)
    chain[darts // 2] = number[darts]
    offset = np.concatenate([[0], np.cumsum(np.bincount(number[darts], minlength=len(begin)) + 1)])
    vertex = np.empty(offset[-1], np.int64)
    vertex[np.arange(len(darts)) + number[darts]] = tail[darts]
    vertex[offset[1:] - 1] = tail[last[begin] ^ 1]
    return Chains(chain, cut & (chain < 0), offset, vertex)


def to_the_end(following):
    """End of the path from each element and steps to it, by pointer doubling.

    An element that follows itself is an end. On closed paths both results mean nothing.
    """
    ahead, steps = following, (following != np.arange(len(following))).astype(np.int64)
    for _ in range(len(following).bit_length()):
        further = ahead[ahead]
        if np.array_equal(further, ahead):
            break
        steps = steps + steps[ahead]
        ahead = further
    return ahead, steps


def find_grids(mesh: QuadConnectivity, cut) -> Grids:
    """The grids between cut edges: how far is it from each quad to the left and the lower end?

    Raises LayoutError where a part is no grid.
    """
    halfedge = np.arange(len(mesh.tail))
    side = previous_side(halfedge)
    left = np.where(cut[mesh.edge[side]], halfedge, previous_side(mesh.twin[side]))
    down = np.where(cut[mesh.edge], halfedge, opposite_side(mesh.twin))
    left_end, column = to_the_end(left)
    down_end, row = to_the_end(down)
    origin = down_end[left_end].reshape(-1, 4)
    base = 4 * np.arange(len(mesh.quad)) + origin.argmin(1)
    column, row = column[base], row[left_end[base]]
    _, quad_block = np.unique(origin.min(1), return_inverse=True)
    quad_block = quad_block.ravel()
    shape = np.zeros((int(quad_block.max(initial=-1)) + 1, 2), np.int64)
    np.maximum.at(shape, quad_block, np.stack([column, row], 1) + 1)
    if not np.array_equal(shape.prod(1), np.bincount(quad_block, minlength=len(shape))):
        raise LayoutError("A block of the quad mesh is no grid; use another size.")
    offset = np.concatenate([[0], np.cumsum((shape + 1).prod(1))])
    vertex = np.empty(offset[-1], np.int64)
    width = shape[quad_block, 0]
    place = offset[quad_block] + row * (width + 1) + column
    vertex[place], vertex[place + 1] = mesh.tail[base], mesh.head[base]
    across = opposite_side(base)
    vertex[place + width + 1], vertex[place + width + 2] = mesh.head[across], mesh.tail[across]
    return Grids(quad_block, shape, offset, vertex, base, column, row)
