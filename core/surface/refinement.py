"""Refinement that the cross-field needs: no interior edge joins two vertices of the boundary.

All three vertices of a triangle beyond such an edge, or in an ear of the boundary, have fixed
crosses; a singularity there would send two lines into the same wall.
"""

from __future__ import annotations

import numpy as np

from .edge_splitting import cut_triangles
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
    if not len(edge):
        return surface, np.arange(surface.face_count)
    middle = np.full(len(surface.twin), -1, np.int64)
    middle[edge] = surface.vertex_count + np.arange(len(edge))
    middle[surface.twin[edge]] = middle[edge]
    added = 0.5 * (surface.points[surface.tail[edge]] + surface.points[surface.head[edge]])
    points = np.concatenate([surface.points, added])
    pieces = cut_triangles(points, surface.triangles, middle)
    return build_surface(points, pieces.triangles), pieces.face_origin
