"""Where the nodes of block edges lie: spaced as they are, kinks kept, other edges following."""

from __future__ import annotations

import numpy as np

from .blocks import Blocks
from .chords import Chords

# Along a chord, the spacing of an edge is followed over this many times the edges' own length.
FADING = 3.0


def kinks_inside(fixed, blocks: Blocks) -> np.ndarray:
    """(E,) int64, fixed vertices inside each block edge; it needs a division more than these.

    fixed  (P,) bool
    """
    before = np.concatenate([[0], np.cumsum(fixed[blocks.edge_vertex])])
    offset = blocks.edge_offset
    return before[offset[1:] - 1] - before[offset[:-1] + 1]


def edge_fractions(blocks: Blocks, chords: Chords, fixed, arcs, count, given, leads) -> list:
    """Nodes of all block edges: list of E (n + 1,) float64, arc length over the edge's length.

    fixed  (P,) bool, vertices of the old mesh that stay vertices
    arcs   list of E, arc lengths at the old vertices of each edge
    count  (E,) int64, divisions
    given  list of E, fractions that are prescribed, or None
    leads  (E,) bool, prescribed fractions that must be kept

    Where nothing is prescribed an edge is spaced in proportion to the spacing it has. Edges that
    lead and those with kinks are followed by the other edges of their chord, the less the further
    away these are.
    """
    result, leads = [], leads.copy()
    for edge, arc in enumerate(arcs):
        chain = blocks.edge_vertex[blocks.edge_offset[edge] : blocks.edge_offset[edge + 1]]
        kinks = arc[np.flatnonzero(fixed[chain[1:-1]]) + 1] / arc[-1]
        if given[edge] is not None:
            # Only the nearest node moves to a kink, so that the cells at the wall stay.
            fraction = given[edge].copy()
            node = _nodes_for(np.interp(kinks, fraction, np.arange(len(fraction))), len(fraction) - 1)
            fraction[node] = kinks[: len(node)]
        else:
            fraction = _spaced_as_before(arc, count[edge], kinks)
        leads[edge] |= len(kinks) > 0 and count[edge] != len(arc) - 1
        result.append(fraction)
    _follow_along_chords(blocks, chords, np.array([arc[-1] for arc in arcs]), result, leads)
    return result


def _spaced_as_before(arc, count, kinks):
    last = len(arc) - 1
    old = arc / arc[-1]
    fraction = np.interp(np.arange(count + 1) * (last / count), np.arange(last + 1), old)
    node = _nodes_for(np.interp(kinks, fraction, np.arange(count + 1)), count)
    if count == last or not len(node):
        return fraction
    kept = kinks[: len(node)]
    return np.interp(
        fraction, [0.0, *fraction[node], 1.0], [0.0, *kept, 1.0]
    )


def _nodes_for(wish, count):
    """Distinct inner nodes, ascending, near the ascending wishes; as many as there are."""
    node = np.rint(wish).astype(np.int64)[: max(count - 1, 0)]
    step = np.arange(len(node))
    node = np.maximum.accumulate(np.maximum(node, 1) - step) + step
    return np.minimum(node, count - 1 - step[::-1])


def _follow_along_chords(blocks, chords, length, fraction, leads):
    """Edges that do not lead take a mean of their neighbours in the chord and themselves."""
    side = blocks.block_edge
    first, second = side[:, :2].ravel(), side[:, 2:].ravel()
    width = ((length[side[:, [1, 2]]] + length[side[:, [3, 0]]]) / 2).ravel()
    for chord in np.unique(chords.edge_chord[leads]):
        edges = np.flatnonzero(chords.edge_chord == chord)
        if leads[edges].all():
            continue
        rung = np.flatnonzero(chords.edge_chord[first] == chord)
        pair = np.searchsorted(edges, np.stack([first[rung], second[rung]]))
        turned = chords.edge_turned[edges]
        known = np.stack([_turned(fraction[e], t) for e, t in zip(edges, turned)])
        distance = FADING * length[edges].mean()
        solved = _screened_mean(pair, width[rung], ~leads[edges], known, distance)
        for row in np.flatnonzero(~leads[edges]):
            fraction[edges[row]] = _turned(solved[row], turned[row])


def _turned(fraction, turned):
    return 1 - fraction[::-1] if turned else fraction


def _screened_mean(pair, width, free, value, distance):
    """Solve for the free rows: differences to neighbours over width balance those to the start."""
    size = len(free)
    matrix = np.zeros((size, size))
    stiffness = 1 / np.maximum(width, 1e-9 * distance)
    np.add.at(matrix, (pair[0], pair[1]), -stiffness)
    np.add.at(matrix, (pair[1], pair[0]), -stiffness)
    share = np.zeros(size)
    np.add.at(share, pair.ravel(), np.tile(width / 2 / distance**2, 2))
    np.fill_diagonal(matrix, np.diag(matrix) - matrix.sum(1) + share)
    right = share[free, None] * value[free] - matrix[np.ix_(free, ~free)] @ value[~free]
    result = value.copy()
    result[free] = np.linalg.solve(matrix[np.ix_(free, free)], right)
    return result
