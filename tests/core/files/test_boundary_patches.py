"""Which boundary loops a material lies along."""

import numpy as np

from core.files.boundary_patches import loops_of_material
from tests.core import surfaces


def test_the_loops_of_an_annulus_by_their_materials():
    surface = surfaces.annulus(24, 6)
    middle = surface.points[surface.triangles].mean(1)
    radius = np.linalg.norm(middle, axis=1)
    split = radius > np.median(radius)
    faces = np.arange(surface.face_count)
    outer = loops_of_material(surface, faces, split.astype(int), 1)
    inner = loops_of_material(surface, faces, split.astype(int), 0)
    assert len(outer) == len(inner) == 1 and {*outer, *inner} == {0, 1}
    first = surface.loop_halfedges[surface.loop_offset[outer[0]]]
    assert np.linalg.norm(surface.points[surface.tail[first]]) > np.median(radius)
    assert loops_of_material(surface, faces, split.astype(int), 2) == ()


def test_a_material_along_less_than_half_of_a_loop_is_not_its_own():
    surface = surfaces.disc(6)
    middle = surface.points[surface.triangles].mean(1)
    angle = np.arctan2(middle[:, 1], middle[:, 0])
    material = (angle > 0.8).astype(int)
    faces = np.arange(surface.face_count)
    assert loops_of_material(surface, faces, material, 0) == (0,)
    assert loops_of_material(surface, faces, material, 1) == ()
