"""Minimisation of functions whose minimum is known."""

import numpy as np
import pytest

from core.algebra.descent import minimise


def same(gradient):
    return gradient


def test_quadratic_with_a_wide_spectrum():
    scale = np.geomspace(1, 1e4, 40)
    goal = np.linspace(-1, 1, 40)

    def function(x):
        return 0.5 * (scale * (x - goal) ** 2).sum() + 1, scale * (x - goal)

    plain = minimise(function, np.zeros(40), 400, 0.1, 10.0, same)
    assert np.abs(plain - goal).max() < 5e-2
    helped = minimise(function, np.zeros(40), 30, 0.1, 10.0, lambda g: g / scale)
    assert np.abs(helped - goal).max() < 1e-2


def test_rosenbrock_valley():
    def function(p):
        x, y = p
        value = (1 - x) ** 2 + 100 * (y - x * x) ** 2 + 1
        return value, np.array([-2 * (1 - x) - 400 * x * (y - x * x), 200 * (y - x * x)])

    assert minimise(function, np.array([-1.2, 1.0]), 200, 0.1, 1.0, same) == pytest.approx(
        [1, 1], abs=0.05
    )


def test_every_step_goes_down_and_none_is_too_long():
    points = []

    def function(x):
        points.append(x.copy())
        return (x**4).sum(), 4 * x**3

    end = minimise(function, np.array([3.0, -2.0]), 20, 0.1, 0.25, same)
    assert (end**4).sum() < (points[0] ** 4).sum()
    steps = np.abs(np.diff(points, axis=0)).max(1)
    assert steps.max() <= 0.25 + 1e-12


def test_start_at_the_minimum_and_without_variables():
    def function(x):
        return (x * x).sum(), 2 * x

    assert (minimise(function, np.zeros(3), 5, 0.1, 1.0, same) == 0).all()
    assert minimise(function, np.zeros(0), 5, 0.1, 1.0, same).shape == (0,)
