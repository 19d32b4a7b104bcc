"""Arc lengths for very large quads: zero wherever nothing that must stay apart falls together.

Lengths are solved for without lower bounds, so that thin strips vanish, nearly aligned
singularities come to lie on one line and spirals unwind. Whatever then falls together wrongly is
pulled apart again by lower bounds, and the lengths are solved for anew. (method section 8)
"""

from __future__ import annotations

import numpy as np

from .cells import CellComplex, NodeKind
from .errors import LayoutError
from .gluing import verify_sheets
from .layout import Layout
from .lengths import solve_lengths
from .quads import QuadLayout, build_quads, verify_lengths

# Arcs longer than so many quads do not vanish.
LONGEST_VANISHING = 0.7
# Every boundary loop keeps this share of its length in quads, less one half, and three quads.
LOOP_SHARE = 0.6
LEAST_LOOP = 3
MOST_ROUNDS = 40
# Share of the vanished arcs that is kept where it is not clear which one is to blame.
_BLIND_SHARE = 0.1


def solve_coarse_lengths(layout: Layout, size: float, cancelled=None) -> np.ndarray:
    """(A,) int64, balanced lengths of all arcs for quads of the given edge length, many of them 0.

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
        length = solve_lengths(complex, wish, lower, length, cancelled, may_join=True)
        if _lengthen_loops(*loops, wish, length, lower):
            continue
        try:
            short = arcs_too_short(layout, length)[1]
        except LayoutError:
            wrong = _wrongly_zero(layout, wish, length, lower)
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


def _wrongly_zero(layout: Layout, wish, length, lower) -> np.ndarray:
    """Arcs to keep from vanishing: the longest of each group that joins what must stay apart.

    On a cut surface also of the groups that do so on its charts. Where no such group is to blame,
    the longer ones of all vanished arcs; empty without any. Arcs that were to have a length and have
    none all the same can have none (`length_graph.impossible_arcs`): others must give way.
    """
    zero = np.flatnonzero((length == 0) & (lower == 0))
    if not len(zero):
        return zero
    wrong = _longest_guilty(layout.complex, wish, length, lower)
    if layout.gluing is not None:
        arc = layout.gluing.arc
        on_charts = _longest_guilty(layout.gluing.complex, wish[arc], length[arc], lower[arc])
        wrong = np.union1d(wrong, arc[on_charts])
    if len(wrong):
        return wrong
    return zero[wish[zero] >= np.quantile(wish[zero], 1 - _BLIND_SHARE)]


def _longest_guilty(complex: CellComplex, wish, length, lower) -> np.ndarray:
    """Of the arcs that were allowed to vanish at a vertex that joins wrongly the longest."""
    layout = build_quads(complex, length)
    zero = np.flatnonzero((length == 0) & (lower == 0))
    vertex = layout.node_vertex[complex.arc_node[zero, 0]]
    guilty = _joins_wrongly(complex, layout)[vertex]
    zero, vertex = zero[guilty], vertex[guilty]
    order = np.lexsort([-wish[zero], vertex])
    return zero[order[np.flatnonzero(np.diff(vertex[order], prepend=-1))]]


def _joins_wrongly(complex: CellComplex, layout: QuadLayout) -> np.ndarray:
    """(P,) bool, vertices that hold two nodes that must stay apart, or touch two boundary loops."""
    kinds = (NodeKind.SINGULARITY, NodeKind.CORNER, NodeKind.KINK)
    fixed = layout.node_vertex[np.isin(complex.node_kind, kinds)]
    joined = np.bincount(fixed, minlength=layout.vertex_count) > 1
    wall = np.flatnonzero(complex.arc_loop >= 0)
    vertex = layout.node_vertex[complex.arc_node[wall]].ravel()
    loop = np.repeat(complex.arc_loop[wall], 2)
    lowest = np.full(layout.vertex_count, np.iinfo(np.int64).max)
    highest = np.full(layout.vertex_count, -1)
    np.minimum.at(lowest, vertex, loop)
    np.maximum.at(highest, vertex, loop)
    return joined | (highest > lowest)
