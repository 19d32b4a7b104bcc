"""Where the nodes of block edges lie: spaced as they are, kinks kept, other edges following."""

from __future__ import annotations

import numpy as np

from ..blocks.blocks import Blocks
from ..blocks.chords import Chords
from .chord_fading import fade_along_chord
from .wall_bends import moved_to_bends


def kinks_inside(fixed, blocks: Blocks) -> np.ndarray:
    """(E,) int64, fixed vertices inside each block edge; it needs a division more than these.

    fixed  (P,) bool
    """
    before = np.concatenate([[0], np.cumsum(fixed[blocks.edge_vertex])])
    offset = blocks.edge_offset
    return before[offset[1:] - 1] - before[offset[:-1] + 1]


def edge_indices(blocks: Blocks, chords: Chords, fixed, arcs, count, given, leads, by_arc, bends) -> list:
    """Nodes of all block edges: list of E (n + 1,) float64, places between the old vertices, of 1.

    A place of 1/4 on an edge of 8 old divisions is its third old vertex: lines between nodes at the
    same places of opposite edges follow the old lines.

    fixed  (P,) bool, vertices of the old mesh that stay vertices
    arcs   list of E, arc lengths at the old vertices of each edge
    count  (E,) int64, divisions
    given  list of E, prescribed places of 1, or None
    leads  (E,) bool, edges whose spacing must be kept
    by_arc (E,) bool, prescribed places are arc lengths over the edge's length
    bends  list of E, places of 1 where nodes are wanted, or None

    Where nothing is prescribed an edge is spaced in proportion to the spacing it has. Edges that
    lead and those with kinks or bends are followed by the other edges of their chord, the less the further
    away these are.
    """
    result, leads = [], leads.copy()
    for edge, arc in enumerate(arcs):
        chain = blocks.edge_vertex[blocks.edge_offset[edge] : blocks.edge_offset[edge + 1]]
        old = np.arange(len(arc)) / (len(arc) - 1)
        kinks = old[np.flatnonzero(fixed[chain[1:-1]]) + 1]
        if given[edge] is not None:
            # Only the nearest node moves to a kink, so that the cells at the wall stay.
            index = given[edge].copy()
            if by_arc[edge]:
                index = np.interp(index * arc[-1], arc, old)
            node = _nodes_for(np.interp(kinks, index, np.arange(len(index))), len(index) - 1)
            index[node] = kinks[: len(node)]
        else:
            index = _spaced_as_before(count[edge], kinks)
        leads[edge] |= len(kinks) > 0 and count[edge] != len(arc) - 1
        # Across from prescribed places others are prescribed too, and would not follow.
        if bends is not None and given[edge] is None and len(bends[edge]):
            index = moved_to_bends(index, bends[edge], np.isin(index, kinks))
            leads[edge] = True
        result.append(index)
    _follow_along_chords(blocks, chords, np.array([arc[-1] for arc in arcs]), result, leads)
    return result


def _spaced_as_before(count, kinks):
    index = np.linspace(0, 1, count + 1)
    node = _nodes_for(kinks * count, count)
    if not len(node):
        return index
    kept = kinks[: len(node)]
    return np.interp(index, [0.0, *index[node], 1.0], [0.0, *kept, 1.0])


def _nodes_for(wish, count):
    """Distinct inner nodes, ascending, near the ascending wishes; as many as there are."""
    node = np.rint(wish).astype(np.int64)[: max(count - 1, 0)]
    step = np.arange(len(node))
    node = np.maximum.accumulate(np.maximum(node, 1) - step) + step
    return np.minimum(node, count - 1 - step[::-1])


def _follow_along_chords(blocks, chords, length, index, leads):
    """Edges that do not lead take a mean of their neighbours in the chord and themselves."""
    for chord in np.unique(chords.edge_chord[leads]):
        edges = np.flatnonzero(chords.edge_chord == chord)
        turned = chords.edge_turned[edges]
        alike = np.stack([_turned(index[e], t) for e, t in zip(edges, turned)])
        followed = fade_along_chord(blocks, chords, chord, length, alike, leads[edges])
        for edge, row, turn in zip(edges, followed, turned):
            index[edge] = _turned(row, turn)


def _turned(index, turned):
    return 1 - index[::-1] if turned else index
