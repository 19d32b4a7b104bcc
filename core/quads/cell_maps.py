"""Every cell mapped to a rectangle of quads, or to the unit square.

All cells are parametrised by one sparse system: points on a cell's outline have their places by
arc length, the others are weighted means of their neighbours with positive symmetric weights, so
that no triangle turns over (Tutte's theorem). (method section 10)
"""

from __future__ import annotations

import numpy as np

from ..algebra.linear import SparseMatrix, solve
from ..cells.cells import CellComplex, CellMesh

_WEIGHT_RANGE = (1e-3, 30.0)  # cut slivers give cotangents of any size
# Relative residuals: vertices are smoothed afterwards. Squares are solved for only once, and what
# is regular on them must come out as regular.
_EXACT_ENOUGH, _SQUARES = 1e-5, 1e-7


def map_cells(complex: CellComplex, cell_mesh: CellMesh, cell_shape, length):
    """Parametrise the triangles of all cells onto their m x n rectangles.

    cell_shape (C, 2) int64, length (A,) int64. Returns place (M, 2) float64, the image of each
    point of the cell mesh, and live (t,) int64, the triangles of cells that have not vanished.
    """
    live = _live_triangles(cell_mesh, cell_shape)
    walls = _wall_places(complex, cell_mesh, cell_shape, length)
    return _flattened(cell_mesh, live, walls, _EXACT_ENOUGH), live


def map_to_squares(complex: CellComplex, cell_mesh: CellMesh) -> np.ndarray:
    """(M, 2) float64: the image of each point of the cell mesh in the unit square of its cell.

    Points on a side have their places by arc length. See `squares_to_rectangles`.
    """
    length = complex.arc_length
    side = np.add.reduceat(length[complex.side_halfarc // 2], complex.side_offset[:-1])
    share = length[complex.side_halfarc // 2] / np.maximum(side[complex.slot_side], 1e-300)
    walls = _on_outline(complex, cell_mesh, share, np.ones((complex.cell_count, 2)))
    return _flattened(cell_mesh, np.arange(len(cell_mesh.triangle)), walls, _SQUARES)


def squares_to_rectangles(complex: CellComplex, cell_mesh: CellMesh, square, cell_shape, length):
    """What `map_cells` returns, nearly, from the map to squares: without solving anything.

    square  (M, 2) float64, as of `map_to_squares`

    Inside, the shifts along opposite sides that their arcs need are blended. Good enough for
    vertices that are smoothed afterwards, and much faster where many lengths are tried.
    """
    cell = np.zeros(len(cell_mesh.point), np.int64)
    cell[cell_mesh.triangle] = cell_mesh.triangle_cell[:, None]
    m, n = cell_shape[cell].T
    u, v = square.T
    low = _lattice_along(complex, length, 4 * cell, u)
    right = _lattice_along(complex, length, 4 * cell + 1, v)
    high = m - _lattice_along(complex, length, 4 * cell + 2, 1 - u)
    left = n - _lattice_along(complex, length, 4 * cell + 3, 1 - v)
    place = np.stack([low + v * (high - low), left + u * (right - left)], axis=1)
    place[cell_mesh.wall_point] = _wall_places(complex, cell_mesh, cell_shape, length)
    return place, _live_triangles(cell_mesh, cell_shape)


def _lattice_along(complex, length, side, fraction):
    """(n,) float64: places in quads along sides (n,), at fractions (n,) of their arc length."""
    arc = complex.side_halfarc // 2
    way = np.concatenate([[0.0], np.cumsum(complex.arc_length[arc])])
    total = np.concatenate([[0], np.cumsum(length[arc])])
    first, last = complex.side_offset[side], complex.side_offset[side + 1]
    goal = way[first] + fraction * (way[last] - way[first])
    slot = np.clip(np.searchsorted(way, goal, side="right") - 1, first, last - 1)
    share = (goal - way[slot]) / np.maximum(complex.arc_length[arc[slot]], 1e-300)
    return total[slot] - total[first] + length[arc[slot]] * np.clip(share, 0.0, 1.0)


def _live_triangles(cell_mesh, cell_shape):
    return np.flatnonzero((cell_shape > 0).all(1)[cell_mesh.triangle_cell])


def _flattened(cell_mesh, live, walls, tolerance):
    """(M, 2) float64: the points of some triangles, given those on the outlines of their cells."""
    place = np.zeros((len(cell_mesh.point), 2))
    place[cell_mesh.wall_point] = walls
    inner = np.zeros(len(place), bool)
    inner[cell_mesh.triangle[live]] = True
    inner[cell_mesh.wall_point] = False
    if inner.any():
        first, second, weight = _edge_weights(cell_mesh.point, cell_mesh.triangle[live])
        place[inner] = _solve_inside(inner, place, first, second, weight, tolerance)
    return place


def _wall_places(complex, cell_mesh, cell_shape, length):
    """(K, 2) float64: outline points by arc length, each arc on its own integer interval."""
    return _on_outline(complex, cell_mesh, length[complex.side_halfarc // 2], cell_shape)


def _on_outline(complex, cell_mesh, slot_length, cell_shape):
    """(K, 2) float64: outline points in rectangles (C, 2), given the lengths (S,) of all slots."""
    total = np.concatenate([np.zeros(1, slot_length.dtype), np.cumsum(slot_length)])
    side = complex.slot_side
    begin = total[:-1] - total[complex.side_offset[side]]
    slot = cell_mesh.wall_slot
    whole = np.maximum(complex.arc_length[complex.side_halfarc[slot] // 2], 1e-300)
    fraction = np.clip(cell_mesh.wall_distance / whole, 0.0, 1.0)
    along = begin[slot] + slot_length[slot] * fraction
    m, n = cell_shape[side[slot] // 4].T
    which = side[slot] % 4
    x = np.choose(which, [along, m, m - along, 0.0])
    y = np.choose(which, [0.0, along, n, n - along])
    return np.stack([x, y], axis=1)


def _edge_weights(point, triangle):
    """Each edge once, with the clamped mean cotangent of the angles opposite it."""
    tail, head = triangle.ravel(), np.roll(triangle, -1, axis=1).ravel()
    opposite = np.roll(triangle, -2, axis=1).ravel()
    a, b = point[tail] - point[opposite], point[head] - point[opposite]
    area, dot = np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(1)
    cotangent = dot / np.maximum(np.maximum(area, 1e-9 * np.abs(dot)), 1e-300)
    key = np.minimum(tail, head) * np.int64(len(point)) + np.maximum(tail, head)
    edge, member = np.unique(key, return_inverse=True)
    weight = np.bincount(member.ravel(), 0.5 * cotangent, len(edge))
    return edge // len(point), edge % len(point), np.clip(weight, *_WEIGHT_RANGE)


def _solve_inside(inner, place, first, second, weight, tolerance):
    """(n, 2) float64, places of the inner points as weighted means of their neighbours."""
    number = np.cumsum(inner) - 1
    row = np.concatenate([first, second])
    column = np.concatenate([second, first])
    weight = np.concatenate([weight, weight])
    keep = inner[row]
    row, column, weight = number[row[keep]], column[keep], weight[keep]
    count = int(inner.sum())
    walls = ~inner[column]
    right_side = np.stack(
        [
            np.bincount(row[walls], weight[walls] * place[column[walls], axis], count)
            for axis in range(2)
        ],
        axis=1,
    )
    diagonal = np.bincount(row, weight, count)
    linked = ~walls
    matrix = SparseMatrix.from_triplets(
        np.concatenate([row[linked], np.arange(count)]),
        np.concatenate([number[column[linked]], np.arange(count)]),
        np.concatenate([-weight[linked], diagonal]),
        count,
    )
    return solve(matrix, right_side, tolerance=tolerance)
