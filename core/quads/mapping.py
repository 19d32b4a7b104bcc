"""Quad vertices onto the surface: every cell mapped to its rectangle, lattice points read off.

All cells are parametrised by one sparse system: points on a cell's outline have their places by
arc length, the others are weighted means of their neighbours with positive symmetric weights, so
that no triangle turns over (Tutte's theorem). (method section 10)
"""

from __future__ import annotations

import numpy as np

from ..algebra.linear import SparseMatrix, solve
from ..cells.cells import CellComplex, CellMesh, NodeKind
from ..surface.boundary import BoundaryLoops, build_loops
from ..surface.projection import closest_in_triangle, expand_ranges, first_smallest
from ..surface.surface import TriangleSurface
from .candidates import BOUNDARY, FIXED, PLAIN, SINGULAR, Candidates, choose
from .placement import Placement
from .quads import QuadLayout

_WEIGHT_RANGE = (1e-3, 30.0)  # cut slivers give cotangents of any size
_EXACT_ENOUGH = 1e-5  # relative residual: the vertices are smoothed afterwards


def place_vertices(
    surface: TriangleSurface,
    complex: CellComplex,
    cell_mesh: CellMesh,
    layout: QuadLayout,
    length,
    mapped=None,
) -> Placement:
    """Positions on the surface of all vertices of a quad layout.

    length  (A,) int64, number of quads along each arc
    mapped  what `map_cells` returns, where it is known already

    Nodes keep their positions, vertices of an arc are spread evenly by arc length, those inside a
    cell come from its map onto the rectangle. Where several of these are one vertex (arcs of
    length zero), a corner or kink wins over the boundary, that over a singularity; else the mean
    is projected to the surface.
    """
    loops = build_loops(surface)
    length = np.asarray(length, np.int64)
    sources = (
        node_candidates(complex, layout),
        _arc_candidates(complex, layout, length, loops),
        _cell_candidates(complex, cell_mesh, layout, length, mapped),
    )
    chosen = choose(surface, loops, Candidates.join(*sources))
    return Placement(
        chosen.point, chosen.face, chosen.loop, chosen.loop_position, layout.vertex_fixed.copy()
    )


def node_candidates(complex: CellComplex, layout: QuadLayout) -> Candidates:
    """The nodes of the line graph as places of the vertices that they became."""
    loop = np.full(complex.node_count, -1)
    position = np.zeros(complex.node_count)
    along = np.flatnonzero(complex.arc_loop >= 0)
    loop[complex.arc_node[along, 0]] = complex.arc_loop[along]
    position[complex.arc_node[along, 0]] = complex.arc_loop_start[along]
    fixed = np.isin(complex.node_kind, (NodeKind.CORNER, NodeKind.KINK))
    rank = np.where(complex.node_kind == NodeKind.SINGULARITY, SINGULAR, PLAIN)
    rank = np.where(fixed, FIXED, np.where(loop >= 0, BOUNDARY, rank))
    return Candidates(
        layout.node_vertex, complex.node_position, complex.node_face, loop, position, rank
    )


def _arc_candidates(complex, layout, length, loops: BoundaryLoops):
    """The vertices between the ends of each arc, evenly by arc length."""
    arc, number = expand_ranges(np.ones_like(length), np.maximum(length, 1))
    vertex = layout.arc_vertex[layout.arc_vertex_offset[arc] + number]
    distance = complex.arc_length[arc] * (number / length[arc])
    point, face = _point_on_arc(complex, arc, distance)
    loop, position = complex.arc_loop[arc], np.zeros(len(arc))
    along = np.flatnonzero(loop >= 0)
    position[along] = loops.wrap(loop[along], complex.arc_loop_start[arc[along]] + distance[along])
    point[along], face[along] = loops.point(loop[along], position[along])
    rank = np.where(loop >= 0, BOUNDARY, PLAIN)
    return Candidates(vertex, point, face, loop, position, rank)


def _point_on_arc(complex, arc, distance):
    """(point, face) at an arc length from the first node of each arc."""
    first, last = complex.arc_offset[arc], complex.arc_offset[arc + 1] - 2
    step = np.diff(complex.arc_point, axis=0)
    size = np.linalg.norm(step, axis=1)
    total = np.concatenate([[0.0], np.cumsum(size)])
    goal = total[first] + distance
    index = np.clip(np.searchsorted(total, goal, side="right") - 1, first, last)
    fraction = np.clip((goal - total[index]) / np.maximum(size[index], 1e-300), 0.0, 1.0)
    point = complex.arc_point[index] + fraction[:, None] * step[index]
    return point, complex.arc_point_face[index]


def _cell_candidates(complex, cell_mesh, layout, length, mapped):
    """The lattice points inside every cell, found in its triangles mapped to the rectangle."""
    if mapped is None:
        mapped = map_cells(complex, cell_mesh, layout.cell_shape, length)
    place, triangle = mapped
    cell, column, row = _lattice(layout.cell_shape)
    found, weight = _locate(place, triangle, cell_mesh, layout.cell_shape)
    corner = cell_mesh.point[cell_mesh.triangle[found]]
    width = layout.cell_shape[cell, 0] + 1
    count = len(cell)
    return Candidates(
        layout.grid_vertex[layout.grid_offset[cell] + row * width + column],
        (corner * weight[:, :, None]).sum(1),
        cell_mesh.triangle_face[found],
        np.full(count, -1),
        np.zeros(count),
        np.full(count, PLAIN),
    )


def map_cells(complex: CellComplex, cell_mesh: CellMesh, cell_shape, length):
    """Parametrise the triangles of all cells onto their m x n rectangles.

    cell_shape (C, 2) int64, length (A,) int64. Returns place (M, 2) float64, the image of each
    point of the cell mesh, and live (t,) int64, the triangles of cells that have not vanished.
    """
    live_cell = (cell_shape > 0).all(1)
    live = np.flatnonzero(live_cell[cell_mesh.triangle_cell])
    place = np.zeros((len(cell_mesh.point), 2))
    place[cell_mesh.wall_point] = _wall_places(complex, cell_mesh, cell_shape, length)
    inner = np.zeros(len(place), bool)
    inner[cell_mesh.triangle[live]] = True
    inner[cell_mesh.wall_point] = False
    if inner.any():
        first, second, weight = _edge_weights(cell_mesh.point, cell_mesh.triangle[live])
        place[inner] = _solve_inside(inner, place, first, second, weight)
    return place, live


def _wall_places(complex, cell_mesh, cell_shape, length):
    """(K, 2) float64: outline points by arc length, each arc on its own integer interval."""
    arc = complex.side_halfarc // 2
    total = np.concatenate([[0], np.cumsum(length[arc])])
    side = complex.slot_side
    begin = total[:-1] - total[complex.side_offset[side]]
    slot = cell_mesh.wall_slot
    whole = np.maximum(complex.arc_length[arc[slot]], 1e-300)
    fraction = np.clip(cell_mesh.wall_distance / whole, 0.0, 1.0)
    along = begin[slot] + length[arc[slot]] * fraction
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


def _solve_inside(inner, place, first, second, weight):
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
    return solve(matrix, right_side, tolerance=_EXACT_ENOUGH)


def _lattice(cell_shape):
    """(cell, column, row) of every lattice point strictly inside a cell, (n,) int64 each."""
    inside = np.maximum(cell_shape - 1, 0)
    count = inside.prod(1)
    cell, number = expand_ranges(np.zeros_like(count), count)
    return cell, number % inside[cell, 0] + 1, number // inside[cell, 0] + 1


def _locate(place, live, cell_mesh, cell_shape):
    """Find every inner lattice point in the mapped triangles, in the order of `_lattice`.

    Returns triangle (n,) int64 and barycentric coordinates (n, 3).
    """
    corner = place[cell_mesh.triangle[live]]
    shape = cell_shape[cell_mesh.triangle_cell[live]]
    inside = np.maximum(cell_shape - 1, 0)
    first_slot = np.concatenate([[0], np.cumsum(inside.prod(1))])
    low = np.maximum(np.ceil(corner.min(1) - 1e-9), 1).astype(np.int64)
    high = np.minimum(np.floor(corner.max(1) + 1e-9), shape - 1).astype(np.int64)
    size = np.maximum(high - low + 1, 0)
    item, number = expand_ranges(np.zeros(len(live), np.int64), size.prod(1))
    column = low[item, 0] + number % np.maximum(size[item, 0], 1)
    row = low[item, 1] + number // np.maximum(size[item, 0], 1)
    weight = _plane_weights(corner[item], np.stack([column, row], axis=1))
    depth = weight.min(1)
    hit = np.flatnonzero(depth >= -1e-9)
    cell = cell_mesh.triangle_cell[live[item[hit]]]
    slot = first_slot[cell] + (row[hit] - 1) * inside[cell, 0] + column[hit] - 1
    best = first_smallest(slot, -depth[hit])
    triangle = np.full(first_slot[-1], -1)
    result = np.zeros((first_slot[-1], 3))
    triangle[slot[best]] = live[item[hit[best]]]
    result[slot[best]] = np.clip(weight[hit[best]], 0.0, 1.0)
    missed = np.flatnonzero(triangle < 0)
    if len(missed):
        triangle[missed], result[missed] = _nearest(place, live, cell_mesh, cell_shape, missed)
    return triangle, result / result.sum(1, keepdims=True)


def _plane_weights(corner, goal):
    """(n, 3) barycentric coordinates of goal (n, 2); -inf in triangles without area."""
    a, b, c = corner[:, 0], corner[:, 1], corner[:, 2]
    whole = _cross(b - a, c - a)
    parts = [_cross(q - p, goal - p) for p, q in ((b, c), (c, a), (a, b))]
    flat = whole <= 1e-12
    weight = np.stack(parts, axis=1) / np.where(flat, 1.0, whole)[:, None]
    return np.where(flat[:, None], -np.inf, weight)


def _cross(a, b):
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _nearest(place, live, cell_mesh, cell_shape, slot):
    """Triangle and coordinates of the closest mapped point of the same cell: never fails."""
    cell, column, row = (values[slot] for values in _lattice(cell_shape))
    order = live[np.argsort(cell_mesh.triangle_cell[live], kind="stable")]
    sorted_cell = cell_mesh.triangle_cell[order]
    item, position = expand_ranges(
        np.searchsorted(sorted_cell, cell), np.searchsorted(sorted_cell, cell, side="right")
    )
    corner = np.zeros((len(item), 3, 3))
    corner[:, :, :2] = place[cell_mesh.triangle[order[position]]]
    goal = np.stack([column, row, np.zeros(len(slot))], axis=1)[item]
    weight, _, distance = closest_in_triangle(corner, goal)
    best = first_smallest(item, distance)
    return order[position[best]], weight[best]
