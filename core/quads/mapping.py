"""Quad vertices onto the surface: lattice points read off the cells mapped to their rectangles.

(method section 10)
"""

from __future__ import annotations

import numpy as np

from ..cells.cells import CellComplex, CellMesh, NodeKind
from ..surface.boundary import BoundaryLoops, build_loops
from ..surface.projection import closest_in_triangle, expand_ranges, first_smallest
from ..surface.surface import TriangleSurface
from .candidates import BOUNDARY, FIXED, PLAIN, SINGULAR, Candidates, choose
from .cell_maps import map_cells
from .placement import Placement
from .quads import QuadLayout


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
    mapped  what `map_cells` or `squares_to_rectangles` returns, where it is known already

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
