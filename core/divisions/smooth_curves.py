"""Smooth curves and surfaces through the points of lines and grids, for sampling them anew.

Pieces are cubic, tangents those of the parabolas through three points, by chord length: where
points lie unevenly nothing overshoots. Straight pieces instead would leave kinks at all old points,
which fold cells that are thinner than these kinks are high.
"""

from __future__ import annotations

import numpy as np


def sample_line(point, index):
    """Points (n, 3) of a polyline through points (k, 3) at indices (n,) from 0 to k - 1."""
    low, part = _pieces(index, len(point))
    return (1 - part) * point[low] + part * point[low + 1]


def sample_curve(point, index):
    """Points (n, 3) of the smooth curve through points (k, 3) at indices (n,) from 0 to k - 1."""
    low, part = _pieces(index, len(point))
    leaving, arriving = _bends(point)
    bend = part * (1 - part) ** 2 * leaving[low] + part**2 * (1 - part) * arriving[low]
    return sample_line(point, index) + bend


def sample_grid(grid, row, column):
    """Points (..., 3) of the smooth surface through a grid (n + 1, m + 1, 3).

    row, column  (...) float64, indices into the grid

    Its rows and columns are the smooth curves through their points.
    """
    (j, b), (i, a) = _pieces(row, grid.shape[0]), _pieces(column, grid.shape[1])
    rows = _bends(grid.transpose(1, 0, 2))
    leaving, arriving = (bend.transpose(1, 0, 2) for bend in rows)
    below, above = (
        (1 - a) * grid[k, i] + a * grid[k, i + 1]
        + a * (1 - a) ** 2 * leaving[k, i] + a**2 * (1 - a) * arriving[k, i]
        for k in (j, j + 1)
    )
    leaving, arriving = ((1 - a) * bend[j, i] + a * bend[j, i + 1] for bend in _bends(grid))
    across = b * (1 - b) ** 2 * leaving + b**2 * (1 - b) * arriving
    return (1 - b) * below + b * above + across


def _pieces(index, count):
    """The piece in which each index lies, and the place in it, of 1, with an axis for coordinates."""
    low = np.clip(np.floor(index).astype(np.int64), 0, count - 2)
    return low, (np.asarray(index) - low)[..., None]


def _bends(point):
    """By how much curves along axis 0 of points (k, ..., 3) leave and arrive at their pieces
    otherwise than straight ones, two (k - 1, ..., 3)."""
    step = np.diff(point, axis=0)
    size = np.maximum(np.linalg.norm(step, axis=-1, keepdims=True), 1e-300)
    slope = step / size
    if len(step) < 2:
        return np.zeros_like(step), np.zeros_like(step)
    inner = (size[:-1] * slope[1:] + size[1:] * slope[:-1]) / (size[:-1] + size[1:])
    tangent = np.concatenate([2 * slope[:1] - inner[:1], inner, 2 * slope[-1:] - inner[-1:]])
    return size * (tangent[:-1] - slope), size * (slope - tangent[1:])
