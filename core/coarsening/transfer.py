"""From one division of a layout to another: where do the vertices lie now?

Both quad meshes fill the same cells with the same chords, differently divided. A vertex of the new
mesh lies in the old one at known places of its grids, and between its vertices. (method section 10)
"""

from __future__ import annotations

import numpy as np

from ..cells.cells import CellComplex
from ..quads.candidates import BOUNDARY, FIXED, PLAIN, Candidates, choose
from ..quads.mapping import node_candidates
from ..quads.placement import Placement
from ..quads.quads import QuadLayout
from ..surface.boundary import BoundaryLoops, build_loops
from ..surface.projection import closest_point, expand_ranges
from ..surface.surface import TriangleSurface
from .layout_chords import LayoutChords

# Points nearer to the surface than this share of the old quad around them have found their sheet.
_NEAR = 0.1


def transfer(
    surface: TriangleSurface,
    complex: CellComplex,
    chords: LayoutChords,
    old: tuple[np.ndarray, QuadLayout, Placement],
    division,
    layout: QuadLayout,
) -> Placement:
    """Places for a new division of the chords, from those of an old one.

    old       division (count,), QuadLayout and Placement of the old mesh
    division  (count,) int64, the new one; chords of division zero in the old mesh stay at zero
    layout    QuadLayout of the new one

    Corners and kinks stay; boundary vertices go to their place between those of the old mesh along
    the loop, the others between the corners of the old quad, and from there to the closest point
    of the surface nearby. Where a row is taken out its two sides meet in the middle.
    """
    loops = build_loops(surface)
    nodes = node_candidates(complex, layout)
    fixed = nodes.select(nodes.rank == FIXED)
    wall = choose(
        surface, loops,
        Candidates.join(fixed, _boundary_candidates(complex, chords, loops, old, division, layout)),
    )
    inner = _inner_candidates(surface, chords, old, division, layout, wall)
    chosen = choose(surface, loops, Candidates.join(wall, inner))
    return Placement(
        chosen.point, chosen.face, chosen.loop, chosen.loop_position, layout.vertex_fixed.copy()
    )


def _old_coordinates(row, old_size, new_size):
    """Where the lattice points of a new division lie in the old one, on many rows of units at once.

    row       (R + 1,) int64, row r consists of the units row[r] .. row[r + 1] - 1
    old_size, new_size  (units,) int64

    Returns (offset (R + 1,) int64, coordinate float64): row r has the points
    coordinate[offset[r]:offset[r + 1]], in old quads from the start of the row. A point where
    units have been taken out lies in the middle of them.
    """
    old_total, new_total = (np.concatenate([[0], np.cumsum(s)]) for s in (old_size, new_size))
    unit = np.repeat(np.arange(len(new_size)), new_size)
    place = np.arange(len(unit)) - new_total[unit]
    count = np.diff(new_total[row])
    offset = np.concatenate([[0], np.cumsum(count + 1)])
    owner = np.repeat(np.arange(len(count)), count)
    start = old_total[row[:-1]]
    lower = np.zeros(offset[-1])
    upper = np.zeros(offset[-1])
    upper[offset[1:] - 1] = old_total[row[1:]] - start
    rate = old_size[unit] / np.maximum(new_size[unit], 1)
    begin = old_total[unit] + place * rate - start[owner]
    upper[np.arange(len(unit)) + owner] = begin
    lower[np.arange(len(unit)) + owner + 1] = begin + rate
    return offset, 0.5 * (lower + upper)


def _boundary_candidates(complex, chords, loops: BoundaryLoops, old, division, layout):
    """The vertices along boundary arcs, between those of the old mesh by arc length."""
    old_division, old_layout, placement = old
    row = np.searchsorted(chords.unit_arc, np.arange(complex.arc_count + 1))
    size = old_division[chords.unit_chord]
    offset, along = _old_coordinates(row, size, division[chords.unit_chord])
    arc = np.repeat(np.arange(complex.arc_count), np.diff(offset))
    keep = complex.arc_loop[arc] >= 0
    vertex, arc, along = layout.arc_vertex[keep], arc[keep], along[keep]
    loop = complex.arc_loop[arc]
    first = old_layout.arc_vertex_offset[arc]
    last = old_layout.arc_vertex_offset[arc + 1] - 1
    before = np.minimum(first + np.floor(along).astype(np.int64), last)
    after = np.minimum(before + 1, last)
    start = placement.loop_position[old_layout.arc_vertex[before]]
    gap = loops.wrap(loop, placement.loop_position[old_layout.arc_vertex[after]] - start)
    position = loops.wrap(loop, start + gap * (along - np.floor(along)))
    point, face = loops.point(loop, position)
    return Candidates(vertex, point, face, loop, position, np.full(len(arc), BOUNDARY))


def _inner_candidates(surface, chords, old, division, layout, wall: Candidates):
    """All other vertices: the mean of their places in the grids, on the surface."""
    old_division, old_layout, placement = old
    offset, along = _old_coordinates(
        chords.axis_offset, old_division[chords.axis_chord], division[chords.axis_chord]
    )
    m, n = layout.cell_shape.T
    cell, place = expand_ranges(np.zeros_like(m), np.diff(layout.grid_offset))
    column, row = place % (m[cell] + 1), place // (m[cell] + 1)
    x, y = along[offset[2 * cell] + column], along[offset[2 * cell + 1] + row]
    point, around = _in_old_grid(old_layout, placement, cell, x, y)
    _follow_walls(old_layout, layout, wall, cell, (column, row), (x, y), point)
    vertex, count = layout.grid_vertex, np.bincount(layout.grid_vertex)
    mean = np.stack([np.bincount(vertex, point[:, k]) for k in range(3)], 1) / count[:, None]
    start = np.empty((layout.vertex_count, 4), np.int64)
    start[vertex] = around
    inner = np.flatnonzero(layout.vertex_loop < 0)
    start = start[inner]
    diagonal = np.linalg.norm(placement.point[start[:, 3]] - placement.point[start[:, 0]], axis=1)
    point, face = _closest_from(surface, mean[inner], placement.face[start], _NEAR * diagonal)
    none = np.full(len(inner), -1)
    return Candidates(inner, point, face, none, np.zeros(len(inner)), np.full(len(inner), PLAIN))


def _closest_from(surface, points, start, near):
    """The closest of the places (n, 3) on the surface found from several triangles each, (n, k).

    near  (n,) float64, distances from the surface that need no search from another triangle

    A search that descends from one triangle may end where another one passes by; starts farther
    away than the corners of the old quad would lead to other sheets of the surface.
    """
    point, face = closest_point(surface, points, start[:, 0])
    gap = np.linalg.norm(point - points, axis=1)
    for k in range(1, start.shape[1]):
        apart = np.flatnonzero(gap > near)
        other, other_face = closest_point(surface, points[apart], start[apart, k])
        other_gap = np.linalg.norm(other - points[apart], axis=1)
        nearer = other_gap < gap[apart] * (1 - 1e-9)
        chosen = apart[nearer]
        point[chosen], face[chosen] = other[nearer], other_face[nearer]
        gap[chosen] = other_gap[nearer]
    return point, face


def _follow_walls(old_layout, layout, wall, cell, lattice, coordinates, point):
    """Move points (in place) along with the boundary vertices on the sides of their cells.

    The boundary lies beside the straight edges of the old mesh; across one old quad its distance
    from them fades to nothing.
    """
    target = np.zeros((layout.vertex_count, 3))
    target[wall.vertex] = wall.point
    vertex = layout.grid_vertex
    shift = np.where(layout.vertex_loop[vertex, None] >= 0, target[vertex] - point, 0.0)
    (column, row), (x, y) = lattice, coordinates
    m, n = layout.cell_shape[cell].T
    old_m, old_n = old_layout.cell_shape[cell].T
    first = layout.grid_offset[cell]
    total = np.zeros_like(point)
    for distance, on_side in (
        (y, column),
        (old_n - y, n * (m + 1) + column),
        (x, row * (m + 1)),
        (old_m - x, row * (m + 1) + m),
    ):
        total += np.clip(1.0 - distance, 0.0, 1.0)[:, None] * shift[first + on_side]
    point += total


def _in_old_grid(layout, placement, cell, x, y):
    """Bilinear places (n, 3) at coordinates of the old grids, and the old vertices around (n, 4).

    The nearest one comes first.
    """
    m, n = layout.cell_shape[cell].T
    column = np.clip(np.floor(x).astype(np.int64), 0, np.maximum(m - 1, 0))
    row = np.clip(np.floor(y).astype(np.int64), 0, np.maximum(n - 1, 0))
    s, t = (x - column)[:, None], (y - row)[:, None]

    def vertex(i, j):
        place = np.minimum(j, n) * (m + 1) + np.minimum(i, m)
        return layout.grid_vertex[layout.grid_offset[cell] + place]

    corners = [[vertex(column + i, row + j) for i in (0, 1)] for j in (0, 1)]
    (a, b), (c, d) = [[placement.point[v] for v in pair] for pair in corners]
    point = (1 - t) * ((1 - s) * a + s * b) + t * ((1 - s) * c + s * d)
    right, up = (s[:, 0] > 0.5).astype(np.int64), (t[:, 0] > 0.5).astype(np.int64)
    around = [
        vertex(column + np.abs(right - i), row + np.abs(up - j)) for i in (0, 1) for j in (0, 1)
    ]
    return point, np.stack(around, axis=1)
