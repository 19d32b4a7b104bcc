"""Neighbours come to agree on which side is outside."""

import numpy as np
import pytest

from tests.core.cleaned import cleaned, same_surface
from tests.core.surfaces import octant, plate_with_holes, sphere, torus


@pytest.mark.parametrize("surface", [sphere(5), torus(), octant(6), plate_with_holes()])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_mixed_orientation_is_made_one(surface, share):
    turned = np.random.default_rng(2).random(surface.face_count) < share
    faces = np.where(turned[:, None], surface.triangles[:, ::-1], surface.triangles)
    mesh, again = cleaned(surface.points, faces)
    same_surface(again, surface)
    outward = surface.loop_count == 0 or turned.sum() < 0.45 * surface.face_count
    if outward:
        assert np.array_equal(np.sort(mesh.triangles), np.sort(surface.triangles))
        assert (again.face_normal * surface.face_normal).sum(1).min() > 0.99
        assert mesh.warnings[0].startswith(f"{turned.sum():,} faces were turned over so that")


def test_a_surface_turned_inside_out_is_the_users_wish():
    surface = sphere(3)
    mesh, _ = cleaned(surface.points, surface.triangles[:, ::-1])
    assert np.array_equal(mesh.triangles, surface.triangles[:, ::-1])
