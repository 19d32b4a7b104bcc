"""Feature edges: what counts as a crease and what does not."""

import numpy as np
import pytest

from core.features.features import (
    detect_features,
    dihedral_angle,
    marked_features,
    without_open_ends,
)
from core.surface.surface import build_surface
from tests.core import creased
from tests.core.surfaces import crumpled, disc, plate, sphere

START, FOLLOW = np.radians(40), np.radians(20)


def detect(surface, start=START, follow=FOLLOW):
    return detect_features(surface, start, follow)


def ends_of(surface, crease):
    """(n, 2, 3) end points of the feature edges."""
    edge = surface.edges[crease[surface.edges]]
    return surface.points[np.stack([surface.tail[edge], surface.head[edge]], 1)]


def test_dihedral_angles_of_a_cube_and_of_a_flat_plate():
    surface = creased.cube(3)
    angle = dihedral_angle(surface)[surface.edges]
    assert np.isclose(angle, np.pi / 2).sum() == 12 * 3
    assert np.isclose(angle, 0).sum() == len(angle) - 36
    flat = plate(np.ones((4, 4)))
    assert (dihedral_angle(flat) == 0).all()


@pytest.mark.parametrize("refine", [1, 4])
def test_the_edges_of_a_cube_are_features(refine):
    surface = creased.cube(refine)
    crease = detect(surface)
    ends = ends_of(surface, crease)
    assert len(ends) == 12 * refine
    assert (np.isclose(ends, np.rint(ends)).all(1).sum(1) >= 2).all()
    assert np.array_equal(crease, crease[surface.twin])


def test_facets_of_a_coarse_cylinder_are_not():
    surface = creased.capped_cylinder(around=14, along=3)
    assert (dihedral_angle(surface) > FOLLOW).sum() > 2 * 28
    ends = ends_of(surface, detect(surface))
    assert len(ends) == 28
    assert np.isin(ends[:, :, 2], (0, 2)).all()


def test_a_fading_crease_is_followed_to_the_lower_angle():
    surface = creased.fading_crease()
    on_line = np.isclose(surface.points[:, 1], 0.5)
    angle = np.where(on_line[surface.tail] & on_line[surface.head], dihedral_angle(surface), 0)
    for follow in (FOLLOW, np.radians(30), START):
        crease = detect(surface, START, follow)
        assert np.array_equal(crease, angle >= follow)
    assert not detect(surface, np.radians(89)).any()


def test_scans_have_no_features():
    assert not detect(crumpled(disc(12), 0.15)).any()
    assert not detect(crumpled(sphere(10), 0.1)).any()
    spike = plate(np.ones((80, 80)))
    points = spike.points.copy()
    points[spike.vertex_count // 2, 2] = 1.5
    assert not detect(build_surface(points, spike.triangles)).any()


def test_marks_count_in_either_order_and_by_the_users_numbers():
    surface = plate(np.ones((6, 6)))
    pairs = creased.edges_on(surface, lambda p: np.isclose(p[:, 0], 3))
    origin = 10 + 2 * np.arange(surface.vertex_count)
    wanted = np.isclose(ends_of(surface, surface.twin >= 0)[:, :, 0], 3).all(1)
    for given in (origin[pairs], origin[pairs][:, ::-1]):
        crease = marked_features(surface, origin, given)
        inner = surface.edges[surface.twin[surface.edges] >= 0]
        assert np.array_equal(crease[inner], wanted)
    assert not marked_features(surface, origin, pairs[:0]).any()
    assert not marked_features(surface, origin, [(0, 1), (999, 10**6)]).any()
    loop = surface.loop_halfedges
    outline = np.stack([surface.tail[loop], surface.head[loop]], 1)
    assert not marked_features(surface, origin, origin[outline]).any()


def test_pieces_with_open_ends_can_be_left_out():
    surface = creased.cube(4)
    crease = detect(surface)
    pairs = creased.edges_on(
        surface, lambda p: np.isclose(p[:, 2], 1) & np.isclose(p[:, 0], 0.5) & (p[:, 1] < 0.8)
    )
    slit = marked_features(surface, np.arange(surface.vertex_count), pairs)
    assert slit.any() and not (slit & crease).any()
    assert np.array_equal(without_open_ends(surface, crease | slit), crease)
    assert not without_open_ends(surface, slit).any()


def test_two_creases_do_not_run_into_a_cusp():
    # A ridge of two creases that converge at about 8 degrees.
    x, y = np.meshgrid(np.linspace(0, 1, 25), np.linspace(0, 1, 25), indexing="ij")
    half = np.maximum(0.07 * (1 - 1.2 * x), 0)
    height = np.where(np.abs(y - 0.5) <= half + 1e-12, 0.0, -2 * (np.abs(y - 0.5) - half))
    row = np.sign(y - 0.5) * np.maximum(np.abs(y - 0.5), half)
    number = np.arange(625).reshape(25, 25)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    triangles = np.concatenate(
        [np.stack([a, b, c], 2).reshape(-1, 3), np.stack([a, c, d], 2).reshape(-1, 3)]
    )
    surface = build_surface(np.stack([x, row, height], 2).reshape(-1, 3), triangles)
    crease = detect(surface)
    assert crease.any()
    leaving = np.flatnonzero(crease)
    direction = surface.points[surface.head[leaving]] - surface.points[surface.tail[leaving]]
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    same = surface.tail[leaving][:, None] == surface.tail[leaving]
    np.fill_diagonal(same, False)
    cosine = (direction @ direction.T)[same]
    assert (cosine < np.cos(np.radians(19))).all()
