"""Blocks: the base complex of a quad mesh, every block a grid with four distinct corners."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Blocks:
    """The multi-block decomposition of a quad mesh.

    quad_block   (Q,) int64, block of each quad
    shape        (B, 2) int64, quads along the first and second direction
    grid_offset  (B + 1,) int64; grid_vertex[grid_offset[b]:grid_offset[b + 1]]
    grid_vertex  .reshape(n + 1, m + 1): rows along the first direction, counter-clockwise corners
                 [0, 0], [0, -1], [-1, -1], [-1, 0]
    corner       (B, 4) int64, vertices of the four distinct corners, counter-clockwise
    edge_offset  (E + 1,) int64; block edge e is the chain of vertices
    edge_vertex  edge_vertex[edge_offset[e]:edge_offset[e + 1]], both ends included
    block_edge   (B, 4) int64, edge number of sides corner0-corner1, 1-2, 2-3, 3-0
    edge_on_boundary (E,) bool
    """

    quad_block: np.ndarray
    shape: np.ndarray
    grid_offset: np.ndarray
    grid_vertex: np.ndarray
    corner: np.ndarray
    edge_offset: np.ndarray
    edge_vertex: np.ndarray
    block_edge: np.ndarray
    edge_on_boundary: np.ndarray

    @property
    def count(self) -> int:
        return len(self.shape)
