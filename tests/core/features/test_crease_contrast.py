"""Creases stand out against what is parallel to them; cages of animals have none."""

import numpy as np
import pytest

from core.features.crease_contrast import drop_crumpled, drop_faint
from core.features.features import detect_features, dihedral_angle
from core.surface.surface import build_surface
from tests.core import creased
from tests.core.surfaces import crumpled, sphere

START, FOLLOW = np.radians(40), np.radians(20)


def chamfered_drum(around, chamfer=0.1):
    """A capped cylinder of flat facets, its two rims chamfered at exactly 45 degrees."""
    turn = 2 * np.pi * np.arange(around) / around
    rings = [(1 - chamfer, 0), (1, chamfer), (1, 2 - chamfer), (1 - chamfer, 2)]
    # Apothems, not radii: between facets and chamfers there are 45 degrees everywhere.
    points = [[r * np.cos(t), r * np.sin(t), z] for r, z in rings for t in turn]
    points += [[0, 0, 0], [0, 0, 2]]
    here, there = np.arange(around), np.roll(np.arange(around), -1)
    triangles = []
    for ring in range(3):
        a, b = ring * around + here, ring * around + there
        triangles += [np.stack([a, b, b + around], 1), np.stack([a, b + around, a + around], 1)]
    bottom, top = 4 * around, 4 * around + 1
    triangles.append(np.stack([np.full(around, bottom), there, here], 1))
    last = 3 * around
    triangles.append(np.stack([np.full(around, top), last + here, last + there], 1))
    return build_surface(np.array(points, float), np.concatenate(triangles))


@pytest.mark.parametrize("around", [12, 16, 24, 48])
def test_the_rims_of_a_chamfer_are_creases_however_coarse_the_cylinder(around):
    surface = chamfered_drum(around)
    crease = detect_features(surface, START, FOLLOW)
    edge = surface.edges[crease[surface.edges]]
    height = surface.points[:, 2]
    assert len(edge) == 4 * around
    assert np.allclose(height[surface.tail[edge]], height[surface.head[edge]])


def test_facets_across_a_crease_do_not_make_it_faint():
    surface = creased.capped_cylinder(around=12, along=1)
    angle = dihedral_angle(surface)
    rims = angle > np.radians(80)
    crease = rims.copy()
    drop_faint(surface, crease, angle)
    assert np.array_equal(crease, rims)


def test_bends_along_with_a_crease_make_it_faint():
    surface = sphere(2)
    angle = dihedral_angle(surface)
    crease = np.zeros(len(angle), bool)
    middle = np.isclose(surface.points[:, 2], 0)
    crease[middle[surface.tail] & middle[surface.head]] = True
    drop_faint(surface, crease, angle)
    assert not crease.any()


def test_where_everything_bends_both_ways_nothing_is_a_crease():
    surface = crumpled(sphere(4), 0.3)
    angle = dihedral_angle(surface)
    crease = angle > np.median(angle[surface.edges])
    drop_crumpled(surface, crease, angle)
    assert not crease.any()
    cube = creased.cube(4)
    angle = dihedral_angle(cube)
    crease = angle > START
    drop_crumpled(cube, crease, angle)
    assert crease.sum() == 2 * 12 * 4


def test_the_rim_of_a_cone_is_a_crease():
    around, turn = 32, 2 * np.pi * np.arange(32) / 32
    points = np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1)
    points = np.concatenate([points, [[0, 0, 2.0], [0, 0, 0]]])
    here, there = np.arange(around), np.roll(np.arange(around), -1)
    side = np.stack([here, there, np.full(around, around)], 1)
    base = np.stack([there, here, np.full(around, around + 1)], 1)
    surface = build_surface(points, np.concatenate([side, base]))
    crease = detect_features(surface, START, FOLLOW)
    assert crease.sum() == 2 * around
    assert (surface.points[surface.tail[crease], 2] == 0).all()
