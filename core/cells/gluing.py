"""Cells of charts glued along the cuts: one arc, one node for what lies at the same place.

Lines are traced, cells mapped and quads placed on the cut surface, where feature edges are
boundary. Lengths are solved, and the topology is tested, on the glued complex: its arcs along the
cuts belong to the cells on both sides, so that the quads conform across. (method section 8)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..errors import LayoutError
from ..features.charts import Charts
from ..surface.boundary import BoundaryLoops, build_loops
from ..surface.surface import TriangleSurface
from .cells import CellComplex, NodeKind


@dataclass(frozen=True)
class Gluing:
    """How the cells of a cut surface make up those of the whole one.

    charts   Charts
    complex  CellComplex of the cut surface; its cells and slots are those of the glued one
    arc      (A',) int64, arc of the glued complex that each of its arcs has become
    node     (N',) int64, node of the glued complex that each of its nodes has become
    """

    charts: Charts
    complex: CellComplex
    arc: np.ndarray
    node: np.ndarray


def glue_cells(charts: Charts, complex: CellComplex, arc_points, node_point, same):
    """The complex of the whole surface: (CellComplex, Gluing).

    complex     CellComplex of the cut surface
    arc_points  list of lists, the points of each arc
    node_point  (N,) int, point of each node
    same        dict point -> one point for all that are copies of it; points without copies may
                be left out

    Raises LayoutError where a cut is divided differently on its two sides.
    """
    partner = _partners(charts, complex, arc_points, same)
    first = np.minimum(np.arange(len(partner)), np.where(partner < 0, len(partner), partner))
    kept, arc = np.unique(first, return_inverse=True)
    arc = arc.ravel()
    place = np.array([same.get(p, p) for p in node_point], np.int64)
    node = np.unique(place, return_inverse=True)[1].ravel()
    flipped = np.arange(len(partner)) != first
    outer = (complex.arc_loop >= 0) & (partner < 0)
    chosen, fields = _merged_nodes(complex, node, outer)
    loop, start = outer_positions(
        charts, np.where(outer, complex.arc_loop, -1), complex.arc_loop_start
    )
    point, offset = _kept_ranges(complex.arc_offset, kept)
    halfarc = complex.side_halfarc
    glued = replace(
        complex,
        node_position=complex.node_position[chosen],
        node_face=complex.node_face[chosen],
        **fields,
        arc_node=node[complex.arc_node[kept]],
        arc_loop=loop[kept],
        arc_loop_start=start[kept],
        arc_offset=offset,
        arc_point=complex.arc_point[point],
        arc_point_face=complex.arc_point_face[point],
        side_halfarc=2 * arc[halfarc // 2] + (halfarc % 2 ^ flipped[halfarc // 2]),
    )
    return glued, Gluing(charts, complex, arc, node)


def _partners(charts, complex, arc_points, same):
    """(A',) int64, the arc on the other side of the cut, -1 where there is none."""
    walls = np.flatnonzero(complex.arc_loop >= 0).tolist()
    path = {number: [same.get(p, p) for p in arc_points[number]] for number in walls}
    starting = {(p[0], p[1]): number for number, p in path.items()}
    partner = np.full(complex.arc_count, -1)
    for number, points in path.items():
        other = starting.get((points[-1], points[-2]))
        if other is None:
            continue
        if path[other] != points[::-1]:
            raise LayoutError(
                "The lines on both sides of a feature edge do not meet; refine the mesh there."
            )
        partner[number] = other
    return partner


def _merged_nodes(complex, node, outer):
    """For each glued node the copy that stands for it, and kind, valence and boundary flag."""
    rank = np.select(
        [complex.node_kind == NodeKind.CORNER, complex.node_kind == NodeKind.KINK], [0, 1], 2
    )
    order = np.lexsort((rank, node))
    chosen = order[np.diff(node[order], prepend=-1) != 0]
    on_boundary = np.zeros(len(chosen), bool)
    on_boundary[node[complex.arc_node[outer]]] = True
    valence = np.bincount(node, complex.node_valence).astype(np.int64)
    return chosen, {
        "node_kind": complex.node_kind[chosen],
        "node_valence": valence,
        "node_on_boundary": on_boundary,
    }


def outer_positions(charts, cut_loop, cut_position):
    """Boundary loop of the whole surface and arc length on it, of places on loops of the cut one.

    Places from which the loop of the cut surface goes on along a cut get loop -1, position 0.
    """
    loop, position = np.full(len(cut_loop), -1), np.zeros(len(cut_loop))
    cut, whole = build_loops(charts.surface), build_loops(charts.whole)
    wall = np.flatnonzero(cut_loop >= 0)
    number = cut_loop[wall]
    # A little onward lies on the leaving halfedge, also where the place is its tail by rounding.
    index, _ = cut.locate(number, cut_position[wall] + 1e-10 * cut.length[number])
    place = loop_index(whole, charts.whole)[cut.halfedge[index]]
    outer = place >= 0
    wall, index, place = wall[outer], index[outer], place[outer]
    half = 0.5 * cut.length[cut_loop[wall]]
    beyond = cut.wrap(cut_loop[wall], cut_position[wall] - cut.position[index] + half) - half
    loop[wall] = whole.halfedge_loop[place]
    position[wall] = whole.wrap(loop[wall], whole.position[place] + beyond)
    return loop, position


def loop_index(loops: BoundaryLoops, surface: TriangleSurface):
    """(3F,) int64, position of each boundary halfedge in `loops.halfedge`, -1 inside."""
    index = np.full(len(surface.twin), -1)
    index[loops.halfedge] = np.arange(len(loops.halfedge))
    return index


def _kept_ranges(offset, kept):
    """Indices of the entries of the kept ranges, and their new offsets."""
    size = np.diff(offset)[kept]
    new_offset = np.concatenate([[0], np.cumsum(size)])
    return np.arange(new_offset[-1]) + np.repeat(offset[kept] - new_offset[:-1], size), new_offset
