"""One side of the surface chosen as its outside, the same for all neighbours.

Each triangle is looked at from both sides: two copies, glued to the copies of its neighbours that
agree with them. Where the two copies of one triangle hang together the surface is one-sided and
has to be cut.
"""

from __future__ import annotations

import numpy as np

from ..surface.surface import connected_components
from .one_sided import shortest_cut


def sides(mate: np.ndarray, twisted: np.ndarray, face_count: int) -> np.ndarray:
    """(F, 2) int64, component of the copies of each triangle: column 0 is the side it shows.

    mate     (3F,) int64, see manifold
    twisted  (3F,) bool, halfedges that run in the same direction as their mates
    """
    halfedge = np.flatnonzero(mate >= 0)
    first = 2 * (halfedge // 3)
    second = 2 * (mate[halfedge] // 3) + twisted[halfedge]
    component = connected_components(
        2 * face_count, np.concatenate([first, first + 1]), np.concatenate([second, second ^ 1])
    )
    return component.reshape(-1, 2)


def find_twisted(triangles: np.ndarray, mate: np.ndarray) -> np.ndarray:
    """(3F,) bool, halfedges that run in the same direction as their mates."""
    return (mate >= 0) & (triangles.ravel()[mate] == triangles.ravel())


def cut_one_sided(points, triangles, mate) -> int:
    """Undo mates along shortest paths until no part of the surface is one-sided.

    points (V, 3), triangles (F, 3), mate (3F,): changed in place. Returns the number of edges cut.
    """
    cut = 0
    twisted = find_twisted(triangles, mate)
    while twisted.any():
        side = sides(mate, twisted, len(triangles))
        one_sided = side[:, 0] == side[:, 1]
        if not one_sided.any():
            break
        edge = shortest_cut(points, triangles, mate, twisted, int(np.argmax(one_sided)))
        mate[mate[edge]] = -1
        mate[edge] = -1
        twisted &= mate >= 0
        cut += len(edge)
    return cut


def find_turned(points: np.ndarray, triangles: np.ndarray, mate: np.ndarray) -> np.ndarray:
    """(F,) bool, the triangles to turn over so that all glued ones agree.

    points (V, 3) in a box of size 1, triangles (F, 3), mate (3F,); nothing one-sided.

    Components that agree already stay as they are. Others follow the larger part of their area,
    or, when they are closed, show their outside.
    """
    twisted = find_twisted(triangles, mate)
    if not twisted.any():
        return np.zeros(len(triangles), bool)
    side = sides(mate, twisted, len(triangles))
    turned = side[:, 0] > side[:, 1]
    component = np.unique(side.min(1), return_inverse=True)[1].ravel()
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    sign = np.where(turned, -1.0, 1.0)
    volume = np.bincount(component, sign * (normal * (a + b + c)).sum(1))
    balance = np.bincount(component, sign * area)
    is_open = np.bincount(component, (mate < 0).reshape(-1, 3).any(1)) > 0
    mixed = np.bincount(component, twisted.reshape(-1, 3).any(1)) > 0
    wrong = mixed & np.where(is_open, balance < 0, volume < 0)
    return np.where(mixed[component], turned ^ wrong[component], False)


def turn(triangles: np.ndarray, mate: np.ndarray, turned: np.ndarray):
    """The triangles with some turned over, and their mates: (F, 3), (3F,) int64."""
    if not turned.any():
        return triangles, mate
    result = np.where(turned[:, None], triangles[:, [0, 2, 1]], triangles)
    # The edges of (a, c, b) in the order of those of (a, b, c).
    halfedge = np.arange(len(mate))
    place = np.where(np.repeat(turned, 3), halfedge - 2 * (halfedge % 3) + 2, halfedge)
    moved = np.full_like(mate, -1)
    moved[place] = np.where(mate >= 0, place[mate], -1)
    return result, moved
