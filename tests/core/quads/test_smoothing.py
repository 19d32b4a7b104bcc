"""Distorted and folded quad meshes come back valid, on the surface and on its boundary."""

import numpy as np
import pytest

from core.errors import Cancelled
from core.quads.placement import Placement
from core.quads.quality import scaled_jacobian
from core.quads.smoothing import smooth
from core.surface.boundary import build_loops
from core.surface.projection import barycentric, closest_point, surface_normal
from core.surface.surface import build_surface
from tests.core.patches import annulus, bump, flat, grid_parameters, grid_quads, octant, patch


def grid_on(shape, surface, m, n, closed=False):
    """(Placement, quads) of a quad grid of a shape; the corners are fixed, the sides are walls."""
    parameter = grid_parameters(m, n, closed)
    columns = m if closed else m + 1
    point, face = closest_point(surface, shape(parameter))
    index = np.arange(len(point)).reshape(n + 1, columns)
    wall = [index[0], index[-1]] if closed else [index[0], index[-1], index[:, 0], index[:, -1]]
    wall = np.unique(np.concatenate(wall))
    loops = build_loops(surface)
    loop = np.full(len(point), -1)
    distance = []
    for number in range(surface.loop_count):
        position = loops.closest(np.full(len(wall), number), point[wall])
        near, _ = loops.point(np.full(len(wall), number), position)
        distance.append(np.linalg.norm(near - point[wall], axis=1))
    loop[wall] = np.argmin(distance, axis=0)
    position = np.zeros(len(point))
    position[wall] = loops.closest(loop[wall], point[wall])
    point[wall], face[wall] = loops.point(loop[wall], position[wall])
    fixed = np.zeros(len(point), bool)
    if not closed:
        fixed[index[[0, 0, -1, -1], [0, -1, 0, -1]]] = True
    return Placement(point, face, loop, position, fixed), grid_quads(m, n, closed)


def scramble(surface, placement, size, seed=0):
    """Inner vertices moved by normally distributed distances and put back on the surface."""
    inner = np.flatnonzero(placement.loop < 0)
    move = np.random.default_rng(seed).normal(scale=size, size=(len(inner), 3))
    point, face = placement.point.copy(), placement.face.copy()
    point[inner], face[inner] = closest_point(surface, point[inner] + move)
    return Placement(point, face, placement.loop, placement.loop_position, placement.fixed)


def jacobian(surface, placement, quads):
    normal = surface_normal(surface, placement.face, placement.point)
    return scaled_jacobian(placement.point, quads, normal)


def assert_in_place(surface, before, after):
    """On the surface, on the boundary polyline, in order along it, fixed vertices unmoved."""
    weight = barycentric(surface, after.face, after.point)
    rebuilt = (surface.points[surface.triangles[after.face]] * weight[:, :, None]).sum(1)
    assert weight.min() > -1e-9
    assert np.abs(rebuilt - after.point).max() < 1e-9 * surface.diameter
    assert (after.loop == before.loop).all() and (after.fixed == before.fixed).all()
    assert (after.point[after.fixed] == before.point[after.fixed]).all()
    loops = build_loops(surface)
    wall = np.flatnonzero(after.loop >= 0)
    exact, _ = loops.point(after.loop[wall], after.loop_position[wall])
    assert np.abs(exact - after.point[wall]).max() < 1e-9 * surface.diameter
    for number in range(surface.loop_count):
        member = wall[after.loop[wall] == number]
        member = member[np.argsort(before.loop_position[member])]
        turned = np.diff(after.loop_position[member], append=after.loop_position[member[:1]])
        assert (turned < 0).sum() == 1  # exactly one step passes the start of the loop


CASES = {
    "square": (flat, 12, 12, False),
    "octant": (octant, 24, 24, False),
    "bump": (bump, 24, 24, False),
    "ring": (annulus, 72, 8, True),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("size", [0.3, 2.0])
def test_folded_grid_comes_back_valid(name, size):
    shape, m, n, closed = CASES[name]
    surface = patch(shape, m, n, closed=closed)
    good, quads = grid_on(shape, surface, 30, 10 if closed else 22, closed)
    edge = np.linalg.norm(good.point[quads[:, 0]] - good.point[quads[:, 1]], axis=1).mean()
    bad = scramble(surface, good, size * edge)
    result = smooth(surface, bad, quads)
    assert_in_place(surface, bad, result)
    assert jacobian(surface, bad, quads).min() < 0
    assert jacobian(surface, result, quads).min() > 0.6
    assert jacobian(surface, result, quads).mean() > 0.97


def test_square_grid_becomes_regular():
    surface = patch(flat, 6)
    good, quads = grid_on(flat, surface, 8, 8)
    result = smooth(surface, scramble(surface, good, 0.05), quads)
    assert jacobian(surface, result, quads).min() > 0.995


def test_boundary_vertices_slide_to_even_spacing():
    surface = patch(flat, 10)
    good, quads = grid_on(flat, surface, 10, 10)
    loops = build_loops(surface)
    bottom = np.flatnonzero((good.point[:, 1] == 0) & ~good.fixed)
    point, face = good.point.copy(), good.face.copy()
    goal = np.column_stack([good.point[bottom, 0] ** 3, np.zeros((len(bottom), 2))])
    position = good.loop_position.copy()
    position[bottom] = loops.closest(good.loop[bottom], goal)
    point[bottom], face[bottom] = loops.point(good.loop[bottom], position[bottom])
    bad = Placement(point, face, good.loop, position, good.fixed)
    result = smooth(surface, bad, quads)
    assert_in_place(surface, bad, result)
    assert jacobian(surface, bad, quads).min() < 0.5
    assert jacobian(surface, result, quads).min() > 0.98


def test_best_round_is_never_worse_than_the_input():
    surface = patch(octant, 10)
    good, quads = grid_on(octant, surface, 14, 14)
    before, after = (jacobian(surface, p, quads) for p in (good, smooth(surface, good, quads)))
    assert after.min() + 4 * after.mean() >= before.min() + 4 * before.mean()


def test_same_answer_twice_and_at_any_scale():
    surface = patch(bump, 16, jitter=0.2)
    good, quads = grid_on(bump, surface, 12, 12)
    bad = scramble(surface, good, 0.05)
    first, second = smooth(surface, bad, quads), smooth(surface, bad, quads)
    assert (first.point == second.point).all()
    large = build_surface(1e6 * surface.points, surface.triangles)
    grown = Placement(1e6 * bad.point, bad.face, bad.loop, 1e6 * bad.loop_position, bad.fixed)
    result = smooth(large, grown, quads)
    assert jacobian(large, result, quads).min() == pytest.approx(
        jacobian(surface, first, quads).min(), abs=0.02
    )


def test_everything_fixed_a_single_quad_and_no_quads():
    surface = patch(flat, 2)
    good, quads = grid_on(flat, surface, 1, 1)
    assert (smooth(surface, good, quads).point == good.point).all()
    none = np.zeros((0, 4), np.int64)
    assert (smooth(surface, good, none).point == good.point).all()


def test_cancel_is_heard():
    surface = patch(flat, 4)
    good, quads = grid_on(flat, surface, 6, 6)
    with pytest.raises(Cancelled):
        smooth(surface, scramble(surface, good, 0.1), quads, cancelled=lambda: True)
