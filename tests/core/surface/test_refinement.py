"""Chords of the boundary are gone, and nothing else has changed."""

import numpy as np
import pytest

from core.surface.refinement import split_boundary_chords
from core.surface.surface import build_surface
from tests.core.surfaces import (
    annulus,
    crumpled,
    disc,
    lshape,
    octant,
    plate,
    plate_with_holes,
    sphere,
    torus,
)


def chords(surface):
    """Interior edges between two boundary vertices."""
    edge = surface.edges[surface.twin[surface.edges] >= 0]
    ends = surface.on_boundary[surface.tail[edge]] & surface.on_boundary[surface.head[edge]]
    return int(np.count_nonzero(ends))


def polygon_fan(sides):
    """Every edge inside is a chord."""
    angle = 2 * np.pi * np.arange(sides) / sides
    points = np.c_[np.cos(angle), np.sin(angle), np.zeros(sides)]
    return build_surface(points, [(0, k, k + 1) for k in range(1, sides - 1)])


def central_triangle():
    """A hexagon cut into a triangle with three chords, and three ears."""
    angle = np.pi / 3 * np.arange(6)
    points = np.c_[np.cos(angle), np.sin(angle), np.zeros(6)]
    return build_surface(points, [(0, 2, 4), (0, 1, 2), (2, 3, 4), (4, 5, 0)])


SURFACES = [
    polygon_fan(4),
    polygon_fan(9),
    central_triangle(),
    lshape(2),
    plate_with_holes(),
    annulus(12, 1),
    plate(np.ones((1, 7))),
    crumpled(octant(2), 0.3),
    octant(1),
    disc(5),
]


@pytest.mark.parametrize("surface", SURFACES)
def test_no_chord_is_left(surface):
    refined, origin = split_boundary_chords(surface)
    assert chords(refined) == 0
    assert refined.vertex_count == surface.vertex_count + chords(surface)
    assert np.array_equal(refined.points[: surface.vertex_count], surface.points)
    assert not refined.on_boundary[surface.vertex_count :].any()
    assert np.array_equal(refined.on_boundary[: surface.vertex_count], surface.on_boundary)
    assert refined.euler_characteristic == surface.euler_characteristic
    assert refined.loop_count == surface.loop_count
    assert len(origin) == refined.face_count


@pytest.mark.parametrize("surface", SURFACES)
def test_pieces_fill_their_triangles(surface):
    refined, origin = split_boundary_chords(surface)
    area = np.bincount(origin, refined.face_area, surface.face_count)
    assert area == pytest.approx(surface.face_area, rel=1e-12)
    turn = (refined.face_normal * surface.face_normal[origin]).sum(1)
    assert turn == pytest.approx(np.ones(len(turn)), abs=1e-9)
    assert (np.diff(origin) >= 0).all()


def test_central_triangle_falls_into_four():
    refined, origin = split_boundary_chords(central_triangle())
    assert np.bincount(origin).tolist() == [4, 2, 2, 2]
    assert refined.face_count == 10


def test_boundary_keeps_its_angles():
    surface = plate_with_holes()
    refined, _ = split_boundary_chords(surface)
    before = surface.angle_sum[surface.on_boundary]
    assert refined.angle_sum[refined.on_boundary] == pytest.approx(before, abs=1e-12)


@pytest.mark.parametrize("surface", [sphere(3), torus(8, 6), octant(1)])
def test_surfaces_without_chords_stay_as_they_are(surface):
    refined, origin = split_boundary_chords(surface)
    assert refined is surface
    assert np.array_equal(origin, np.arange(surface.face_count))


def test_refining_twice_changes_nothing_more():
    once, _ = split_boundary_chords(polygon_fan(7))
    again, _ = split_boundary_chords(once)
    assert again is once
