"""Triangles without area: merged into their neighbours, or left out where they have none.

A flat triangle with a corner in the middle of its longest edge only says that this corner lies on
the edge of the neighbour beyond. Flipping the edge says the same without it.
"""

from __future__ import annotations

import numpy as np

from ..surface.flips import flip, independent_flips
from ..surface.surface import match_twins
from .manifold import crowded_halfedges

_FLAT = 1e-10  # height of a triangle over its longest edge that counts as no height
_ROUNDS = 100


def find_flat_triangles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Triangles (n,) without area to working precision; points within a box of size 1."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    doubled_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.max([((q - p) ** 2).sum(1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    return np.flatnonzero(doubled_area <= _FLAT * longest)


def sound_triangles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Triangles (n,) that are left without the flat ones at edges of more than two triangles."""
    left = np.arange(len(triangles))
    while True:
        flat = find_flat_triangles(points, triangles[left])
        if not len(flat):
            return left
        crowded = crowded_halfedges(triangles[left], len(points)).reshape(-1, 3)
        wrong = flat[crowded[flat].any(1)]
        if not len(wrong):
            return left
        left = np.delete(left, wrong)


def without_flat_triangles(points, triangles, polygon):
    """Flip flat triangles away; those that cannot be flipped are left out.

    points (V, 3) in a box of size 1; triangles (F, 3) oriented, each directed edge once;
    polygon (F,). Returns triangles (F', 3) and the polygon (F',) that each is a piece of.
    """
    for _ in range(_ROUNDS):
        flat = find_flat_triangles(points, triangles)
        if not len(flat):
            return triangles, polygon
        twin = match_twins(triangles.ravel(), triangles[:, [1, 2, 0]].ravel(), len(points))
        corner = points[triangles[flat]]
        length = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
        longest = 3 * flat + np.argmax(length, axis=1)
        alone = flat[twin[longest] < 0]
        if len(alone):
            triangles, polygon = np.delete(triangles, alone, 0), np.delete(polygon, alone)
            continue
        longest = independent_flips(triangles, longest, twin)
        if not len(longest):
            break
        triangles, polygon = triangles.copy(), polygon.copy()
        flip(triangles, longest, twin[longest])
        polygon[longest // 3] = polygon[twin[longest] // 3]
    flat = find_flat_triangles(points, triangles)
    return np.delete(triangles, flat, 0), np.delete(polygon, flat)
