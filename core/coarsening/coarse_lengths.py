"""Arc lengths for very large quads: zero wherever nothing that must stay apart falls together.

Lengths are solved for without lower bounds, so that thin strips vanish, nearly aligned
singularities come to lie on one line and spirals unwind. Whatever then falls together wrongly is
pulled apart again by lower bounds, and the lengths are solved for anew. (method section 8)
"""

from __future__ import annotations

import numpy as np

from ..cells.layout import Layout
from ..errors import LayoutError
from ..quads.lengths import solve_lengths
from ..quads.quads import verify_lengths
from ..quads.sheets import verify_sheets
from .vanishing import arcs_to_blame

# Arcs longer than so many quads do not vanish.
LONGEST_VANISHING = 0.7
# Every boundary loop keeps this share of its length in quads, less one half, and three quads.
LOOP_SHARE = 0.6
LEAST_LOOP = 3
MOST_ROUNDS = 40
# Share of the vanished arcs that is kept where it is not clear which one is to blame.
_BLIND_SHARE = 0.1
# At least so many of the arcs to blame are lengthened before lengths are solved anew.
_LEAST_AT_ONCE = 2


def solve_coarse_lengths(
    layout: Layout, size: float, cancelled=None, share: float = 1 / 3
) -> np.ndarray:
    """(A,) int64, balanced lengths of all arcs for quads of the given edge length, many of them 0.

    share  of the arcs to blame for what joins wrongly that are lengthened at a time: with a smaller
           one there are more rounds, and mostly fewer quads in the end

    The quads have been verified to make the surface: no two singularities, corners, kinks,
    boundary loops or feature curves share a vertex. Raises LayoutError if no such lengths were
    found, Cancelled.
    """
    complex = layout.complex
    wish = complex.arc_length / size
    lower = (wish > LONGEST_VANISHING).astype(np.int64)
    loops = _loops(layout)
    length = None
    for _ in range(MOST_ROUNDS):
        length = solve_lengths(
            complex, wish, lower, length, cancelled, may_join=True, polish=False
        )
        if _lengthen_loops(*loops, wish, length, lower):
            continue
        try:
            short = arcs_too_short(layout, length)[1]
        except LayoutError:
            wrong = _wrongly_zero(layout, wish, length, lower, share)
            if not len(wrong):
                raise
            lower[wrong] = 1
            continue
        if not short.any():
            return length
        lower[short] = length[short] + 1
    raise LayoutError("No coarse layout was found; use a smaller size or the direct layout.")


def arcs_too_short(layout: Layout, length):
    """The quads for these lengths (QuadLayout), and (A,) bool: arcs that are too short for them.

    Raises LayoutError where not even longer arcs make the surface, or its charts.
    """
    quads, short = verify_lengths(layout.complex, length, *layout.topology)
    if layout.gluing is not None and not short.any():
        short = verify_sheets(layout.gluing, length)
    return quads, short


def _loops(layout: Layout):
    """Arcs on boundary loops and on both sides of feature curves, and the loop of each."""
    gluing = layout.gluing
    loop = (layout.complex if gluing is None else gluing.complex).arc_loop
    arc = np.arange(len(loop)) if gluing is None else gluing.arc
    return arc[loop >= 0], loop[loop >= 0]


def _lengthen_loops(arc, loop, wish, length, lower) -> bool:
    """Raise the lower bound of one arc of every boundary loop that has become too short."""
    if not len(arc):
        return False
    least = np.maximum(np.ceil(LOOP_SHARE * np.bincount(loop, wish[arc]) - 0.5), LEAST_LOOP)
    short = np.bincount(loop, length[arc]) < least
    for number in np.flatnonzero(short & (np.bincount(loop) > 0)):
        own = arc[loop == number]
        most = own[np.argmax((wish[own] + 1e-9) / (np.maximum(length, lower)[own] + 0.5))]
        lower[most] = max(lower[most], length[most]) + 1
    return bool(short.any())


def _wrongly_zero(layout: Layout, wish, length, lower, share) -> np.ndarray:
    """Arcs to keep from vanishing: the longer ones of those that join what must stay apart.

    On a cut surface also of those that do so on its charts. Once these have a length, shorter ones
    get one too or need none. Where none is to blame, the longer ones of all vanished arcs; empty
    without any. Arcs that were to have a length and have none all the same can have none
    (`length_graph.impossible_arcs`): others must give way.
    """
    free = (length == 0) & (lower == 0)
    wrong = arcs_to_blame(layout.complex, length, free)
    if layout.gluing is not None:
        arc = layout.gluing.arc
        on_charts = arcs_to_blame(layout.gluing.complex, length[arc], free[arc], on_chart=True)
        wrong = np.union1d(wrong, arc[on_charts])
    if len(wrong):
        count = max(_LEAST_AT_ONCE, int(np.ceil(share * len(wrong))))
        return wrong[np.argsort(-wish[wrong], kind="stable")[:count]]
    zero = np.flatnonzero(free)
    if not len(zero):
        return zero
    return zero[wish[zero] >= np.quantile(wish[zero], 1 - _BLIND_SHARE)]
