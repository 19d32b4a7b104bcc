"""One order of vertices and triangles that follows from the shape alone, not from the file.

Ties in later stages - two lines that arrive at the same time, two rows of the same width - are
broken by number. So that the same surface always gets the same blocks, whatever the order of its
vertices and faces and wherever it lies, its elements are numbered by a walk: from one halfedge of
each component, which distances alone single out, breadth first over the neighbours.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..surface.surface import connected_components, match_twins, next_halfedge, previous_halfedge
from .cleaning import CleanMesh

# Distances that differ by less than this share of the largest one are the same.
_SAME = 1e-9


def numbered(mesh: CleanMesh) -> CleanMesh:
    """The same mesh in its own order: `vertex_origin` and `face_origin` follow it.

    Where a surface is symmetric, any of its symmetric halfedges may be the first.
    """
    entry = walk(mesh.points, mesh.triangles)
    corner = np.stack([entry, next_halfedge(entry), previous_halfedge(entry)], axis=1)
    triangles = mesh.triangles.ravel()[corner]
    _, first, here = np.unique(triangles, return_index=True, return_inverse=True)
    vertex = triangles.ravel()[np.sort(first)]
    number = np.empty(len(vertex), np.int64)
    number[np.argsort(first)] = np.arange(len(vertex))
    return replace(
        mesh,
        points=mesh.points[vertex],
        triangles=number[here.reshape(-1, 3)],
        vertex_origin=mesh.vertex_origin[vertex],
        face_origin=mesh.face_origin[entry // 3],
    )


def walk(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(F,) int64, a halfedge of each triangle, by which the walk enters it, in the walk's order.

    points (V, 3) and triangles (F, 3) of an oriented manifold. Components follow one another, those
    of more triangles and, among equals, of more area first.
    """
    twin = match_twins(triangles.ravel(), triangles[:, [1, 2, 0]].ravel(), len(points))
    inner = np.flatnonzero(twin >= 0)
    component = connected_components(len(triangles), inner // 3, twin[inner] // 3)
    seed = _seeds(points, triangles, component)
    levels, reached = [], np.zeros(len(triangles), bool)
    ahead = np.stack([seed, twin[seed]], axis=1).ravel()
    while len(ahead):
        ahead = _first_of_each(ahead[(ahead >= 0) & ~reached[ahead // 3]])
        reached[ahead // 3] = True
        levels.append(ahead)
        ahead = twin[np.stack([next_halfedge(ahead), previous_halfedge(ahead)], axis=1).ravel()]
    entry = np.concatenate(levels)
    rank = _component_ranks(points, triangles, component)
    return entry[np.argsort(rank[component[entry // 3]], kind="stable")]


def _first_of_each(halfedge):
    """Of halfedges of the same triangle only the first one, in their order."""
    return halfedge[np.sort(np.unique(halfedge // 3, return_index=True)[1])]


def _component_ranks(points, triangles, component):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.bincount(component, np.linalg.norm(np.cross(b - a, c - a), axis=1))
    rank = np.empty(len(area), np.int64)
    rank[np.lexsort((-area, -np.bincount(component)))] = np.arange(len(area))
    return rank


def _seeds(points, triangles, component):
    """(components,) int64, the halfedge from which the walk over each component starts.

    The one whose distances are the largest, one distance after the other: of its tail from three
    centres of the component, which differ where it is not symmetric, its length, the distances of
    the other corners of its triangle.
    """
    vertex_part = np.empty(len(points), np.int64)
    vertex_part[triangles] = component[:, None]
    away = _distances(points, vertex_part)
    tail, head = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    apex = triangles[:, [2, 0, 1]].ravel()
    left = np.arange(len(tail))
    for distance in (
        *(column[tail] for column in away.T),
        np.linalg.norm(points[head] - points[tail], axis=1),
        *(column[head] for column in away.T),
        *(column[apex] for column in away.T),
    ):
        part = component[left // 3]
        largest = np.zeros(len(component))
        np.maximum.at(largest, part, distance[left])
        left = left[distance[left] >= largest[part] - _SAME * largest.max()]
    return left[np.unique(component[left // 3], return_index=True)[1]]


def _distances(points, part):
    """(V, 3) float64: of each vertex from three centres of its component.

    The mean of its vertices, and the means with more and more weight on those farther away.
    """
    count = np.bincount(part)
    weight = np.ones(len(points))
    columns = []
    for _ in range(3):
        total = np.maximum(np.bincount(part, weight, len(count)), 1e-300)
        centre = np.stack(
            [np.bincount(part, weight * x, len(count)) / total for x in points.T], axis=1
        )
        columns.append(np.linalg.norm(points - centre[part], axis=1))
        weight = columns[0] ** (2 * len(columns))
    return np.stack(columns, axis=1)
