"""Refinement that the cross-field needs: no interior edge joins two vertices of the boundary.

All three vertices of a triangle beyond such an edge, or in an ear of the boundary, have fixed
crosses; a singularity there would send two lines into the same wall.
"""

from __future__ import annotations

import numpy as np

from .surface import TriangleSurface, build_surface


def split_boundary_chords(surface: TriangleSurface) -> tuple[TriangleSurface, np.ndarray]:
    """Cut every interior edge that joins two boundary vertices at its middle.

    Returns the refined surface, whose first vertices are those of the given one, and
    (F',) int64, the given triangle that each of its triangles is a piece of, in ascending order.
    """
    edge = surface.edges
    inside = surface.twin[edge] >= 0
    joins = surface.on_boundary[surface.tail[edge]] & surface.on_boundary[surface.head[edge]]
    return split_edges(surface, edge[inside & joins])


def split_edges(surface: TriangleSurface, edge) -> tuple[TriangleSurface, np.ndarray]:
    """Cut the given interior edges at their middles.

    edge  (n,) int64, one halfedge of each; its middle becomes vertex V, V + 1, ... in this order

    Returns what `split_boundary_chords` returns.
    """
    middle = _middle_vertices(surface, edge)
    split = (middle >= 0).reshape(-1, 3)
    if not split.any():
        return surface, np.arange(surface.face_count)
    added = 0.5 * (surface.points[surface.tail[edge]] + surface.points[surface.head[edge]])
    points = np.concatenate([surface.points, added])
    pieces, origin = _pieces(points, surface.triangles, middle.reshape(-1, 3), split)
    order = np.argsort(origin, kind="stable")
    return build_surface(points, pieces[order]), origin[order]


def _middle_vertices(surface, cut):
    """(3F,) int64, number of the vertex in the middle of each halfedge that is to be cut, or -1."""
    middle = np.full(len(surface.twin), -1, np.int64)
    middle[cut] = surface.vertex_count + np.arange(len(cut))
    middle[surface.twin[cut]] = middle[cut]
    return middle


def _pieces(points, triangles, middle, split):
    """The pieces of all triangles and the triangle that each comes from."""
    count = split.sum(1)
    whole = np.flatnonzero(count == 0)
    pieces, origin = [triangles[whole]], [whole]
    for cuts, divide in ((1, _in_two), (2, _in_three), (3, _in_four)):
        face = np.flatnonzero(count == cuts)
        # Turned so that the cut edges come first.
        turn = np.argmax(split[face], axis=1)
        turn = np.where((cuts == 2) & split[face, 2] & split[face, 0], 2, turn)
        column = (turn[:, None] + np.arange(3)) % 3
        corner, cut = triangles[face[:, None], column], middle[face[:, None], column]
        parts = divide(points, *corner.T, *cut.T)
        pieces.append(np.concatenate([np.stack(part, axis=1) for part in parts]))
        origin.append(np.tile(face, len(parts)))
    return np.concatenate(pieces), np.concatenate(origin)


def _in_two(_points, a, b, c, ab, _bc, _ca):
    return (a, ab, c), (ab, b, c)


def _in_three(points, a, b, c, ab, bc, _ca):
    """The ear at b, and the remaining quad cut along its shorter diagonal."""
    from_a = np.linalg.norm(points[bc] - points[a], axis=1)
    from_c = np.linalg.norm(points[ab] - points[c], axis=1)
    last = np.where(from_a <= from_c, bc, c)
    first = np.where(from_a <= from_c, a, ab)
    return (ab, b, bc), (a, ab, last), (first, bc, c)


def _in_four(_points, a, b, c, ab, bc, ca):
    return (a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)
