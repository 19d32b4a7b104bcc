"""Chains of feature edges: between the vertices where creases end, meet or reach the boundary.

Masks of feature edges are (3F,) bool over halfedges, true on both halfedges of an edge.
"""

from __future__ import annotations

import numpy as np

from ..surface.surface import TriangleSurface, connected_components


def open_ends(surface: TriangleSurface, crease) -> np.ndarray:
    """(n,) int64, inner vertices where one crease edge ends."""
    degree = np.bincount(surface.tail[crease], minlength=surface.vertex_count)
    return np.flatnonzero((degree == 1) & ~surface.on_boundary)


def find_chains(surface: TriangleSurface, edge):
    """The chains of crease edges.

    edge  (n,) int64, one halfedge of each

    Returns ((n,) int64, number of the chain of each edge; (V,) bool, a chain runs through the
    vertex, if there is one).
    """
    ends = np.concatenate([surface.tail[edge], surface.head[edge]])
    degree = np.bincount(ends, minlength=surface.vertex_count)
    through = (degree == 2) & ~surface.on_boundary
    return joined_at(ends, np.tile(np.arange(len(edge)), 2), through, len(edge)), through


def joined_at(ends, number, joins, count) -> np.ndarray:
    """(count,) int64, numbers of the groups of edges that meet at vertices where `joins` is true.

    ends    (m,) int64, vertices at the ends of edges; number (m,) int64, those edges
    joins   (V,) bool
    count   number of edges
    """
    inner = np.flatnonzero(joins[ends])
    order = inner[np.argsort(ends[inner], kind="stable")]
    same = np.flatnonzero(np.diff(ends[order]) == 0)
    return connected_components(count, number[order[same]], number[order[same + 1]])


def direction(surface: TriangleSurface, halfedge) -> np.ndarray:
    """(..., 3) float64, unit vectors along halfedges (...,)."""
    step = surface.points[surface.head[halfedge]] - surface.points[surface.tail[halfedge]]
    return step / np.maximum(surface.edge_length[halfedge], 1e-300)[..., None]
