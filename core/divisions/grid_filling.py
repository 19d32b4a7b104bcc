"""Filling a block with a new grid: the old grid is its geometry, the new sides are given.

Nodes inside lie where the lines between opposite nodes meet in the index square of the old grid,
corrected by what the sides gained in exactness. Lines that leave a wall leave it as the lines of the
old grid do, and are stretched until their first cells have the wanted heights.
"""

from __future__ import annotations

import numpy as np

from .smooth_curves import sample_curve, sample_grid

# The first cell of a line may take this share of the room that it has, on a logarithmic scale.
_MOST_STRETCH = 0.9


def fill_grid(grid, sides, walls=None):
    """A new grid inside new sides of a block.

    grid     (n + 1, m + 1, 3) float64, the old grid
    sides    four pairs, counter-clockwise from the first row: old index (k,) float64 of each node,
             and its point (k, 3) float64
    walls    None, or per side None or a function that gives the first cells (k,) of lines from
             points (k, 3) in directions (k, 3)

    Returns points (N + 1, M + 1, 3) and the old row and column (N + 1, M + 1) of each.
    """
    n, m = grid.shape[0] - 1, grid.shape[1] - 1
    (bottom, _), (right, _), (top, _), (left, _) = sides
    low, high = bottom / m, (m - top[::-1]) / m
    start, end = (n - left[::-1]) / n, right / n
    # Lines between opposite nodes of the index square cross where both equations hold.
    lean, rise = high - low, (end - start)[:, None]
    u = (low + start[:, None] * lean) / (1 - rise * lean)
    v = start[:, None] + u * rise
    gain = [point - sample_curve(line, index) for (index, point), line in zip(
        sides, (grid[0], grid[:, -1], grid[-1, ::-1], grid[::-1, 0])
    )]
    gain = gain[0], gain[1], gain[2][::-1], gain[3][::-1]
    straight = u, v
    if walls and (walls[0] or walls[2]):
        border = sides[0][1], sides[2][1][::-1]
        v = _first_heights_met(
            grid, low, high, straight[1], border, (gain[0], gain[2]), (walls[0], walls[2])
        )
        u = low + _leaving(v) * lean
    if walls and (walls[1] or walls[3]):
        border = sides[3][1][::-1], sides[1][1]
        u = _first_heights_met(
            grid.transpose(1, 0, 2), start, end, straight[0].T, border, (gain[3], gain[1]),
            (walls[3], walls[1]),
        ).T
        if not (walls[0] or walls[2]):
            v = start[:, None] + _leaving(u) * rise
    point = sample_grid(grid, n * v, m * u)
    point += (1 - v)[..., None] * _sample(gain[0], low, u) + v[..., None] * _sample(gain[2], high, u)
    point += (1 - u)[..., None] * _sample(gain[3], start, v) + u[..., None] * _sample(gain[1], end, v)
    return point, n * v, m * u


def _sample(value, at, place):
    """Values (k, 3) known at ascending places (k,), interpolated at many places."""
    return np.stack([np.interp(place, at, value[:, axis]) for axis in range(3)], axis=-1)


def _first_heights_met(grid, low, high, v, border, gain, rules):
    """(N + 1, M + 1) v of the nodes on lines between the first and the last row of a grid.

    low, high  (M + 1,), where the lines start and end, of 1
    v          (N + 1, M + 1), of 1, as straight rows give it; its first and last lines are kept
    border     the new nodes of the first and last row (M + 1, 3)
    gain       two (M + 1, 3), what the first and last row gained over the old grid
    rules      functions for the first cells at the first and the last row, None where it is no wall

    A line is stretched towards a wall until its first cell is as long as the rule says, the less
    the further from the wall, on a logarithmic scale: all its cells grow by little more or less.
    """
    rows, columns = grid.shape[0] - 1, grid.shape[1] - 1
    share = np.linspace(0, 1, 2 * rows + 1)[:, None]
    line = sample_grid(grid, rows * share + 0 * low, columns * (low + _leaving(share) * (high - low)))
    line += (1 - share)[..., None] * gain[0] + share[..., None] * gain[1]
    step = np.linalg.norm(np.diff(line, axis=0), axis=2)
    far = 1.0 if None in rules else 0.5
    result = v.copy()
    if rules[0] is not None:
        height = rules[0](border[0], line[1] - line[0])
        _stretch(result, _places_at(step, height), far)
    if rules[1] is not None:
        height = rules[1](border[1], line[-2] - line[-1])
        turned = 1 - result[::-1]
        _stretch(turned, _places_at(step[::-1], height), far)
        result = 1 - turned[::-1]
    return result


def _leaving(share):
    """Shares from 0 to 1 that start and end slowly: lines leave walls as the old lines do."""
    return share * share * (3 - 2 * share)


def _places_at(step, height):
    """(M + 1,), where lines with steps (K, M + 1) are as long as the heights (M + 1,), of 1."""
    arc = np.concatenate([np.zeros((1, step.shape[1])), np.cumsum(step, axis=0)])
    share = np.linspace(0, 1, len(arc))
    return np.array([np.interp(h, line, share) for h, line in zip(height, arc.T)])


def _stretch(v, first, far):
    """Move the second row of v (N + 1, M + 1) to first (M + 1,), rows near far stay; in place."""
    inner = v[1:-1, 1:-1]
    near = inner[:1]
    room = np.maximum(np.log(far / near), 1e-9)
    share = np.clip(np.log(far / inner) / room, 0.0, 1.0)
    inner *= np.minimum(first[1:-1] / near, np.exp(_MOST_STRETCH * room)) ** share

