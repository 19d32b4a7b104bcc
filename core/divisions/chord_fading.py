"""Values known on some edges of a chord, followed by its other edges the less the further away."""

from __future__ import annotations

import numpy as np

from ..blocks.blocks import Blocks
from ..blocks.chords import Chords

# What is known on an edge is followed over this many times the mean length of the chord's edges.
FADING = 10.0


def fade_along_chord(blocks: Blocks, chords: Chords, chord: int, length, value, known) -> np.ndarray:
    """(k, n) float64, values on the k edges of a chord, in ascending order of their numbers.

    chord   its number
    length  (E,) float64, lengths of all block edges
    value   (k, n) float64, known values, and those that the other edges have of their own
    known   (k,) bool

    A free edge balances its differences to its neighbours over their distances with its difference
    to its own value: a screened Laplace equation across the strip of blocks.
    """
    edges = np.flatnonzero(chords.edge_chord == chord)
    if known.all() or not known.any():
        return value.copy()
    side = blocks.block_edge
    first, second = side[:, :2].ravel(), side[:, 2:].ravel()
    rung = np.flatnonzero(chords.edge_chord[first] == chord)
    pair = np.searchsorted(edges, np.stack([first[rung], second[rung]]))
    width = ((length[side[:, [1, 2]]] + length[side[:, [3, 0]]]) / 2).ravel()[rung]
    return _screened_mean(pair, width, ~known, value, FADING * length[edges].mean())


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
