"""Flips keep the mesh a surface, and values move along with the edges."""

import numpy as np
import pytest

from core.surface.flips import flip, flip_values, independent_flips
from core.surface.surface import build_surface
from tests.core.surfaces import lshape, octant, sphere, torus


@pytest.mark.parametrize("surface", [octant(6), torus(), lshape(3), sphere(1)])
def test_many_flips_at_once(surface):
    inner = np.flatnonzero(surface.twin > np.arange(len(surface.twin)))
    chosen = independent_flips(surface.triangles, inner, surface.twin)
    faces = np.concatenate([chosen // 3, surface.twin[chosen] // 3])
    assert len(np.unique(faces)) == len(faces)
    triangles, tail = surface.triangles.copy(), surface.tail.copy()
    head = surface.head.copy()
    flip(triangles, chosen, surface.twin[chosen])
    for value in (tail, head):
        flip_values(value, chosen, surface.twin[chosen], -1)
    again = build_surface(surface.points, triangles)
    assert again.euler_characteristic == surface.euler_characteristic
    assert again.loop_count == surface.loop_count
    moved = tail >= 0
    assert np.count_nonzero(~moved) == 2 * len(chosen)
    assert np.array_equal(again.tail[moved], tail[moved])
    assert np.array_equal(again.head[moved], head[moved])
    assert len(chosen) > 0 or surface.face_count < 10


def test_no_second_edge_with_the_same_ends():
    """No edge of a tetrahedron can be flipped: the other diagonal is there."""
    points = np.concatenate([np.eye(3), [[0, 0, 0]]])
    surface = build_surface(points, [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)])
    assert len(independent_flips(surface.triangles, np.arange(12), surface.twin)) == 0
