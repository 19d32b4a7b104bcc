"""Drafts of a block layout: a division of its chords, the quads of it, and where they lie.

A draft of a few hundred quads shows how well shaped the blocks of a layout are; the wanted fine
mesh is another draft of the same layout, its vertices placed between those of the coarser one.
(method sections 8 to 10)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..blocks.blocks import Blocks, find_blocks
from ..cells.layout import Layout
from ..errors import LayoutError
from ..quads.cell_maps import squares_to_rectangles
from ..quads.mapping import place_vertices
from ..quads.placement import Placement
from ..quads.quads import QuadLayout
from ..quads.quality import scaled_jacobian
from ..quads.sheets import SheetQuads, build_sheets, crease_edges, synchronise
from ..quads.smoothing import STAGES, smooth
from ..quads.worst_quads import STEEPNESSES, mend_worst_quads
from ..surface.boundary import build_loops
from ..surface.projection import surface_normal
from ..surface.surface import TriangleSurface
from .coarse_divisions import chord_widths
from .coarse_lengths import arcs_too_short
from .kinks import Kinks, snap_to_kinks
from .layout_chords import LayoutChords, find_layout_chords, rows_of_blocks
from .transfer import transfer

# Vertices for each kink on a loop from which on kinks find theirs before any smoothing.
_ROOM_AT_ONCE = 8
# Drafts that the first stage brings to less than this share of the needed worst scaled Jacobian
# hardly ever reach it: where they were placed anew, and where they come from better ones.
_HOPELESS, _SPOILT = 0.4, 0.7
# Drafts that smoothing brings to this share of it are mended, as the wanted quads will be.
WITHIN_REACH = 0.8


@dataclass(frozen=True)
class Draft:
    """Quads of a layout.

    division   (count,) int64, quads across each chord; 0 where a row has been taken out
    length     (A,) int64, quads along each arc
    quads      QuadLayout of the whole surface
    sheets     SheetQuads, the same quads on the charts; None where the surface was not cut
    placement  Placement of the vertices of `quads`, or of `sheets.layout` on charts
    blocks     Blocks
    worst      worst scaled Jacobian; negative if a quad is inverted
    """

    division: np.ndarray
    length: np.ndarray
    quads: QuadLayout
    sheets: SheetQuads | None
    placement: Placement | None
    blocks: Blocks
    worst: float

    @property
    def layout(self) -> QuadLayout:
        """The quads as they were placed: on the charts where the surface was cut."""
        return self.quads if self.sheets is None else self.sheets.layout


class DraftBoard:
    """Makes drafts of one layout: the lengths given here say what its chords are.

    surface  TriangleSurface, cut along feature edges
    square   (M, 2) float64, the cells on squares: `mapping.map_to_squares` of the layout, of its
             charts where it is cut
    length   (A,) int64, verified lengths; all drafts are divisions of their chords
    kinks    Kinks at which placed drafts have a vertex as far as they can, or None
    """

    def __init__(
        self, surface: TriangleSurface, layout: Layout, square, length,
        kinks: Kinks | None = None, cancelled=None,
    ):
        self.surface, self.layout, self.cancelled = surface, layout, cancelled
        self.square = square
        self.kinks = kinks
        self.chords = find_layout_chords(layout.complex, length)
        self.complex, self.own_chords = layout.complex, self.chords
        if layout.gluing is not None:
            self.complex = layout.gluing.complex
            self.own_chords = _chords_of_charts(self.chords, self.complex, layout.gluing, length)

    def is_valid(self, division) -> bool:
        """Do the quads of a division make the surface?"""
        length = self.chords.lengths(division, self.layout.complex.arc_count)
        try:
            return not arcs_too_short(self.layout, length)[1].any()
        except LayoutError:
            return False

    def connect(self, division) -> Draft:
        """The quads of a division, not placed yet. Raises LayoutError if they are not valid."""
        length = self.chords.lengths(division, self.layout.complex.arc_count)
        quads, short = arcs_too_short(self.layout, length)
        if short.any():
            raise LayoutError("The quads are too large for this layout; ask for more of them.")
        gluing = self.layout.gluing
        sheets = build_sheets(gluing, quads, length) if gluing is not None else None
        source = source_vertices(quads, sheets)
        crease = crease_edges(gluing, quads) if gluing is not None else ()
        blocks = find_blocks(quads.quad, quads.vertex_count, source, crease)
        return Draft(division, length, quads, sheets, None, blocks, -1.0)

    def place(self, draft: Draft, stages=STAGES, needed: float | None = None) -> Draft:
        """A connected draft placed by the cells that it fills, and smoothed.

        needed  worst scaled Jacobian: further stages are left out where it is far out of reach, and
                where it is nearly reached, the worst quads are mended

        Cells that have vanished leave the vertices of others unevenly spread: most kinks find
        theirs after the first stage. Single ones, as on the nose of an aerofoil, need theirs at once.
        """
        gluing, cells = self.layout.gluing, self.layout.cell_mesh
        length = draft.length if gluing is None else draft.length[gluing.arc]
        mapped = squares_to_rectangles(
            self.complex, cells, self.square, draft.layout.cell_shape, length
        )
        placement = place_vertices(
            self.surface, self.complex, cells, draft.layout, length, mapped
        )
        placement = self._snapped(draft, placement, _ROOM_AT_ONCE)
        even = self._smoothed(draft, placement, stages[:1])
        if needed is not None and even.worst < _HOPELESS * needed:
            return even
        placement = even.placement
        if self.kinks is not None and len(self.kinks.loop):
            placement = self._snapped(draft, placement)
        draft = self._smoothed(draft, placement, stages[1:])
        if needed is not None and WITHIN_REACH * needed <= draft.worst < needed:
            draft = self.mended(draft, STEEPNESSES[:1])
        return draft

    def follow(self, draft: Draft, old: Draft) -> Draft:
        """A connected draft placed by another one, not smoothed."""
        placement = transfer(
            self.surface, self.complex, self.own_chords, (old.division, old.layout, old.placement),
            draft.division, draft.layout,
        )
        return replace(draft, placement=self._snapped(draft, placement))

    def smoothed(self, draft: Draft, stages=STAGES, needed: float | None = None) -> Draft:
        """A placed draft smoothed.

        needed  worst scaled Jacobian that is enough: further stages are left out once it is
                reached, or once it is far out of reach
        """
        if needed is None:
            return self._smoothed(draft, draft.placement, stages)
        draft = self._smoothed(draft, draft.placement, stages[:1])
        if not _SPOILT * needed <= draft.worst < needed:
            return draft
        return self._smoothed(draft, draft.placement, stages[1:])

    def mended(self, draft: Draft, steepnesses=STEEPNESSES) -> Draft:
        """A placed draft whose worst quads have been searched for better places."""
        placement = mend_worst_quads(
            self.surface, draft.placement, draft.layout.quad, self.cancelled,
            steepnesses=steepnesses,
        )
        return self._judged(draft, placement)

    def _snapped(self, draft: Draft, placement: Placement, room=2) -> Placement:
        if self.kinks is None:
            return placement
        across = None if draft.sheets is None else draft.sheets.across
        return snap_to_kinks(self.surface, placement, self.kinks, across, room)

    def _smoothed(self, draft, placement, stages):
        across = None
        if draft.sheets is not None:
            across = draft.sheets.across
            placement = synchronise(self.layout.gluing.charts, placement, across)
        quad = draft.layout.quad
        size = np.sqrt(self.surface.face_area.sum() / len(quad))
        placement = smooth(self.surface, placement, quad, size, self.cancelled, across, stages)
        return self._judged(draft, placement)

    def _judged(self, draft, placement):
        normal = surface_normal(self.surface, placement.face, placement.point)
        worst = float(scaled_jacobian(placement.point, draft.layout.quad, normal).min())
        return replace(draft, placement=placement, worst=worst)

    def widths(self, draft: Draft) -> np.ndarray:
        """(count,) float64, how wide the chords are in a draft."""
        corner = draft.placement.point[draft.layout.quad]
        length = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
        chord = self.chords.quad_chords(draft.division)[:, [0, 1, 0, 1]]
        return chord_widths(length.ravel(), chord.ravel(), draft.division)

    def straying(self, draft: Draft) -> np.ndarray:
        """(count,) float64: how far the boundary strays from the quad edges across each chord."""
        layout, placement = draft.layout, draft.placement
        chord = self.own_chords.unit_chord
        times = draft.division[chord]
        arc = np.repeat(self.own_chords.unit_arc, times)
        first = np.arange(len(arc)) + arc  # an arc has one vertex more than edges
        wall = np.flatnonzero(self.complex.arc_loop[arc] >= 0)
        tail, head = layout.arc_vertex[first[wall]], layout.arc_vertex[first[wall] + 1]
        loop, position = placement.loop[tail], placement.loop_position[tail]
        loops = build_loops(self.surface)
        advance = loops.wrap(loop, placement.loop_position[head] - position)
        result = np.zeros(self.chords.count)
        deviation = loops.chord_deviation(loop, position, advance)
        np.maximum.at(result, np.repeat(chord, times)[wall], deviation)
        return result

    def rows(self, draft: Draft) -> np.ndarray:
        """(count,) int64, chords with equal number run through the same row of blocks."""
        pairs = self.chords.quad_chords(draft.division)
        return rows_of_blocks(draft.quads, pairs, self.chords.count, draft.blocks)


def source_vertices(quads: QuadLayout, sheets: SheetQuads | None) -> np.ndarray:
    """(P,) bool, vertices from which the lines between blocks run: singularities and corners."""
    valence = np.bincount(quads.quad.ravel(), minlength=quads.vertex_count)
    source = valence != np.where(quads.vertex_loop >= 0, 2, 4)
    return source if sheets is None else source | sheets.irregular


def _chords_of_charts(chords: LayoutChords, complex, gluing, length) -> LayoutChords:
    """The chords along the arcs of the charts, numbered as those of the glued cells.

    Cells and their sides are the same; chords that end at a cut there go on here.
    """
    own = find_layout_chords(complex, np.asarray(length)[gluing.arc])
    number = np.zeros(own.count, np.int64)
    number[own.axis_chord] = chords.axis_chord
    return replace(
        own, count=chords.count, unit_chord=number[own.unit_chord], axis_chord=chords.axis_chord
    )
