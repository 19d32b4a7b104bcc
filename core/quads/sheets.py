"""The quads of charts: of one sheet each, and joined where the charts were cut apart.

Their topology is tested sheet by sheet, and vertices on both sides of a cut are kept at the same
place while they slide along it. (method section 8)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..cells.cells import NodeKind
from ..cells.gluing import Gluing, loop_index, outer_positions
from ..errors import LayoutError
from ..features.charts import Charts
from ..surface.boundary import build_loops
from ..surface.projection import expand_ranges
from .placement import Placement
from .quads import QuadLayout, build_quads, verify_lengths


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
        loop, position = outer_positions(charts, placement.loop, placement.loop_position)
        outer = np.flatnonzero(loop >= 0)
        whole_loop = np.full(len(self.first), -1)
        whole_position = np.zeros(len(self.first))
        whole_loop[self.vertex[outer]] = loop[outer]
        whole_position[self.vertex[outer]] = position[outer]
        return Placement(
            placement.point[self.first], placement.face[self.first], whole_loop, whole_position,
            placement.fixed[self.first],
        )


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
    beyond = loop_index(loops, charts.surface)[charts.across[loops.halfedge[index]]]
    point, face = placement.point.copy(), placement.face.copy()
    loop, position = placement.loop.copy(), placement.loop_position.copy()
    loop[second] = loops.halfedge_loop[beyond]
    position[second] = loops.wrap(
        loop[second], loops.position[beyond] + (1 - fraction) * loops.step_length[beyond]
    )
    point[second], face[second] = point[first], loops.halfedge[beyond] // 3
    return replace(placement, point=point, face=face, loop=loop, loop_position=position)
