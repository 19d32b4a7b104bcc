"""What cannot be used, or shall not be repaired: one sentence with the place, in the user's numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..surface.surface import connected_components
from .duplicates import find_repeated_corners, find_repeated_polygons
from .flat_triangles import find_flat_triangles
from .manifold import find_bow_ties
from .polygons import Polygons

_LARGEST = 1e100  # beyond it, squares of lengths would overflow


def as_points(points) -> np.ndarray:
    """(V, 3) float64, a copy. Raises InputError for anything else than three numbers a vertex."""
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


def refuse_unusable(points: np.ndarray, polygons: Polygons) -> None:
    """Raise InputError for what no repair can help: no faces, wrong numbers."""
    if polygons.count == 0 or len(polygons.corner) == 0:
        raise InputError("The mesh has no faces; Crossfield needs a surface with faces.")
    outside = (polygons.corner < 0) | (polygons.corner >= len(points))
    if outside.any():
        corner = int(np.argmax(outside))
        raise InputError(
            f"Polygon {polygons.corner_polygon[corner]} refers to vertex"
            f" {polygons.corner[corner]}, but the mesh has {len(points)} vertices, numbered from"
            " 0; correct the number."
        )
    wrong = find_unusable_points(points, polygons)
    if len(wrong):
        place = ", ".join(f"{x:g}" for x in points[wrong[0]])
        raise InputError(
            f"Vertex {wrong[0]}{_and_more(wrong)} lies at ({place}), which no surface can use;"
            " give it finite coordinates or delete it."
        )


def find_unusable_points(points: np.ndarray, polygons: Polygons) -> np.ndarray:
    """Vertices (n,) of polygons with a coordinate that is not finite or too large to square."""
    used = np.unique(polygons.corner)
    return used[~(np.abs(points[used]) < _LARGEST).all(1)]


def refuse_bad_polygons(polygons: Polygons) -> None:
    """Raise InputError for corners, polygons and edges that a repair would change."""
    wrong = np.flatnonzero(polygons.size < 3)
    if len(wrong):
        raise InputError(
            f"Polygon {wrong[0]}{_and_more(wrong)} has fewer than three corners; delete it."
        )
    wrong = find_repeated_corners(polygons)
    if len(wrong):
        polygon, vertex = polygons.corner_polygon[wrong[0]], polygons.corner[wrong[0]]
        raise InputError(
            f"Polygon {polygon}{_and_more(np.unique(polygons.corner_polygon[wrong]))} passes"
            f" vertex {vertex} twice; delete it or give it distinct corners."
        )
    pairs = find_repeated_polygons(polygons)
    if len(pairs):
        raise InputError(
            f"Polygon {pairs[0, 1]}{_and_more(pairs)} has the same corners as polygon"
            f" {pairs[0, 0]}; delete one of the two."
        )
    _refuse_bad_edges(polygons)


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
    for edges in (faults.crowded, faults.twisted):
        if not len(edges):
            continue
        # The place with the smallest polygon number is the easiest to look up.
        corner = int(np.argmax(np.isin(faults.key, edges)))
        a, b = sorted((polygons.corner[corner], polygons.following[corner]))
        those = polygons.corner_polygon[faults.key == faults.key[corner]].tolist()
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


def refuse_flat_triangles(points, triangles, polygon) -> None:
    """Raise InputError for triangles (F, 3) without area; points (V, 3) in a box of size 1."""
    flat = find_flat_triangles(points, triangles)
    if len(flat):
        number = np.unique(polygon[flat])
        raise InputError(
            f"Polygon {number[0]}{_and_more(number)} has no area between its vertices"
            f" {_listed(triangles[flat[0]].tolist())}; dissolve degenerate faces or move the"
            " vertices apart."
        )


def refuse_bow_ties(triangles, mate) -> None:
    """Raise InputError for vertices in which fans of triangles only touch."""
    wrong = find_bow_ties(triangles, mate)
    if len(wrong):
        raise InputError(
            f"Vertex {wrong[0]}{_and_more(wrong)} joins parts of the surface that touch only in"
            " this point; split the vertex or delete one of the parts."
        )


def _and_more(places):
    return f" (and {len(places) - 1:,} more)" if len(places) > 1 else ""


def _listed(numbers):
    """ "1, 2 and 3"; the first few of many."""
    shown = [str(n) for n in numbers[:6]]
    if len(numbers) > 6:
        return ", ".join(shown) + f" and {len(numbers) - 6:,} more"
    return " and ".join([", ".join(shown[:-1]), shown[-1]]) if len(shown) > 1 else shown[0]
