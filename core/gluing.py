"""Cells of charts glued along the cuts: one arc, one node for what lies at the same place.

Lines are traced, cells mapped and quads placed on the cut surface, where feature edges are
boundary. Lengths are solved, and the topology is tested, on the glued complex: its arcs along the
cuts belong to the cells on both sides, so that the quads conform across. (method section 8)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .boundary import BoundaryLoops, build_loops
from .cells import CellComplex, NodeKind
from .charts import Charts
from .errors import LayoutError
from .placement import Placement
from .projection import expand_ranges
from .quads import QuadLayout, build_quads, verify_lengths
from .surface import TriangleSurface


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


@dataclass(frozen=True)
class SheetQuads:
    """The quads of the charts, quad by quad those of the whole surface, not joined at the cuts.

    layout  QuadLayout on the cut surface
    vertex  (P',) int64, vertex of the whole quad mesh
    across  (P',) int64, the copy of a vertex that slides on the other side of a cut, else -1
    """

    layout: QuadLayout
    vertex: np.ndarray
    across: np.ndarray

    @cached_property
    def first(self) -> np.ndarray:
        """(P,) int64, the first copy here of each vertex of the whole quad mesh."""
        return np.unique(self.vertex, return_index=True)[1]

    @cached_property
    def irregular(self) -> np.ndarray:
        """(P,) bool, vertices that are irregular on one of the charts."""
        valence = np.bincount(self.layout.quad.ravel(), minlength=self.layout.vertex_count)
        mask = np.zeros(len(self.first), bool)
        mask[self.vertex[valence != np.where(self.layout.vertex_loop >= 0, 2, 4)]] = True
        return mask

    def joined(self, charts: Charts, placement: Placement) -> Placement:
        """The placement of the whole quad mesh on the whole surface; the first copies count."""
        loop, position = _outer_positions(charts, placement.loop, placement.loop_position)
        outer = np.flatnonzero(loop >= 0)
        whole_loop = np.full(len(self.first), -1)
        whole_position = np.zeros(len(self.first))
        whole_loop[self.vertex[outer]] = loop[outer]
        whole_position[self.vertex[outer]] = position[outer]
        return Placement(
            placement.point[self.first], placement.face[self.first], whole_loop, whole_position,
            placement.fixed[self.first],
        )


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
    loop, start = _outer_positions(
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


def _outer_positions(charts, cut_loop, cut_position):
    """Boundary loop of the whole surface and arc length on it, of places on loops of the cut one.

    Places from which the loop of the cut surface goes on along a cut get loop -1, position 0.
    """
    loop, position = np.full(len(cut_loop), -1), np.zeros(len(cut_loop))
    cut, whole = build_loops(charts.surface), build_loops(charts.whole)
    wall = np.flatnonzero(cut_loop >= 0)
    number = cut_loop[wall]
    # A little onward lies on the leaving halfedge, also where the place is its tail by rounding.
    index, _ = cut.locate(number, cut_position[wall] + 1e-10 * cut.length[number])
    place = _index_of(whole, charts.whole)[cut.halfedge[index]]
    outer = place >= 0
    wall, index, place = wall[outer], index[outer], place[outer]
    half = 0.5 * cut.length[cut_loop[wall]]
    beyond = cut.wrap(cut_loop[wall], cut_position[wall] - cut.position[index] + half) - half
    loop[wall] = whole.halfedge_loop[place]
    position[wall] = whole.wrap(loop[wall], whole.position[place] + beyond)
    return loop, position


def _index_of(loops: BoundaryLoops, surface: TriangleSurface):
    """(3F,) int64, position of each boundary halfedge in `loops.halfedge`, -1 inside."""
    index = np.full(len(surface.twin), -1)
    index[loops.halfedge] = np.arange(len(loops.halfedge))
    return index


def _kept_ranges(offset, kept):
    """Indices of the entries of the kept ranges, and their new offsets."""
    size = np.diff(offset)[kept]
    new_offset = np.concatenate([[0], np.cumsum(size)])
    return np.arange(new_offset[-1]) + np.repeat(offset[kept] - new_offset[:-1], size), new_offset


def verify_sheets(gluing: Gluing, length) -> np.ndarray:
    """Test that the charts keep their topology: (A,) bool, arcs of the glued complex to lengthen.

    length  (A,) int64, lengths of the arcs of the glued complex

    Where arcs vanish, a singularity of a chart may come to lie on a feature edge, if quads have
    room for their angles there. Raises LayoutError as `quads.verify_lengths` does.
    """
    surface = gluing.charts.surface
    layout, short = verify_lengths(
        gluing.complex, np.asarray(length)[gluing.arc], surface.euler_characteristic,
        surface.loop_count, surface.component_count, valences=False,
    )
    if not short.any():
        _refuse_flattened(gluing.complex, layout)
    wanted = np.zeros(len(length), bool)
    wanted[gluing.arc[short]] = True
    return wanted


def _refuse_flattened(complex, layout: QuadLayout):
    """On the outline of charts no quad has to fill an angle that was meant for more of them."""
    count = np.bincount(layout.quad.ravel(), minlength=layout.vertex_count)
    least = np.where(layout.vertex_loop >= 0, 2, 0)
    corner = np.flatnonzero(complex.node_kind == NodeKind.CORNER)
    least[layout.node_vertex[corner]] = complex.node_valence[corner]
    flattened = int((count < least).sum())
    if flattened:
        raise LayoutError(
            f"{flattened} quads would have to fill a straight angle beside a feature edge; use "
            "another relaxation or a finer mesh."
        )


def build_sheets(gluing: Gluing, quads: QuadLayout, length) -> SheetQuads:
    """The quads of the charts before they are joined.

    quads   QuadLayout of the glued complex
    length  (A,) int64, lengths of the arcs of the glued complex
    """
    layout = build_quads(gluing.complex, np.asarray(length)[gluing.arc])
    vertex = np.zeros(layout.vertex_count, np.int64)
    vertex[layout.grid_vertex] = quads.grid_vertex
    order = np.argsort(vertex, kind="stable")
    pair = np.flatnonzero(np.diff(vertex[order]) == 0)
    slides = np.bincount(vertex)[vertex[order[pair]]] == 2
    slides &= ~(layout.vertex_fixed[order[pair]] | layout.vertex_fixed[order[pair + 1]])
    first, second = order[pair[slides]], order[pair[slides] + 1]
    across = np.full(layout.vertex_count, -1)
    across[first], across[second] = second, first
    return SheetQuads(layout, vertex, across)


def crease_edges(gluing: Gluing, quads: QuadLayout) -> np.ndarray:
    """(n, 2) int64, end vertices of the edges of the whole quad mesh that lie on the cuts."""
    shared = np.flatnonzero(np.bincount(gluing.arc) == 2)
    first, last = quads.arc_vertex_offset[shared], quads.arc_vertex_offset[shared + 1] - 1
    _, place = expand_ranges(first, last)
    return np.stack([quads.arc_vertex[place], quads.arc_vertex[place + 1]], axis=1)


def synchronise(charts: Charts, placement: Placement, across) -> Placement:
    """Put the second copies of vertices that slide along a cut exactly where the first ones are.

    across  (P',) int64, see SheetQuads
    """
    loops = build_loops(charts.surface)
    first = np.flatnonzero(across > np.arange(len(across)))
    second = across[first]
    index, fraction = loops.locate(placement.loop[first], placement.loop_position[first])
    beyond = _index_of(loops, charts.surface)[charts.across[loops.halfedge[index]]]
    point, face = placement.point.copy(), placement.face.copy()
    loop, position = placement.loop.copy(), placement.loop_position.copy()
    loop[second] = loops.halfedge_loop[beyond]
    position[second] = loops.wrap(
        loop[second], loops.position[beyond] + (1 - fraction) * loops.step_length[beyond]
    )
    point[second], face[second] = point[first], loops.halfedge[beyond] // 3
    return replace(placement, point=point, face=face, loop=loop, loop_position=position)
