"""Which quad of a mesh lies over each triangle of the surface."""

from __future__ import annotations

import numpy as np

from ..surface.projection import closest_point
from ..surface.surface import TriangleSurface, build_surface
from .placement import Placement


def quads_over_faces(surface: TriangleSurface, placement: Placement, quad) -> np.ndarray:
    """(F,) int64, the quad that is closest to the middle of each triangle; -1 far from all quads.

    quad  (Q, 4) int64, a manifold mesh whose vertices lie on the surface as placement says

    The search starts at the quads whose vertices lie in the triangle or around it: on a thin sheet
    no triangle is given to the quads of the other side.
    """
    vertex_quad = np.zeros(len(placement.point), np.int64)
    vertex_quad[quad.ravel()] = np.repeat(np.arange(len(quad)), 4)
    near = np.full(surface.face_count, -1)
    near[placement.face] = vertex_quad
    _spread(surface, near)
    known = np.flatnonzero(near >= 0)
    triangles = np.stack([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    over = build_surface(placement.point, triangles)
    middle = surface.points[surface.triangles[known]].mean(1)
    near[known] = closest_point(over, middle, 2 * near[known])[1] // 2
    return near


def _spread(surface, near):
    """Give the numbers of faces to their neighbours that have none, until all have one; in place."""
    inner = np.flatnonzero(surface.twin >= 0)
    here, there = inner // 3, surface.twin[inner] // 3
    while True:
        reached = (near[there] < 0) & (near[here] >= 0)
        if not reached.any():
            return
        near[there[reached]] = near[here[reached]]
        open_ends = near[there] < 0
        here, there = here[open_ends], there[open_ends]
