"""Arc length along boundary loops against a square and rings."""

import numpy as np
import pytest

from core.surface.boundary import build_loops
from core.surface.surface import build_surface
from tests.core.patches import annulus, flat, octant, patch


def test_square_loop():
    surface = patch(flat, 8)
    loops = build_loops(surface)
    assert loops.length == pytest.approx([4])
    start = surface.points[surface.tail[surface.loop_halfedges[0]]]
    point, face = loops.point(np.zeros(3, int), np.array([0.0, 4.0, -8.0]))
    assert np.abs(point - start).max() < 1e-12
    assert (surface.twin.reshape(-1, 3)[face] < 0).any(1).all()


@pytest.mark.parametrize("surface", [patch(annulus, 40, 5, closed=True), patch(octant, 12)])
def test_position_and_point_are_inverse(surface):
    loops = build_loops(surface)
    generator = np.random.default_rng(0)
    loop = generator.integers(0, surface.loop_count, 300)
    position = generator.uniform(0, 1, 300) * loops.length[loop]
    point, _ = loops.point(loop, position)
    found = loops.closest(loop, point)
    apart = np.abs(found - position)
    assert np.minimum(apart, loops.length[loop] - apart).max() < 1e-9


def test_every_loop_vertex_has_its_own_position():
    surface = patch(annulus, 30, 4, closed=True)
    loops = build_loops(surface)
    point, face = loops.point(loops.halfedge_loop, loops.position)
    tail = surface.points[surface.tail[loops.halfedge]]
    assert np.abs(point - tail).max() < 1e-12
    assert (surface.twin.reshape(-1, 3)[face] < 0).any(1).all()
    assert loops.length == pytest.approx([60 * r * np.sin(np.pi / 30) for r in (1, 2)])


def test_tangent_keeps_the_surface_on_the_left():
    surface = patch(annulus, 60, 6, closed=True)
    loops = build_loops(surface)
    position = np.linspace(0, 1, 50) * loops.length.min()
    for loop in range(2):
        which = np.full(50, loop)
        point, _ = loops.point(which, position)
        outer = np.linalg.norm(point, axis=1).mean() > 1.5
        turn = np.cross(point, loops.point_and_tangent(which, position)[2])[:, 2]
        assert (turn > 0).all() if outer else (turn < 0).all()


def test_deviation_of_chords_of_a_circle():
    surface = patch(annulus, 240, 10, closed=True)
    loops = build_loops(surface)
    outer = int(loops.length.argmax())
    loop, number = np.full(6, outer), np.arange(6)
    sixth = loops.length[outer] / 6
    found = loops.chord_deviation(loop, loops.position[loops.first[outer]] + number * sixth, sixth)
    assert found == pytest.approx(2 * (1 - np.cos(np.pi / 6)), abs=2e-3)
    square = build_loops(patch(flat, 8))
    zero = np.zeros(8, int)
    along = square.chord_deviation(zero, np.arange(8) / 2, np.full(8, 0.5))
    assert np.abs(along).max() < 1e-12
    over_corner = square.chord_deviation(zero[:1], np.array([0.5]), np.array([1.0]))
    assert over_corner == pytest.approx([np.sqrt(0.125)])


def test_wrapping_never_returns_the_length_itself():
    loops = build_loops(patch(flat, 3))
    wrapped = loops.wrap(np.zeros(3, int), np.array([-1e-20, 4.0, 12.0]))
    assert (wrapped >= 0).all() and (wrapped < loops.length[0]).all()


def test_surface_without_boundary_has_no_loops():
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    loops = build_loops(build_surface(points, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
    assert len(loops.length) == 0
    none = np.zeros(0, int)
    assert loops.point(none, np.zeros(0))[0].shape == (0, 3)
