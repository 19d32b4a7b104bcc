"""Coarse layouts: few blocks, as far as their shapes allow. (method sections 8 and 9)

Lengths for very large quads give a first layout: thin strips vanish, singularities join up,
spirals unwind. Then, from the thinnest on, whole rows of blocks are taken out, as long as nothing
falls together that must stay apart and the smoothed draft keeps its shape. The wanted mesh is a
division of what is left.
"""

from __future__ import annotations

import numpy as np

from ..blocks.thin_blocks import THIN
from ..cells.layout import Layout
from ..errors import LayoutError
from ..settings import Settings
from ..surface.surface import TriangleSurface
from .corner_shape import corner_shape
from .drafts import Draft, DraftBoard
from .goal import Goal
from .kinks import without_kinks
from .starts import first_drafts

# The one with the fewest blocks is taken whose worst scaled Jacobian reaches this, or this share of
# what the corners allow, or of the best one of all those tried.
_GOOD_START = 0.58
_NEARLY = 0.95
# The next start is better shaped by so much; hardly more blocks are up to so many times as many.
_BETTER, _HARDLY_MORE = 0.05, 1.08
# Without any first layout as well shaped as this the direct layout is taken.
_LEAST_START = 0.1
# Rows are taken out as long as the worst scaled Jacobian stays above this, or above this share of
# what it was at first; below half the wanted size above half of that.
_LEAST = {"balanced": 0.62, "fewest": 0.4}
_SHARE = {"balanced": 0.9, "fewest": 0.6}
_PATIENCE = {"balanced": 4, "fewest": 12}
# A layout whose wanted quads come out worse than both of these, the second one a share of its
# draft, gives way to the next finer one.
_LEAST_FINE, _FINE_KEPT = 0.5, 0.75
_TRIAL_STAGES = ((2, 0.5, 3, 2e-2), (6, 0.2, 2, 5e-3))
_FINE_STAGES = ((2, 0.5, 2, 2e-2), (6, 0.2, 2, 5e-3), (12, 0.1, 2, 2e-3))
# The boundary may stray by so many edge lengths from the quads, or divisions are added.
_STRAYING = 0.18
_MOST_REFINEMENTS, _MOST_MORE = 3, 1.05
# A fine mesh worse than this share of its draft is placed in two steps.
_FINE_SHARE = 0.9


def coarsen(
    surface: TriangleSurface, layout: Layout, settings: Settings, cancelled=None
) -> Draft | None:
    """The smoothed fine quads of a layout with few blocks; None where only the direct one is good.

    surface  TriangleSurface, cut along feature edges; layout: its cells

    Raises Cancelled.
    """
    goal = Goal.of(settings, surface.face_area.sum())
    layout, kinks = without_kinks(layout)
    good = min(_GOOD_START, _NEARLY * corner_shape(surface, layout))
    starts = first_drafts(surface, layout, kinks, goal, good, cancelled)
    best, best_so_far, least = None, None, 0.0
    ladder = _well_shaped(starts, good)
    for rung, (board, start) in enumerate(ladder):
        # Where shapes suffer, the next start that is better shaped is tried.
        if best is not None and start.worst < least:
            continue
        drafts = _with_fewer_blocks(board, start, goal.size, settings.coarseness)
        fine, in_shape = _fine_draft_of(board, drafts, goal, untangle=rung == len(ladder) - 1)
        if fine is None:
            continue
        met = goal.is_met(len(fine.quads.quad))
        if best is None or (met, fine.worst) > best_so_far:
            best, best_so_far = fine, (met, fine.worst)
            least = start.worst + _BETTER if met else 0.0
        if met and in_shape:
            break
    return best


def _with_fewer_blocks(board: DraftBoard, start: Draft, size, coarseness) -> list:
    """Drafts to make the wanted quads of, those with the fewest blocks first.

    The fewest blocks are found by going on from the balanced ones.
    """
    tried = {}
    draft = remove_rows(board, start, size, "balanced", tried)
    if coarseness == "balanced":
        return [draft]
    fewer = remove_rows(board, draft, size, coarseness, tried)
    return [draft] if fewer is draft else [fewer, draft]


def _fine_draft_of(board, drafts, goal, untangle):
    """(Draft, bool): the wanted quads of the first draft whose shape they keep; does any keep it?

    Without one those of the best shape; None without any that are valid.
    """
    found = []
    for draft in drafts:
        fine = _fine_draft(board, draft, goal, untangle)
        if fine is None:
            continue
        found.append(fine)
        if fine.worst >= min(_LEAST_FINE, _FINE_KEPT * draft.worst):
            return fine, True
    return max(found, key=lambda fine: fine.worst, default=None), False


def _well_shaped(starts, good):
    """Starts of good shape, the fewest blocks first.

    One that is better shaped at hardly more blocks takes the place of the one before.
    """
    best = max((draft.worst for _, draft in starts), default=0.0)
    least = max(min(good, _NEARLY * best), _LEAST_START)
    chosen = []
    for board, draft in sorted(starts, key=lambda pair: pair[1].blocks.count):
        if draft.worst < least:
            continue
        if chosen and (
            draft.blocks.count <= _HARDLY_MORE * chosen[-1][1].blocks.count
            and draft.worst >= chosen[-1][1].worst + _BETTER
        ):
            chosen.pop()
        chosen.append((board, draft))
    return chosen


def remove_rows(
    board: DraftBoard, start: Draft, size, coarseness: str, tried: dict | None = None
) -> Draft:
    """Take out rows of blocks, the thinnest first, as long as the draft keeps its shape.

    size   wanted edge length of the quads: rows thinner than half of it go more easily
    tried  trials of an earlier call, which are gone on with; those of this one are added

    Each removal leaves fewer blocks and a layout that has been verified. (method section 9)
    """
    least = min(_LEAST[coarseness], _SHARE[coarseness] * start.worst)
    draft, seen, failed = start, set(), 0
    tried = {} if tried is None else tried
    while failed < _PATIENCE[coarseness]:
        alive = draft.division > 0
        row = board.rows(draft)
        width = np.bincount(row, np.where(alive, board.widths(draft), 0.0))
        found = None
        for number in np.argsort(width, kind="stable").tolist():
            members = alive & (row == number)
            if not members.any() or members.tobytes() in seen:
                continue
            seen.add(members.tobytes())
            needed = 0.5 * least if width[number] < THIN * size else least
            trial = members.tobytes() + draft.division.tobytes()
            if trial not in tried:
                tried[trial] = _without(board, draft, members, needed)
            elif tried[trial] is not None:
                tried[trial] = board.smoothed(tried[trial], _TRIAL_STAGES, needed)
            found = tried[trial]
            if found is not None:
                break
        if found is None:
            break
        draft, failed = (found, 0) if found.worst >= needed else (draft, failed + 1)
    return draft if draft is start else board.smoothed(draft, _TRIAL_STAGES[1:])


def _without(board, draft, members, needed) -> Draft | None:
    """The draft without the given chords, None if that is not valid or has no fewer blocks.

    needed  worst scaled Jacobian up to which it is smoothed
    """
    try:
        trial = board.connect(np.where(members, 0, draft.division))
        if trial.blocks.count >= draft.blocks.count:
            return None
        return board.smoothed(board.follow(trial, draft), _TRIAL_STAGES, needed)
    except LayoutError:
        return None


def _fine_draft(board: DraftBoard, draft: Draft, goal, untangle: bool) -> Draft | None:
    """The wanted quads of a draft's layout, None if they are not valid.

    Where their shapes suffer, they are placed by way of a mesh between the two; where some stay
    inverted only with `untangle`: it takes long and often does not help.
    """
    try:
        fine = _divided(board, draft, goal)
    except LayoutError:
        return None
    plain = _along_walls(board, board.follow(fine, draft), draft, goal)
    fine = _mended_if_inverted(board, board.smoothed(plain, _FINE_STAGES))
    if fine.worst < _FINE_SHARE * draft.worst and (fine.worst > 0 or untangle):
        again = _by_way_of(board, draft, goal, plain)
        fine = again if again is not None and again.worst > fine.worst else fine
    return fine if fine.worst > 0 else None


def _mended_if_inverted(board: DraftBoard, fine: Draft) -> Draft:
    return board.mended(fine) if fine.worst <= 0 else fine


def _divided(board, draft, goal) -> Draft:
    """A draft's layout divided as it is wanted, not placed."""
    division = goal.divide(board, board.widths(draft), board.rows(draft), draft.division > 0)
    return board.connect(division)


def _by_way_of(board, draft, goal, fine) -> Draft | None:
    """The quads of `fine` placed and smoothed in two steps; None if there is nothing between."""
    count = np.sqrt(len(draft.quads.quad) * len(fine.quads.quad))
    size = float(np.sqrt(board.surface.face_area.sum() / count))
    try:
        middle = _divided(board, draft, Goal(size, int(count)))
    except LayoutError:
        return None
    if not len(draft.quads.quad) < len(middle.quads.quad) < len(fine.quads.quad):
        return None
    middle = board.smoothed(board.follow(middle, draft), _TRIAL_STAGES)
    return _mended_if_inverted(board, board.smoothed(board.follow(fine, middle), _FINE_STAGES))


def _along_walls(board: DraftBoard, fine: Draft, draft: Draft, goal) -> Draft:
    """Divided anew where the boundary strays too far from the straight edges of the quads.

    There the chords count as wider than they are; the number of quads stays about as it was.
    """
    width, row, alive = board.widths(draft), board.rows(draft), draft.division > 0
    count = len(fine.quads.quad)
    for _ in range(_MOST_REFINEMENTS):
        size = np.sqrt(board.surface.face_area.sum() / len(fine.quads.quad))
        excess = board.straying(fine) / (_STRAYING * size)
        if excess.max(initial=0.0) <= 1:
            break
        width = width * np.sqrt(np.clip(excess, 1.0, 4.0))
        try:
            trial = board.connect(goal.divide(board, width, row, alive))
        except LayoutError:
            break
        if not 1 / _MOST_MORE < len(trial.quads.quad) / count < _MOST_MORE:
            break
        fine = board.follow(trial, draft)
    return fine
