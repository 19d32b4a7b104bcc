"""First layouts with few blocks: lengths for very large quads, their drafts placed and judged.

The larger the quads, the fewer blocks; but not always, and the shapes differ. So several sizes are
tried. (method section 8)
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..cells.layout import Layout
from ..errors import LayoutError
from ..quads.cell_maps import map_to_squares
from ..quads.lengths import count_quads
from ..surface.surface import TriangleSurface
from .coarse_divisions import arc_widths, thin_out
from .coarse_lengths import solve_coarse_lengths
from .drafts import WITHIN_REACH, DraftBoard
from .goal import Goal
from .kinks import Kinks

# First layouts: quads as large as so many squares on the surface, and the share of arcs that are
# lengthened at a time, see `solve_coarse_lengths`. The second ones only where the first ones are
# badly shaped. Of the first ones more than the least are tried on layouts of few arcs, where they
# cost little: as long as all of them together have no more than so many.
_SIZES = (
    ((3, 0.15), (6, 0.08), (6, 0.33), (12, 0.33), (3, 0.08), (20, 0.33)),
    ((35, 0.33), (130, 0.33), (550, 0.33)),
)
_LEAST_TRIED, _MOST_ARCS = 3, 400
# First layouts that are smoothed and judged at most: of the first sizes, and of all.
_MOST_JUDGED = (2, 4)
# Layouts whose numbers of blocks differ by less than this share are both judged only where the
# first one was far out of shape.
_ALIKE = 0.05
# Quads of the drafts by which layouts are judged.
_DRAFT_QUADS = 1000
_STAGES = ((2, 0.5, 6, 2e-2), (6, 0.2, 3, 5e-3))


def first_drafts(
    surface: TriangleSurface, layout: Layout, kinks: Kinks, goal: Goal, good: float, cancelled=None
) -> list:
    """Smoothed drafts of a few hundred quads to start from: a list of (DraftBoard, Draft).

    layout  cells without kinks, see `without_kinks`
    good    the first one whose worst scaled Jacobian reaches this ends the search

    Those with the fewest blocks are judged first, and no more than a few. Raises Cancelled.
    """
    search = _Search(surface, layout, kinks, goal, cancelled)
    judged, found = {}, []
    tried = max(_LEAST_TRIED, _MOST_ARCS // max(layout.complex.arc_count, 1))
    for sizes, most in zip(_SIZES, _MOST_JUDGED):
        search.connect(sizes[:tried])
        for key, (board, draft) in sorted(search.connected.items()):
            if len(judged) == most or _is_known(key, judged, WITHIN_REACH * good):
                continue
            judged[key] = -1.0
            try:
                draft = board.place(draft, _STAGES, good)
            except LayoutError:
                continue
            found.append((board, draft))
            judged[key] = draft.worst
            if draft.worst >= good:
                return found
    return found


def _is_known(key, judged, shaped) -> bool:
    """Has a layout been judged, or one like it that was at least about so well shaped?"""
    return key in judged or any(
        abs(np.log(key[1] / other[1])) < _ALIKE and worst >= shaped
        for other, worst in judged.items()
    )


@dataclass
class _Search:
    """Drafts found so far, not placed.

    connected  dict of (can the number of quads not be met?, number of blocks, number of quads of
               the draft): (DraftBoard, Draft); in the order in which they are worth judging
    """

    surface: TriangleSurface
    layout: Layout
    kinks: Kinks
    goal: Goal
    cancelled: object
    connected: dict = field(default_factory=dict)

    def __post_init__(self):
        gluing = self.layout.gluing
        cells = self.layout.complex if gluing is None else gluing.complex
        self.square = map_to_squares(cells, self.layout.cell_mesh)

    def connect(self, sizes):
        """Add the drafts of several sizes.

        Of several with equal numbers the first one stays, with the shortest arcs.
        """
        for squares, share in sizes:
            size = np.sqrt(self.surface.face_area.sum() / squares)
            if self.connected and size < self.goal.size:
                break
            try:
                key, found = self._draft(size, share)
            except LayoutError:
                continue
            self.connected.setdefault(key, found)

    def _draft(self, size, share):
        """The layout in a few hundred quads, small features resolved as in the fine mesh."""
        length = solve_coarse_lengths(self.layout, size, self.cancelled, share)
        board = DraftBoard(
            self.surface, self.layout, self.square, length, self.kinks, self.cancelled
        )
        chords = board.chords
        row = board.rows(board.connect(np.ones(chords.count, np.int64)))
        width, alive = arc_widths(self.layout.complex, chords), np.ones(chords.count, bool)
        division = self.goal.divide(board, width, row, alive)
        lengths = chords.lengths(division, self.layout.complex.arc_count)
        met = self.goal.is_met(count_quads(self.layout.complex, lengths))
        draft = board.connect(_thin(board, division, row))
        return (not met, draft.blocks.count, len(draft.quads.quad)), (board, draft)


def _thin(board: DraftBoard, division, row):
    """Rows of blocks thinned as a whole; chord by chord where something must stay between them."""
    for rows in (row, np.arange(board.chords.count)):
        thin = thin_out(board.layout.complex, board.chords, division, _DRAFT_QUADS, rows)
        if board.is_valid(thin):
            return thin
    return division
