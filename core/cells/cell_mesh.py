"""The surface cut along the arcs: components, and the triangles of each cell.

Polygons are numbered over the whole surface: first the triangles that no line crosses, then the
pieces of the others. Two polygon corners are the same point of a cell if a side that is no wall
joins them; so a point of an arc appears once for every time that a cell's boundary passes it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..surface.surface import connected_components, next_halfedge
from .cells import CellComplex, CellMesh
from .streamlines import LineGraph


@dataclass(frozen=True)
class Pieces:
    """All polygons of the cut surface, and how they hang together.

    corner_offset  (N + 1,) int64, corners of polygon n
    corner_point   (.,) int64, point number of each corner
    polygon_face   (N,) int64, triangle of the LineField
    joined         (J, 2) int64, corners that are the same point of a cell
    component      (N,) int64, polygons connected without crossing a wall
    wall_corner    dict (point, following point) -> corner, for sides on chords and boundary
    """

    corner_offset: np.ndarray
    corner_point: np.ndarray
    polygon_face: np.ndarray
    joined: np.ndarray
    component: np.ndarray
    wall_corner: dict


def cut_pieces(graph: LineGraph) -> Pieces:
    """Polygons, their adjacency and their connected components."""
    lines = graph.lines
    crossed = np.zeros(len(lines.triangle), bool)
    crossed[list(graph.splits)] = True
    whole = np.flatnonzero(~crossed)
    first_corner = np.full(len(lines.triangle), -1, np.int64)
    first_corner[whole] = 3 * np.arange(len(whole))
    polygons = [(face, p) for face, split in graph.splits.items() for p in split.polygons]
    pieces = np.array([len(p.points) for _, p in polygons], np.int64)
    sizes = np.concatenate([np.full(len(whole), 3), pieces])
    offset = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    point = np.concatenate(
        [lines.triangle[whole].ravel(), np.array([q for _, p in polygons for q in p.points], np.int64)]
    )
    face = np.concatenate([whole, np.array([f for f, _ in polygons], np.int64)])
    inner, wall_corner = _sides_of_pieces(polygons, offset[len(whole) :])
    joined = np.concatenate(
        [
            _join_whole(lines, crossed, first_corner),
            _join_pieces(lines, crossed, first_corner, inner),
        ]
    )
    _add_whole_walls(lines, crossed, first_corner, wall_corner)
    owner = np.repeat(np.arange(len(sizes)), sizes)
    component = connected_components(len(sizes), owner[joined[:, 0]], owner[joined[:, 1]])
    return Pieces(offset, point, face, joined, component, wall_corner)


def _sides_of_pieces(polygons, offset):
    """Sides of the pieces by end points: corner pairs on edges of triangles; first corner of all."""
    inner, walls = {}, {}
    for (_, polygon), begin in zip(polygons, offset.tolist()):
        points, count = polygon.points, len(polygon.points)
        for k in range(count):
            after = (k + 1) % count
            if polygon.tags[k] < 3:
                inner[points[k], points[after]] = (begin + k, begin + after)
            else:
                walls[points[k], points[after]] = begin + k
    # Where a line turned back, its chord and the piece of the edge beside it join the same points.
    return inner, {**{side: begin for side, (begin, _) in inner.items()}, **walls}


def _join_whole(lines, crossed, first_corner):
    """Corners joined across edges between two triangles that no line crosses."""
    halfedge = np.arange(len(lines.twin))
    twin = lines.twin
    both = (halfedge < twin) & ~crossed[halfedge // 3] & ~crossed[twin // 3]
    here, there = halfedge[both], twin[both]

    def corner(h):
        return first_corner[h // 3] + h % 3

    start = np.stack([corner(here), corner(next_halfedge(there))], axis=1)
    end = np.stack([corner(next_halfedge(here)), corner(there)], axis=1)
    return np.concatenate([start, end])


def _join_pieces(lines, crossed, first_corner, inner):
    """Corners joined across edges of triangles that lines cross."""
    whole = _whole_sides_beside(lines, crossed, first_corner)
    pairs = []
    for (first, second), (begin, end) in inner.items():
        other = inner.get((second, first)) or whole.get((second, first))
        if other is not None:
            pairs += [(begin, other[1]), (end, other[0])]
    return np.array(pairs, np.int64).reshape(-1, 2)


def _whole_sides_beside(lines, crossed, first_corner):
    """Sides of uncrossed triangles next to crossed ones: (tail, head) -> their corners."""
    halfedge = np.arange(len(lines.twin))
    beside = (lines.twin >= 0) & ~crossed[halfedge // 3] & crossed[lines.twin // 3]
    h = halfedge[beside]
    tail, head = lines.triangle.ravel()[h], lines.triangle.ravel()[next_halfedge(h)]
    begin, end = first_corner[h // 3] + h % 3, first_corner[h // 3] + next_halfedge(h) % 3
    return dict(
        zip(zip(tail.tolist(), head.tolist()), zip(begin.tolist(), end.tolist()))
    )


def _add_whole_walls(lines, crossed, first_corner, wall_corner):
    """Boundary sides of uncrossed triangles."""
    boundary = np.flatnonzero(lines.twin < 0)
    plain = boundary[~crossed[boundary // 3]]
    tail, head = lines.triangle.ravel()[plain], lines.triangle.ravel()[next_halfedge(plain)]
    corner = first_corner[plain // 3] + plain % 3
    wall_corner.update(zip(zip(tail.tolist(), head.tolist()), corner.tolist()))


def build_cell_mesh(graph: LineGraph, pieces: Pieces, arcs, complex_: CellComplex) -> CellMesh:
    """Triangulate all pieces, with points of its own for every cell.

    arcs  list of cell_complex.Arc, in the order of the complex
    """
    corners = len(pieces.corner_point)
    shared = connected_components(corners, pieces.joined[:, 0], pieces.joined[:, 1])
    point = np.empty((int(shared.max()) + 1, 3))
    point[shared] = graph.positions[pieces.corner_point]
    triangle, polygon, centers = _triangulate(pieces, shared, point)
    wall_corner, wall_slot, wall_distance = _wall_points(pieces, arcs, complex_, graph.positions)
    owner = np.searchsorted(pieces.corner_offset, wall_corner, side="right") - 1
    component_cell = np.full(int(pieces.component.max()) + 1, -1, np.int64)
    component_cell[pieces.component[owner]] = complex_.slot_cell[wall_slot]
    return CellMesh(
        point=np.concatenate([point, centers]),
        triangle=triangle,
        triangle_cell=component_cell[pieces.component[polygon]],
        triangle_face=graph.lines.origin_face[pieces.polygon_face[polygon]],
        wall_point=shared[wall_corner],
        wall_slot=wall_slot,
        wall_distance=wall_distance,
    )


def _triangulate(pieces, shared, point):
    """Triangles as they are; larger pieces as stars round their middle, which cannot fold.

    So are pieces of two corners, without area, where a line turned back to its side of entry.
    """
    size = np.diff(pieces.corner_offset)
    simple = np.flatnonzero(size == 3)
    first = pieces.corner_offset[simple]
    whole = shared[first[:, None] + np.arange(3)]
    large = np.flatnonzero(size != 3)
    begin, count = pieces.corner_offset[large], size[large]
    number = np.repeat(np.arange(len(large)), count)
    within = np.arange(len(number)) - np.repeat(np.cumsum(count) - count, count)
    corner = begin[number] + within
    after = begin[number] + (within + 1) % count[number]
    position = point[shared[corner]]
    total = np.stack([np.bincount(number, position[:, k], len(large)) for k in range(3)], axis=1)
    star = np.stack([shared[corner], shared[after], len(point) + number], axis=1)
    triangle = np.concatenate([whole, star])
    return triangle, np.concatenate([simple, large[number]]), total / count[:, None]


def _wall_points(pieces, arcs, complex_, positions):
    """For every slot the corners along its halfarc and their arc length, without the last."""
    corner, slot, distance = [], [], []
    for number, halfarc in enumerate(complex_.side_halfarc.tolist()):
        points = arcs[halfarc // 2].points
        points = points[::-1] if halfarc % 2 else points
        step = np.linalg.norm(np.diff(positions[points], axis=0), axis=1)
        corner += [pieces.wall_corner[side] for side in zip(points, points[1:])]
        slot += [number] * len(step)
        distance.append(np.concatenate([[0.0], np.cumsum(step)[:-1]]))
    return np.array(corner, np.int64), np.array(slot, np.int64), np.concatenate(distance)
