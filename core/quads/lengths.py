"""Integer arc lengths: opposite sides of every cell agree, and each arc comes near its wish.

The cost of an arc with length x and wish t is (x - t)^2 / max(t, 1/2): the squared relative
deviation of the quad size, summed along the arc. A long arc may therefore miss its wish by more
quads than a short one, but by a smaller share; arcs shorter than half a quad all count alike.
(method section 8)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells.cells import CellComplex, NodeKind
from ..errors import Cancelled, LayoutError
from ..surface.surface import connected_components
from .length_graph import (
    LengthGraph,
    Walks,
    build_length_graph,
    cheap_walks,
    impossible_arcs,
    lengthening_walk,
)

# Wishes below this many quads are weighted as if they were this long.
SHORTEST_WISH = 0.5
# Most searches for walks at one step size; every search but the last shortens the way.
MOST_SEARCHES = 2000
# Most rounds of double and single steps at the end.
MOST_POLISHES = 4
# A count of quads this near to the wanted one ends the search for a size at once.
COUNT_TOLERANCE = 0.03


@dataclass
class _Search:
    """A balanced solution being improved; lengths below `lower` cost `penalty` a unit."""

    graph: LengthGraph
    target: np.ndarray
    weight: np.ndarray
    lower: np.ndarray
    length: np.ndarray
    penalty: float = 0.0

    def cost(self, arc, length):
        """Cost of the given arcs at the given lengths; inf below zero."""
        short = np.maximum(self.lower[arc] - length, 0)
        value = self.weight[arc] * (length - self.target[arc]) ** 2 + self.penalty * short
        return np.where(length < 0, np.inf, value)


def solve_lengths(
    complex: CellComplex, target, lower=1, start=None, cancelled=None, may_join=False, polish=True
) -> np.ndarray:
    """Integer lengths that make opposite sides of all cells equal.

    target     (A,) float64, wanted length of each arc in quads
    lower      int or (A,) int, least length; arcs that can only be zero stay at zero
    start      (A,) int64 or None, an earlier solution to improve upon
    cancelled  callable or None, asked between the searches
    may_join   bool, leave it to the caller to see which nodes the zero lengths join
    polish     bool, make up at the end for what single steps miss: better by little, for much time

    Returns (A,) int64. Raises LayoutError where arcs of length zero join two nodes that must stay
    apart (singularities, corners, kinks), Cancelled. With may_join it does so only where these arcs
    can have no other length.
    """
    graph = build_length_graph(complex)
    target = np.asarray(target, np.float64)
    if target.shape != (complex.arc_count,) or not np.isfinite(target).all():
        raise LayoutError("The wanted arc lengths must be finite numbers, one for each arc.")
    impossible = impossible_arcs(graph)
    _refuse_joined_nodes(complex, impossible)
    weight = 1.0 / np.maximum(target, SHORTEST_WISH)
    lower = np.where(impossible, 0, np.broadcast_to(lower, target.shape))
    length = np.zeros(len(target), np.int64) if start is None else np.array(start, np.int64)
    search = _Search(graph, target, weight, np.zeros_like(lower), length)
    step = 1 << max(0, int(np.max(target, initial=1.0) / 2).bit_length())
    step = step if start is None else min(step, 4)
    while step > 1:
        _improve(search, step, cancelled)
        step //= 2
    search.lower = lower
    excess = np.abs(np.maximum(lower, search.length) - target)
    search.penalty = 100.0 * float(np.max(weight * (2 * excess + 1), initial=1.0))
    _improve(search, 1, cancelled)
    _force_lower_bounds(search)
    if polish:
        _polish(search, cancelled)
    if not may_join:
        _refuse_joined_nodes(complex, search.length == 0)
    return search.length


def scale_to_count(complex: CellComplex, target, quad_count, lower=1, cancelled=None):
    """Lengths for a wanted number of quads.

    target      (A,) float64, wanted lengths up to a common factor
    quad_count  wanted number of quads

    Returns (length (A,) int64, factor): the solution for factor * target whose number of quads is
    nearest to the wanted one. The layout bounds what is possible: at least one quad a cell.
    """
    target = np.asarray(target, np.float64)
    factor = np.sqrt(quad_count / max(count_quads(complex, target), 1e-12))
    below, above, best, length = 0.0, np.inf, None, None
    for _ in range(8):
        length = solve_lengths(complex, factor * target, lower, length, cancelled)
        count = max(count_quads(complex, length), 1e-12)
        miss = abs(np.log(count / quad_count))
        if best is None or miss < best[0]:
            best = (miss, length, factor)
        if miss < COUNT_TOLERANCE:
            break
        if count < quad_count:
            below = factor
        else:
            above = factor
        factor *= np.clip(np.sqrt(quad_count / count), 0.2, 5.0)
        if not below < factor < above:
            factor = np.sqrt(max(below, 0.25 * above) * above)
        if factor < 1e-6 * best[2] or abs(above - below) < 1e-3 * above:
            break
    return best[1], float(best[2])


def side_lengths(complex: CellComplex, length) -> np.ndarray:
    """(C, 4) sums of arc lengths along the sides of each cell, of the dtype of length."""
    along = np.asarray(length)[complex.side_halfarc // 2]
    total = np.concatenate([np.zeros(1, along.dtype), np.cumsum(along)])
    return np.diff(total[complex.side_offset]).reshape(-1, 4)


def count_quads(complex: CellComplex, length) -> float:
    """Number of quads; for real lengths the product of the means of opposite sides."""
    sides = side_lengths(complex, length)
    return float((0.25 * (sides[:, 0] + sides[:, 2]) * (sides[:, 1] + sides[:, 3])).sum())


def _refuse_joined_nodes(complex, is_zero):
    """Raise LayoutError if arcs of length zero join two nodes that must stay apart."""
    first, second = complex.arc_node[is_zero].T
    point = connected_components(complex.node_count, first, second)
    kinds = (NodeKind.SINGULARITY, NodeKind.CORNER, NodeKind.KINK)
    fixed = np.flatnonzero(np.isin(complex.node_kind, kinds))
    fixed = fixed[np.argsort(point[fixed], kind="stable")]
    joined = np.flatnonzero(np.diff(point[fixed]) == 0)
    if len(joined):
        a, b = fixed[joined[0]], fixed[joined[0] + 1]
        raise LayoutError(
            f"The layout allows no quad between its nodes {a} and {b}, which must stay apart; "
            "use another relaxation or a finer mesh.",
            complex.node_position[[a, b]],
        )


def _improve(search: _Search, step: int, cancelled):
    """Change lengths by `step` along cheap walks until none lowers the cost."""
    graph, arc = search.graph, np.arange(len(search.target))
    closed = np.zeros(len(graph.edge_change), bool)
    change_cost = np.empty(2 * len(arc))
    for _ in range(MOST_SEARCHES):
        if cancelled is not None and cancelled():
            raise Cancelled("Cancelled while the arc lengths were solved.")
        now = search.cost(arc, search.length)
        change_cost[0::2] = search.cost(arc, search.length + step) - now
        change_cost[1::2] = search.cost(arc, search.length - step) - now
        walks = cheap_walks(graph, np.where(closed, np.inf, change_cost[graph.edge_change]))
        if not _apply_walks(search, walks, step, closed):
            break


def _apply_walks(search, walks: Walks, step, closed) -> bool:
    """Take the walks, cheapest first, that truly lower the cost; False when there is nothing more.

    A walk may make one change twice, for more than twice its price. If that is why it does not pay,
    one of the two edges is closed: the other one still serves all walks that make the change once,
    as each of them exists in both directions.
    """
    progress, changed = False, np.zeros(len(search.target), bool)
    for number in np.argsort(walks.cost, kind="stable").tolist():
        edge = walks.edge[walks.offset[number] : walks.offset[number + 1]]
        change = search.graph.edge_change[edge]
        arc, slot = np.unique(change // 2, return_inverse=True)
        amount = np.bincount(slot.ravel(), 1 - 2 * (change % 2)).astype(np.int64) * step
        before = search.length[arc]
        gain = search.cost(arc, before).sum() - search.cost(arc, before + amount).sum()
        if gain > 1e-9:
            search.length[arc] = before + amount
            changed[arc] = progress = True
        elif len(arc) < len(change):
            _, first, count = np.unique(change, return_index=True, return_counts=True)
            closed[edge[first[count > 1]]] = progress = True
    closed &= ~changed[search.graph.edge_change // 2]
    return progress


def _force_lower_bounds(search):
    """Lengthen along walks through arcs that are still too short; no way back below the bounds."""
    short = np.flatnonzero(search.length < search.lower)
    for arc in short.tolist():
        while search.length[arc] < search.lower[arc]:
            np.add.at(search.length, lengthening_walk(search.graph, arc) // 2, 1)
    if len(short):
        search.penalty *= 1e3


def _polish(search, cancelled):
    """Double steps undo what single ones cannot, where walks must pass an arc twice."""
    for _ in range(MOST_POLISHES):
        before = search.length.copy()
        _improve(search, 2, cancelled)
        _improve(search, 1, cancelled)
        if np.array_equal(before, search.length):
            break
