"""Local search: folded quads come right, good ones are left alone."""

from dataclasses import replace

import numpy as np
import pytest

from core.errors import Cancelled
from core.quads.placement import Placement
from core.quads.quality import scaled_jacobian
from core.quads.worst_quads import GOOD_ENOUGH, mend_worst_quads
from core.surface.projection import closest_point, surface_normal
from tests.core import creased
from tests.core.surfaces import plate


def grid(surface, n, disturb, seed=0):
    """n x n quads over the unit square under the surface, inner vertices moved by edge lengths."""
    x, y = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    point = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], 1)
    inner = ((point[:, :2] > 1e-9) & (point[:, :2] < 1 - 1e-9)).all(1)
    noise = np.random.default_rng(seed).uniform(-1, 1, (inner.sum(), 2))
    point[inner, :2] += disturb / n * noise
    number = np.arange(x.size).reshape(x.shape)
    quad = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], 2)
    point, face = closest_point(surface, point)
    loop = np.where(inner, -1, 0)
    placement = Placement(point, face, loop, np.zeros(len(point)), ~inner)
    return placement, quad.reshape(-1, 4)


def worst(surface, placement, quad):
    normal = surface_normal(surface, placement.face, placement.point)
    return scaled_jacobian(placement.point, quad, normal).min()


@pytest.mark.parametrize("seed", range(3))
def test_quads_that_had_folded_over_are_good_again(seed):
    surface = plate(np.ones((16, 16)), 1 / 16)
    placement, quad = grid(surface, 6, 0.6, seed)
    assert worst(surface, placement, quad) < 0.1
    mended = mend_worst_quads(surface, placement, quad)
    assert worst(surface, mended, quad) > 0.5
    held = placement.fixed
    assert np.array_equal(mended.point[held], placement.point[held])


def test_long_and_thin_quads_come_right_along_their_edges():
    surface = plate(np.ones((16, 16)), 1 / 16)
    placement, quad = grid(surface, 6, 0.0)
    flat = placement.point * [1, 1e-2, 1] + [0, 0.5, 0]
    middle = np.flatnonzero(~placement.fixed)[12]
    flat[middle] += [0.2, 0.0, 0.0]
    point, face = closest_point(surface, flat)
    placement = replace(placement, point=point, face=face)
    assert worst(surface, placement, quad) < 0.1
    mended = mend_worst_quads(surface, placement, quad, along_edges=True, good_enough=0.3)
    assert worst(surface, mended, quad) > 0.3
    still = np.arange(len(flat)) != middle
    assert np.abs(mended.point - point)[still, 1].max() < 1e-2


def test_vertices_stay_on_a_folded_surface():
    surface = creased.roof(slope=2.0)
    placement, quad = grid(surface, 6, 0.7)
    before = worst(surface, placement, quad)
    mended = mend_worst_quads(surface, placement, quad)
    assert worst(surface, mended, quad) > max(before, 0)
    near, _ = closest_point(surface, mended.point)
    assert np.abs(near - mended.point).max() < 1e-12


def test_good_quads_are_left_alone():
    surface = plate(np.ones((8, 8)), 1 / 8)
    placement, quad = grid(surface, 5, 0.1)
    assert worst(surface, placement, quad) > GOOD_ENOUGH
    mended = mend_worst_quads(surface, placement, quad)
    assert np.array_equal(mended.point, placement.point)


def test_it_can_be_cancelled():
    surface = plate(np.ones((8, 8)), 1 / 8)
    placement, quad = grid(surface, 5, 0.9)
    with pytest.raises(Cancelled):
        mend_worst_quads(surface, placement, quad, lambda: True)
