"""How a surface bends at its vertices: tensors of the bends of the edges, in tangent planes."""

from __future__ import annotations

import numpy as np

from ..surface.surface import TriangleSurface


def bend_tensors(surface: TriangleSurface) -> np.ndarray:
    """(V, 3, 3) float64, half the sum of bend * length * direction squared over a vertex's edges.

    The bend is the signed dihedral angle in radians. Divided by an area this is a shape operator
    with the two principal directions exchanged: an edge bends the surface across itself.
    """
    edge = surface.edges[surface.twin[surface.edges] >= 0]
    here, there = surface.face_normal[edge // 3], surface.face_normal[surface.twin[edge] // 3]
    vector = surface.points[surface.head[edge]] - surface.points[surface.tail[edge]]
    length = np.maximum(np.linalg.norm(vector, axis=1), 1e-300)
    along = vector / length[:, None]
    bend = np.arctan2((np.cross(here, there) * along).sum(1), (here * there).sum(1))
    value = (bend * length)[:, None, None] * along[:, :, None] * along[:, None, :]
    total = np.zeros((surface.vertex_count, 3, 3))
    for end in (surface.tail[edge], surface.head[edge]):
        for i in range(3):
            for j in range(3):
                total[:, i, j] += 0.5 * np.bincount(end, value[:, i, j], surface.vertex_count)
    return total


def in_tangent_planes(surface: TriangleSurface, tensor):
    """The entries (xx, xy, yy), each (V,) float64, of symmetric tensors (V, 3, 3).

    x runs along the first halfedge of each vertex, y a quarter turn from it.
    """
    first = surface.fan[surface.fan_offset[:-1]]
    normal = surface.vertex_normal
    along = surface.points[surface.head[first]] - surface.points
    along -= (along * normal).sum(1, keepdims=True) * normal
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    across = np.cross(normal, along)
    return tuple(
        np.einsum("vi,vij,vj->v", a, tensor, b)
        for a, b in ((along, along), (along, across), (across, across))
    )


def principal_bends(surface: TriangleSurface, tensor):
    """(smaller, larger), each (V,) float64 >= 0: sizes of the two principal values of tensors."""
    xx, xy, yy = in_tangent_planes(surface, tensor)
    mean, half = np.abs(0.5 * (xx + yy)), np.hypot(0.5 * (xx - yy), xy)
    return np.abs(mean - half), mean + half
