"""Any polygons -> an oriented manifold of triangles, with the way back to the user's elements.

What the later stages cannot use is found by one function for each kind of fault, which returns the
places; `clean` refuses the mesh at the first of them, in the user's numbers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .errors import InputError
from .polygons import Polygons, as_polygons
from .surface import connected_components, previous_halfedge
from .triangulation import triangulate

_LARGEST = 1e100  # beyond it, squares of lengths would overflow
_FLAT = 1e-10  # height of a triangle over its longest edge that counts as no height


@dataclass(frozen=True)
class CleanMesh:
    """A consistently oriented manifold of triangles that have area.

    points         (V, 3) float64, in the user's coordinates, every one used by a triangle
    triangles      (F, 3) int64
    vertex_origin  (V,) int64, the user's vertex of each point, in ascending order
    face_origin    (F,) int64, the user's polygon of each triangle, in ascending order
    warnings       sentences for the user
    """

    points: np.ndarray
    triangles: np.ndarray
    vertex_origin: np.ndarray
    face_origin: np.ndarray
    warnings: list


def clean(points, polygons) -> CleanMesh:
    """Check a polygon mesh, cut its polygons into triangles and drop unused vertices.

    points    (V, 3) numbers, object-space lengths
    polygons  (N, 3) or (N, 4) vertex numbers, or a list of index lists

    Raises InputError with one sentence that names the cause, the place and the cure: no faces,
    coordinates that are no numbers, vertex numbers out of range, repeated faces, edges of more
    than two faces, neighbours that disagree on their orientation, faces without area, vertices
    where parts of the surface only touch.
    """
    points, polygons = _as_points(points), as_polygons(polygons)
    _refuse_bad_numbers(points, polygons)
    _refuse_repeated_polygons(polygons)
    _refuse_bad_edges(polygons)
    scaled = _scaled(points, np.unique(polygons.corner))
    triangles, face_origin = triangulate(scaled, polygons)
    _refuse_flat_triangles(scaled, triangles, face_origin)
    _refuse_bow_ties(triangles, len(points))
    return _without_unused(points, triangles, face_origin)


def _as_points(points):
    try:
        points = np.array(points, np.float64)
    except (TypeError, ValueError):
        raise InputError(
            "The vertices are not an array of numbers; give three coordinates for each."
        ) from None
    if points.size == 0:
        points = points.reshape(0, 3)
    if points.ndim != 2 or points.shape[1] != 3:
        raise InputError(
            f"The vertices come as an array of shape {points.shape}; give three coordinates for"
            " each vertex."
        )
    return points


def _refuse_bad_numbers(points, polygons):
    if polygons.count == 0:
        raise InputError("The mesh has no faces; Crossfield needs a surface with faces.")
    wrong = find_unusable_points(points)
    if len(wrong):
        place = ", ".join(f"{x:g}" for x in points[wrong[0]])
        raise InputError(
            f"Vertex {wrong[0]}{_and_more(wrong)} lies at ({place}), which no surface can use;"
            " give it finite coordinates or delete it."
        )
    wrong = np.flatnonzero(polygons.size < 3)
    if len(wrong):
        raise InputError(
            f"Polygon {wrong[0]}{_and_more(wrong)} has fewer than three corners; delete it."
        )
    outside = (polygons.corner < 0) | (polygons.corner >= len(points))
    if outside.any():
        corner = int(np.argmax(outside))
        raise InputError(
            f"Polygon {polygons.corner_polygon[corner]} refers to vertex"
            f" {polygons.corner[corner]}, but the mesh has {len(points)} vertices, numbered from"
            " 0; correct the number."
        )
    wrong = find_repeated_corners(polygons)
    if len(wrong):
        polygon, vertex = polygons.corner_polygon[wrong[0]], polygons.corner[wrong[0]]
        raise InputError(
            f"Polygon {polygon}{_and_more(np.unique(polygons.corner_polygon[wrong]))} passes"
            f" vertex {vertex} twice; delete it or give it distinct corners."
        )


def find_unusable_points(points: np.ndarray) -> np.ndarray:
    """Vertices (n,) with a coordinate that is not finite or too large to square."""
    return np.flatnonzero(~(np.abs(points) < _LARGEST).all(1))


def find_repeated_corners(polygons: Polygons) -> np.ndarray:
    """Corners (n,) whose vertex their polygon has passed before."""
    owner = polygons.corner_polygon
    order = np.lexsort((polygons.corner, owner))
    corner, owner = polygons.corner[order], owner[order]
    again = (corner[1:] == corner[:-1]) & (owner[1:] == owner[:-1])
    return np.sort(order[1:][again])


def find_repeated_polygons(polygons: Polygons) -> np.ndarray:
    """Pairs (n, 2) of polygons with the same vertices: the first such, and the repetition."""
    pairs = [np.zeros((0, 2), np.int64)]
    for size in np.unique(polygons.size):
        number, vertex = polygons.of_size(size)
        vertex = np.sort(vertex, axis=1)
        order = np.lexsort(vertex.T)
        same = (vertex[order[1:]] == vertex[order[:-1]]).all(1)
        first = np.flatnonzero(np.concatenate([[True], ~same]))
        group_first = np.repeat(order[first], np.diff(np.append(first, len(order))))
        again = group_first != order
        pairs.append(np.stack([number[group_first[again]], number[order[again]]], axis=1))
    pairs = np.concatenate(pairs)
    return pairs[np.argsort(pairs[:, 1], kind="stable")]


def _refuse_repeated_polygons(polygons):
    pairs = find_repeated_polygons(polygons)
    if len(pairs):
        raise InputError(
            f"Polygon {pairs[0, 1]}{_and_more(pairs)} has the same corners as polygon"
            f" {pairs[0, 0]}; delete one of the two."
        )


@dataclass(frozen=True)
class EdgeFaults:
    """Edges that no oriented manifold has.

    crowded    (n,) int64, keys of edges with more than two polygons
    twisted    (m,) int64, keys of edges whose two polygons run along them in the same direction
    key        (L,) int64, for each corner, the edge to the next corner: smaller end times the
               number of vertices, plus larger end
    """

    crowded: np.ndarray
    twisted: np.ndarray
    key: np.ndarray


def find_edge_faults(polygons: Polygons) -> EdgeFaults:
    """Edges with too many polygons, and edges along which two polygons disagree."""
    start, end = polygons.corner, polygons.following
    stride = np.int64(polygons.corner.max(initial=0) + 1)
    key = np.minimum(start, end) * stride + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    ordered, forward = key[order], (start < end)[order]
    first = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    count = np.diff(np.append(first, len(ordered)))
    forwards = np.add.reduceat(forward.astype(np.int64), first)
    twisted = (count == 2) & (forwards != 1)
    return EdgeFaults(ordered[first[count > 2]], ordered[first[twisted]], key)


def _refuse_bad_edges(polygons):
    faults = find_edge_faults(polygons)
    owner = polygons.corner_polygon
    for edges in (faults.crowded, faults.twisted):
        if not len(edges):
            continue
        # The place with the smallest polygon number is the easiest to look up.
        corner = int(np.argmax(np.isin(faults.key, edges)))
        a, b = sorted((polygons.corner[corner], polygons.following[corner]))
        those = owner[faults.key == faults.key[corner]].tolist()
        if edges is faults.crowded:
            raise InputError(
                f"The edge between vertices {a} and {b}{_and_more(edges)} belongs to"
                f" {len(those)} polygons ({_listed(those)}); a surface has at most two at an"
                " edge, so delete the others or split them off."
            )
        if _is_one_sided(polygons, faults.key):
            raise InputError(
                f"The surface is one-sided, like a Möbius band, along the edge between vertices"
                f" {a} and {b} of polygons {_listed(those)}; cut it open there."
            )
        raise InputError(
            f"Polygons {_listed(those)} disagree on which side is outside along the edge between"
            f" vertices {a} and {b}{_and_more(edges)}; recalculate the normals."
        )


def _is_one_sided(polygons, key):
    """True when no choice of orientations makes all neighbours agree."""
    order = np.argsort(key, kind="stable")
    pair = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    one, two = order[pair], order[pair + 1]
    owner, forward = polygons.corner_polygon, polygons.corner < polygons.following
    twisted = (forward[one] == forward[two]).astype(np.int64)
    # Two copies of each polygon, one for each side; twisted edges lead to the other side.
    first, second = 2 * owner[one], 2 * owner[two] + twisted
    component = connected_components(
        2 * polygons.count, np.concatenate([first, first ^ 1]), np.concatenate([second, second ^ 1])
    )
    return bool((component[0::2] == component[1::2]).any())


def _scaled(points, used):
    """Used points moved and scaled into a box of size 1, for measuring shapes."""
    lowest = points[used].min(0)
    extent = np.ptp(points[used], axis=0).max()
    return (points - lowest) / (extent if extent > 0 else 1.0)


def find_flat_triangles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Triangles (n,) without area to working precision; points within a box of size 1."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    doubled_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.max([((q - p) ** 2).sum(1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    return np.flatnonzero(doubled_area <= _FLAT * longest)


def _refuse_flat_triangles(points, triangles, face_origin):
    flat = find_flat_triangles(points, triangles)
    if len(flat):
        polygon = np.unique(face_origin[flat])
        corners = _listed(triangles[flat[0]].tolist())
        raise InputError(
            f"Polygon {polygon[0]}{_and_more(polygon)} has no area between its vertices"
            f" {corners}; dissolve degenerate faces or move the vertices apart."
        )


def find_bow_ties(triangles: np.ndarray, vertex_count: int) -> np.ndarray:
    """Vertices (n,) where fans of triangles touch that share no edge there.

    triangles  (F, 3) int64, consistently oriented, at most two at an edge
    """
    tail, head = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    twin = _twins(tail, head, vertex_count)
    degree = np.bincount(tail, minlength=vertex_count)
    start = np.full(vertex_count, -1, np.int64)
    start[tail] = np.arange(len(tail))
    boundary = np.flatnonzero(twin < 0)
    start[tail[boundary]] = boundary
    reached = np.zeros(vertex_count, np.int64)
    vertex = np.flatnonzero(degree)
    current = start[vertex]
    while len(vertex):
        reached[vertex] += 1
        current = twin[previous_halfedge(current)]
        on = (current >= 0) & (current != start[vertex])
        vertex, current = vertex[on], current[on]
    return np.flatnonzero(reached < degree)


def _twins(tail, head, vertex_count):
    """(3F,) int64, the opposite halfedges or -1; no two halfedges have the same ends in order."""
    key = tail * np.int64(vertex_count) + head
    order = np.argsort(key)
    wanted = head * np.int64(vertex_count) + tail
    place = np.minimum(np.searchsorted(key, wanted, sorter=order), len(key) - 1)
    return np.where(key[order[place]] == wanted, order[place], -1)


def _refuse_bow_ties(triangles, vertex_count):
    wrong = find_bow_ties(triangles, vertex_count)
    if len(wrong):
        raise InputError(
            f"Vertex {wrong[0]}{_and_more(wrong)} joins parts of the surface that touch only in"
            " this point; split the vertex or delete one of the parts."
        )


def _without_unused(points, triangles, face_origin):
    used = np.zeros(len(points), bool)
    used[triangles.ravel()] = True
    vertex_origin = np.flatnonzero(used)
    number = np.cumsum(used) - 1
    kept = points[vertex_origin]
    warnings = _warnings(len(points) - len(kept), kept)
    return CleanMesh(kept, number[triangles], vertex_origin, face_origin, warnings)


def _warnings(unused, points):
    warnings = []
    if unused:
        left_out = (
            "vertex that no face uses was" if unused == 1 else "vertices that no face uses were"
        )
        warnings.append(f"{unused:,} {left_out} left out.")
    order = np.lexsort(points.T)
    coincident = int((points[order[1:]] == points[order[:-1]]).all(1).sum())
    if coincident:
        warnings.append(
            f"{coincident:,} {'vertex lies' if coincident == 1 else 'vertices lie'} exactly on"
            " another one without being joined to it; merge vertices by distance if the surface"
            " should hold together there."
        )
    return warnings


def _and_more(places):
    return f" (and {len(places) - 1:,} more)" if len(places) > 1 else ""


def _listed(numbers):
    """ "1, 2 and 3"; the first few of many."""
    shown = [str(n) for n in numbers[:6]]
    if len(numbers) > 6:
        return ", ".join(shown) + f" and {len(numbers) - 6:,} more"
    return " and ".join([", ".join(shown[:-1]), shown[-1]]) if len(shown) > 1 else shown[0]
