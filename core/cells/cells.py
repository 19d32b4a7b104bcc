"""Four-sided cells of the line graph: nodes, arcs, sides, and the triangles that fill them.

A *halfarc* is ``2 * arc`` when the arc is walked from its first node to its second and
``2 * arc + 1`` when walked backwards. The sides of a cell are walked counter-clockwise, the cell
on the left; side 0 follows corner 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np


class NodeKind(IntEnum):
    """What a node of the line graph is."""

    SINGULARITY = 0
    CORNER = 1  # boundary vertex where n_b != 2
    KINK = 2  # boundary vertex where n_b == 2 that stays a vertex of the mesh
    JUNCTION = 3  # a line ends on another line
    CROSSING = 4  # a line runs across another line
    WALL = 5  # a line ends on the boundary
    REGULAR = 6  # an inserted regular point, or the start of a line at a plain boundary point


@dataclass(frozen=True)
class CellComplex:
    """The line graph as a complex of four-sided cells.

    node_position    (N, 3) float64
    node_kind        (N,) int64, a NodeKind
    node_valence     (N,) int64, quads that will meet there: 4 - I inside, n_b on the boundary
    node_on_boundary (N,) bool
    node_face        (N,) int64, a triangle of the surface that holds the node
    arc_node         (A, 2) int64, first and second node
    arc_loop         (A,) int64, boundary loop that the arc is a piece of, -1 inside; such arcs run
                     along the loop, the surface on their left
    arc_loop_start   (A,) float64, arc length along the loop from the loop's first vertex
                     (tail of its first halfedge) to the arc's first node; 0 inside
    arc_offset       (A + 1,) int64, arc a is the polyline arc_point[arc_offset[a]:arc_offset[a+1]]
    arc_point        (., 3) float64, both end nodes included
    arc_point_face   (.,) int64, triangle that holds the segment starting at the point
                     (at the last point of an arc: ending at it)
    side_offset      (4 C + 1,) int64, side k of cell c is
                     side_halfarc[side_offset[4 * c + k]:side_offset[4 * c + k + 1]]
    side_halfarc     (S,) int64, one slot for each halfarc on a side, counter-clockwise
    """

    node_position: np.ndarray
    node_kind: np.ndarray
    node_valence: np.ndarray
    node_on_boundary: np.ndarray
    node_face: np.ndarray
    arc_node: np.ndarray
    arc_loop: np.ndarray
    arc_loop_start: np.ndarray
    arc_offset: np.ndarray
    arc_point: np.ndarray
    arc_point_face: np.ndarray
    side_offset: np.ndarray
    side_halfarc: np.ndarray

    @property
    def node_count(self) -> int:
        return len(self.node_kind)

    @property
    def arc_count(self) -> int:
        return len(self.arc_node)

    @property
    def cell_count(self) -> int:
        return (len(self.side_offset) - 1) // 4

    def polyline(self, arc: int) -> np.ndarray:
        """(n, 3) float64, the points of one arc."""
        return self.arc_point[self.arc_offset[arc] : self.arc_offset[arc + 1]]

    @property
    def arc_length(self) -> np.ndarray:
        """(A,) float64, length of each polyline."""
        step = np.linalg.norm(np.diff(self.arc_point, axis=0), axis=1)
        total = np.concatenate([[0.0], np.cumsum(step)])
        return total[self.arc_offset[1:] - 1] - total[self.arc_offset[:-1]]

    @property
    def slot_cell(self) -> np.ndarray:
        """(S,) int64, cell of each entry of side_halfarc."""
        return self.slot_side // 4

    @property
    def slot_side(self) -> np.ndarray:
        """(S,) int64, 4 * cell + side of each entry of side_halfarc."""
        return np.repeat(np.arange(len(self.side_offset) - 1), np.diff(self.side_offset))


@dataclass(frozen=True)
class CellMesh:
    """The surface cut along all arcs: the triangles that fill each cell.

    Every cell is a disc with points of its own: a point of an arc appears once for each time that
    a cell's boundary passes it (twice even in one cell, when the cell touches itself).

    point          (M, 3) float64
    triangle       (T, 3) int64 into point, counter-clockwise
    triangle_cell  (T,) int64
    triangle_face  (T,) int64, the triangle of the surface that it is a piece of
    wall_point     (K,) int64, the points on cell boundaries
    wall_slot      (K,) int64, entry of CellComplex.side_halfarc that the point lies on; a node
                   belongs to the slot that starts there
    wall_distance  (K,) float64, arc length from the start of that halfarc (0 at its node)
    """

    point: np.ndarray
    triangle: np.ndarray
    triangle_cell: np.ndarray
    triangle_face: np.ndarray
    wall_point: np.ndarray
    wall_slot: np.ndarray
    wall_distance: np.ndarray
