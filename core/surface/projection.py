"""Where points are on the surface: straight walks, closest points, barycentric coordinates.

All functions treat many points at once; a place on the surface is a triangle number and a point
of that triangle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .surface import TriangleSurface, next_halfedge

_WALK_LIMIT = 10_000  # crossings; only a walk that winds round for ever gets there
_TRIANGLES_PER_LEAF = 4
_POINTS_AT_ONCE = 20_000


def barycentric(surface: TriangleSurface, face, point) -> np.ndarray:
    """(n, 3) float64, coordinates of point (n, 3), projected to the plane of triangle face (n,)."""
    a, b, c = (surface.points[surface.triangles[face, k]] for k in range(3))
    return _plane_coordinates(b - a, c - a, point - a, 1.0)


def surface_normal(surface: TriangleSurface, face, point) -> np.ndarray:
    """(n, 3) float64, unit normals interpolated linearly from the vertex normals."""
    weight = np.clip(barycentric(surface, face, point), 0.0, 1.0)
    vector = (surface.vertex_normal[surface.triangles[face]] * weight[:, :, None]).sum(1)
    return vector / np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), 1e-300)


def plane_normal(surface: TriangleSurface, tolerance=1e-9) -> np.ndarray | None:
    """(3,) float64, the unit normal if the whole surface lies in one plane, facing one way.

    tolerance is relative to the diameter. None if the surface is not planar.
    """
    total = (surface.face_normal * surface.face_area[:, None]).sum(0)
    length = np.linalg.norm(total)
    if length < (1 - tolerance) * surface.face_area.sum():
        return None
    normal = total / length
    height = (surface.points - surface.points[0]) @ normal
    return normal if np.ptp(height) <= tolerance * surface.diameter else None


def walk(surface: TriangleSurface, point, face, displacement, wall=False):
    """Move points straight over the triangles, unfolding across edges, stopping at the boundary.

    point         (n, 3) float64, each in its triangle
    face          (n,) int64
    displacement  (n, 3) float64, object-space lengths; turned into the plane of the triangle
    wall          (3F,) bool, halfedges at which a walk ends as it does at the boundary

    Returns (point (n, 3), face (n,)) of the ends.
    """
    face = np.array(face, np.int64)
    weight = np.clip(barycentric(surface, face, point), 0.0, None)
    weight /= weight.sum(1, keepdims=True)
    rest = _turn_into_face(surface, face, np.asarray(displacement, np.float64))
    entered = np.full(len(face), -1)
    moving = np.flatnonzero((rest**2).sum(1) > 0)
    twin = np.where(wall, -1, surface.twin)
    for _ in range(_WALK_LIMIT):
        if not len(moving):
            break
        moving = _cross_one_edge(surface, twin, face, weight, rest, entered, moving)
    corners = surface.points[surface.triangles[face]]
    return (corners * weight[:, :, None]).sum(1), face


def _turn_into_face(surface, face, vector):
    """Vectors rotated into the planes of their triangles, lengths kept."""
    normal = surface.face_normal[face]
    flat = vector - (vector * normal).sum(1, keepdims=True) * normal
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    wanted = np.linalg.norm(vector, axis=1, keepdims=True)
    return flat * (wanted / np.maximum(length, 1e-300))


def _cross_one_edge(surface, across, face, weight, rest, entered, moving):
    """Advance the moving points to the end of the walk or into the next triangle, in place.

    across is the twin of each halfedge, -1 where walks end.
    entered holds the corner opposite the edge that a point came in by (-1 at the start): the walk
    cannot leave by it. Returns those that still move.
    """
    f, d, w = face[moving], rest[moving], weight[moving]
    a, b, c = (surface.points[surface.triangles[f, k]] for k in range(3))
    slope = _plane_coordinates(b - a, c - a, d, 0.0)
    row = np.arange(len(moving))
    came = entered[moving]
    with np.errstate(divide="ignore", invalid="ignore"):
        step = np.where(slope < 0, w / -slope, np.inf)
    step[row[came >= 0], came[came >= 0]] = np.inf
    corner = step.argmin(1)  # the walk leaves by the edge opposite this corner
    fraction = np.minimum(step[row, corner], 1.0)
    leaves = step[row, corner] < 1.0
    w = np.clip(w + fraction[:, None] * slope, 0.0, None)
    w[row[leaves], corner[leaves]] = 0.0
    weight[moving] = w / w.sum(1, keepdims=True)
    halfedge = 3 * f + (corner + 1) % 3
    twin = across[halfedge]
    over = leaves & (twin >= 0)
    moving, halfedge, twin, corner = moving[over], halfedge[over], twin[over], corner[over]
    rest[moving] = _unfold(surface, d[over] * (1 - fraction[over, None]), halfedge, twin)
    at_tail, at_head = weight[moving, (corner + 1) % 3], weight[moving, (corner + 2) % 3]
    weight[moving] = 0.0
    weight[moving, twin % 3] = at_head
    weight[moving, (twin % 3 + 1) % 3] = at_tail
    face[moving], entered[moving] = twin // 3, (twin % 3 + 2) % 3
    return moving


def _unfold(surface, vector, halfedge, twin):
    """Vectors leaving across a halfedge, turned into the plane of the triangle of its twin."""
    along = surface.points[surface.head[halfedge]] - surface.points[surface.tail[halfedge]]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    outward = np.cross(along, surface.face_normal[halfedge // 3])
    inward = np.cross(along, surface.face_normal[twin // 3])
    forward = (vector * along).sum(1, keepdims=True)
    return forward * along + (vector * outward).sum(1, keepdims=True) * inward


def closest_point(surface: TriangleSurface, points, start_face=None):
    """Closest points of the surface.

    points      (n, 3) float
    start_face  (n,) int or None. With it, the search descends over neighbouring triangles from
                there: fast, and the closest point near the start. Without, the closest point of
                the whole surface, by a hierarchy of boxes.

    Returns (point (n, 3) float64, face (n,) int64).
    """
    points = np.asarray(points, np.float64).reshape(-1, 3)
    if start_face is not None:
        return _descend(surface, points, np.array(start_face, np.int64))
    if not len(points):
        return points.copy(), np.zeros(0, np.int64)
    if "box tree" not in surface.derived:
        surface.derived["box tree"] = _build_tree(surface)
    tree = surface.derived["box tree"]
    pieces = [
        _search_tree(surface, tree, points[first : first + _POINTS_AT_ONCE])
        for first in range(0, len(points), _POINTS_AT_ONCE)
    ]
    return tuple(np.concatenate(column) for column in zip(*pieces))


def _descend(surface, points, face):
    weight, place, distance = closest_in_triangle(surface.points[surface.triangles[face]], points)
    active = np.arange(len(points))
    while len(active):
        item, candidate = _neighbours(surface, face[active], weight[active])
        item = active[item]
        corner = surface.points[surface.triangles[candidate]]
        new_weight, new_place, new_distance = closest_in_triangle(corner, points[item])
        best = first_smallest(item, new_distance)
        best = best[new_distance[best] < distance[item[best]] * (1 - 1e-12)]
        active = item[best]
        face[active], weight[active] = candidate[best], new_weight[best]
        place[active], distance[active] = new_place[best], new_distance[best]
    return place, face


def _neighbours(surface, face, weight):
    """Triangles across the edge, or round the vertex, that each closest point lies on.

    Returns (item, face): positions in the input and the triangles to try for them.
    """
    zero = weight == 0
    count = zero.sum(1)
    on_edge = np.flatnonzero(count == 1)
    twin = surface.twin[next_halfedge(3 * face[on_edge] + zero[on_edge].argmax(1))]
    on_edge, twin = on_edge[twin >= 0], twin[twin >= 0]
    at_vertex = np.flatnonzero(count == 2)
    vertex = surface.triangles[face[at_vertex], weight[at_vertex].argmax(1)]
    item, position = expand_ranges(surface.fan_offset[vertex], surface.fan_offset[vertex + 1])
    item, around = at_vertex[item], surface.fan[position] // 3
    return np.concatenate([on_edge, item]), np.concatenate([twin // 3, around])


def closest_in_triangle(corner, points):
    """Closest points of single triangles: row i of one belongs to row i of the other.

    corner (n, 3, 3) float64, points (n, 3) float64. Returns barycentric coordinates (n, 3), exactly
    zero where the closest point lies on the outline; the points (n, 3); squared distances (n,).
    """
    edge = np.roll(corner, -1, axis=1) - corner
    relative = points[:, None] - corner
    weight = _plane_coordinates(edge[:, 0], -edge[:, 2], relative[:, 0], 1.0)
    outside = np.flatnonzero((weight <= 0).any(1) | ~np.isfinite(weight).all(1))
    if len(outside):
        weight[outside] = _closest_on_outline(edge[outside], relative[outside])
    place = (corner * weight[:, :, None]).sum(1)
    return weight, place, ((points - place) ** 2).sum(1)


def _closest_on_outline(edge, relative):
    """(n, 3) barycentric coordinates of the closest point on the three edges of a triangle."""
    along = (edge * relative).sum(2) / np.maximum((edge**2).sum(2), 1e-300)
    along = np.clip(along, 0.0, 1.0)
    distance = ((relative - along[:, :, None] * edge) ** 2).sum(2)
    row, best = np.arange(len(edge)), distance.argmin(1)
    weight = np.zeros((len(edge), 3))
    weight[row, best] = 1 - along[row, best]
    weight[row, (best + 1) % 3] = along[row, best]
    return weight


def _plane_coordinates(first, second, vector, total):
    """(n, 3): vector = result[1] * first + result[2] * second, summing with result[0] to total."""
    g11, g12, g22 = (first * first).sum(1), (first * second).sum(1), (second * second).sum(1)
    d1, d2 = (vector * first).sum(1), (vector * second).sum(1)
    determinant = np.maximum(g11 * g22 - g12 * g12, 1e-300)
    u = (g22 * d1 - g12 * d2) / determinant
    v = (g11 * d2 - g12 * d1) / determinant
    return np.stack([total - u - v, u, v], axis=1)


@dataclass(frozen=True)
class _BoxTree:
    """Triangles halved again and again along the longest direction; level l has 2**l nodes.

    order  (F,) int64, triangles sorted so that every node is a range
    start  per level (2**l + 1,) int64, node i is order[start[i]:start[i + 1]]
    low, high, sample  per level (2**l, 3) float64: box, and some point of the surface in it
    """

    order: np.ndarray
    start: list
    low: list
    high: list
    sample: list


def _build_tree(surface) -> _BoxTree:
    corner = surface.points[surface.triangles]
    low, high, centre = corner.min(1), corner.max(1), corner.mean(1)
    count = len(corner)
    order = np.arange(count)
    levels = max(int(np.log2(max(count / _TRIANGLES_PER_LEAF, 1))), 0) + 1
    starts = [(count * np.arange(2**level + 1)) >> level for level in range(levels)]
    for start in starts[:-1]:
        node = np.repeat(np.arange(len(start) - 1), np.diff(start))
        sorted_centre = centre[order]
        lowest = np.minimum.reduceat(sorted_centre, start[:-1])
        highest = np.maximum.reduceat(sorted_centre, start[:-1])
        axis = (highest - lowest).argmax(1)[node]
        order = order[np.lexsort((sorted_centre[np.arange(count), axis], node))]
    return _BoxTree(
        order,
        starts,
        [np.minimum.reduceat(low[order], start[:-1]) for start in starts],
        [np.maximum.reduceat(high[order], start[:-1]) for start in starts],
        [centre[order[(start[:-1] + start[1:]) // 2]] for start in starts],
    )


def _search_tree(surface, tree, points):
    """Descend all levels for all points at once, dropping boxes that are too far away."""
    item, node = np.arange(len(points)), np.zeros(len(points), np.int64)
    bound = np.full(len(points), np.inf)
    for level, (low, high, sample) in enumerate(zip(tree.low, tree.high, tree.sample)):
        if level:
            item, node = np.repeat(item, 2), (2 * node[:, None] + [0, 1]).ravel()
        point = points[item]
        np.minimum.at(bound, item, ((point - sample[node]) ** 2).sum(1))
        outside = np.maximum(np.maximum(low[node] - point, point - high[node]), 0.0)
        near = (outside**2).sum(1) <= bound[item] * (1 + 1e-12)
        item, node = item[near], node[near]
    pair, position = expand_ranges(tree.start[-1][node], tree.start[-1][node + 1])
    item, face = item[pair], tree.order[position]
    corner = surface.points[surface.triangles[face]]
    _, place, distance = closest_in_triangle(corner, points[item])
    best = first_smallest(item, distance)
    return place[best], face[best]


def expand_ranges(first, last):
    """Ranges first[i]:last[i] written out: (i repeated, the numbers in the ranges), int64."""
    count = last - first
    item = np.repeat(np.arange(len(count)), count)
    return item, np.arange(len(item)) - np.repeat(np.cumsum(count) - count - first, count)


def first_smallest(item, value):
    """Positions of the smallest value of each item, in the order of the items."""
    order = np.lexsort((value, item))
    return order[np.unique(item[order], return_index=True)[1]]
