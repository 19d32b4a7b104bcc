"""The distortion energy: value at perfect quads, gradient against finite differences."""

import numpy as np
import pytest

from core.quads.quad_energy import QuadEnergy, wanted_lengths
from tests.core.patches import flat, grid_parameters, grid_quads


def energy_of(points, quads, share=0.5, power=2):
    normal = np.tile([0.0, 0.0, 1.0], (len(quads), 1))
    return QuadEnergy(quads, normal, wanted_lengths(points, quads, 0.1, share), power)


@pytest.mark.parametrize("power", [2, 6])
def test_rectangles_of_the_wanted_size_cost_one_a_corner(power):
    points, quads = flat(grid_parameters(5, 3)), grid_quads(5, 3)
    value, gradient = energy_of(points, quads, share=0.0, power=power)(points, 1e-9)
    assert value == pytest.approx(4 * len(quads))
    assert np.abs(gradient).max() < 1e-9


@pytest.mark.parametrize("power", [2, 6])
@pytest.mark.parametrize("size", [0.02, 0.3])
def test_gradient_is_the_derivative(power, size):
    generator = np.random.default_rng(1)
    quads = grid_quads(4, 4)
    points = flat(grid_parameters(4, 4)) + generator.normal(scale=size, size=(25, 3))
    normal = generator.normal(size=(16, 3)) * 0.2 + [0, 0, 1]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    energy = QuadEnergy(quads, normal, generator.uniform(0.2, 0.4, (16, 2)), power)
    move = generator.normal(size=points.shape)
    step = 1e-6
    ahead, behind = (energy(points + s * step * move, 0.5)[0] for s in (1, -1))
    slope = (energy(points, 0.5)[1] * move).sum()
    assert (ahead - behind) / (2 * step) == pytest.approx(slope, rel=1e-5)


def test_many_quads_cost_what_each_of_them_costs():
    points, quads = flat(grid_parameters(60, 40)), grid_quads(60, 40)
    points = points + np.random.default_rng(2).normal(scale=2e-3, size=points.shape)
    value, gradient = energy_of(points, quads)(points, 0.1)
    half = [energy_of(points, some)(points, 0.1) for some in (quads[:1234], quads[1234:])]
    assert value == pytest.approx(half[0][0] + half[1][0])
    assert np.allclose(gradient, half[0][1] + half[1][1])
    whole = energy_of(points, quads).worst_corner(points)
    assert whole == min(energy_of(points, quads[k:][:7]).worst_corner(points) for k in range(0, 2400, 7))


def test_inverted_corner_is_seen_and_costs_more():
    points, quads = flat(grid_parameters(3, 3)), grid_quads(3, 3)
    energy = energy_of(points, quads)
    assert energy.worst_corner(points) > 0
    folded = points.copy()
    folded[5] = [-0.2, -0.3, 0]
    assert energy.worst_corner(folded) < 0
    assert energy(folded, 0.1)[0] > 10 * energy(points, 0.1)[0]
    assert np.isfinite(energy(folded * 1e3, 1e-3)[0])


def test_wanted_lengths_mix_present_and_wanted():
    points, quads = flat(grid_parameters(4, 2)), grid_quads(4, 2)
    assert np.allclose(wanted_lengths(points, quads, 1.0, 0.0), [0.25, 0.5])
    assert np.allclose(wanted_lengths(points, quads, 1.0, 1.0), 1.0)
    assert np.allclose(wanted_lengths(points, quads, 1.0, 0.5), np.sqrt([0.25, 0.5]))
