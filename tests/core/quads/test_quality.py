"""Shape measures against quads whose angles are known."""

import numpy as np
import pytest

from core.quads.quality import aspect_ratio, scaled_jacobian, skewness

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
QUAD = np.array([[0, 1, 2, 3]])


def test_rectangle_is_perfect():
    points = SQUARE * [3, 1, 1]
    assert scaled_jacobian(points, QUAD) == pytest.approx([1])
    assert aspect_ratio(points, QUAD) == pytest.approx([3])
    assert skewness(points, QUAD) == pytest.approx([0], abs=1e-12)


@pytest.mark.parametrize("degrees", [20, 45, 60, 89])
def test_rhombus_gives_sine_of_its_angle(degrees):
    angle = np.radians(degrees)
    points = SQUARE @ np.array([[1, 0, 0], [np.cos(angle), np.sin(angle), 0], [0, 0, 1]])
    assert scaled_jacobian(points, QUAD) == pytest.approx([np.sin(angle)])
    assert skewness(points, QUAD) == pytest.approx([1 - degrees / 90])


def test_concave_corner_is_negative():
    points = SQUARE.copy()
    points[2] = [0.2, 0.2, 0]
    assert scaled_jacobian(points, QUAD)[0] < 0
    assert skewness(points, QUAD) == pytest.approx([1])


def test_fold_shows_only_against_surface_normals():
    flipped = QUAD[:, ::-1]
    normals = np.tile([0.0, 0.0, 1.0], (4, 1))
    assert scaled_jacobian(SQUARE, flipped) == pytest.approx([1])
    assert scaled_jacobian(SQUARE, flipped, normals) == pytest.approx([-1])
    assert scaled_jacobian(SQUARE, QUAD, normals) == pytest.approx([1])


def test_invariant_under_motion_scale_and_start_corner():
    generator = np.random.default_rng(0)
    points = generator.normal(size=(40, 3))
    quads = generator.permutation(40).reshape(10, 4)
    rotation = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    moved = 7e5 * points @ rotation.T + 3
    for measure in (scaled_jacobian, aspect_ratio, skewness):
        expected = measure(points, quads)
        assert measure(moved, np.roll(quads, 1, axis=1)) == pytest.approx(expected, abs=1e-9)


def test_degenerate_and_empty_input():
    points = np.zeros((4, 3))
    assert scaled_jacobian(points, QUAD) == pytest.approx([0])
    assert aspect_ratio(points, QUAD)[0] == np.inf
    for measure in (scaled_jacobian, aspect_ratio, skewness):
        assert measure(points, np.zeros((0, 4), int)).shape == (0,)
