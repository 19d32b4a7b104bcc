"""Connectivity of the quad mesh that fills the cells, tested before any geometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class QuadLayout:
    """Vertices and quads without positions.

    quad             (Q, 4) int64 vertex numbers, counter-clockwise
    quad_cell        (Q,) int64, cell of the line graph that the quad lies in
    vertex_count     P
    node_vertex      (N,) int64, vertex at every node of the CellComplex (several nodes may share
                     one where arcs have length zero)
    arc_vertex_offset (A + 1,) int64; arc a holds the length[a] + 1 vertices
    arc_vertex       arc_vertex[arc_vertex_offset[a]:arc_vertex_offset[a + 1]], first to second node
    cell_shape       (C, 2) int64, m quads along side 0 and n along side 1; a zero = cell vanished
    grid_offset      (C + 1,) int64; cell c holds the (m + 1) * (n + 1) vertices
    grid_vertex      grid_vertex[grid_offset[c]:...].reshape(n + 1, m + 1): row 0 follows side 0
                     from corner 0 to corner 1, the last column follows side 1
    vertex_fixed     (P,) bool: corners and kinks, which may not move
    vertex_loop      (P,) int64, boundary loop, -1 inside
    """

    quad: np.ndarray
    quad_cell: np.ndarray
    vertex_count: int
    node_vertex: np.ndarray
    arc_vertex_offset: np.ndarray
    arc_vertex: np.ndarray
    cell_shape: np.ndarray
    grid_offset: np.ndarray
    grid_vertex: np.ndarray
    vertex_fixed: np.ndarray
    vertex_loop: np.ndarray
