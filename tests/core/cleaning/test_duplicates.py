"""Corners passed twice, spikes and repeated faces go; bridges to holes stay."""

import numpy as np
import pytest

from tests.core.cleaned import SQUARE, cleaned


def test_repeated_corners_are_removed():
    mesh, surface = cleaned(SQUARE, [[0, 1, 1, 2, 2, 2, 3, 0]])
    assert surface.face_count == 2
    assert mesh.warnings == ["1 face lost corners that it passed twice."]


def test_spikes_are_removed():
    points = [*SQUARE, (5, 5, 0), (6, 6, 0)]
    _, surface = cleaned(points, [[0, 1, 2, 4, 5, 4, 2, 3]])
    assert surface.face_area.sum() == pytest.approx(1)


def test_bridge_to_a_hole():
    """A polygon that walks to the hole in its middle, round it and back on the same bridge."""
    hole = [(1, 1, 0), (1, 2, 0), (2, 2, 0), (2, 1, 0)]
    points = [*(3 * np.array(SQUARE)), *hole]
    _, surface = cleaned(points, [[0, 1, 2, 3, 0, 4, 5, 6, 7, 4]])
    assert surface.face_area.sum() == pytest.approx(8)
    assert (surface.euler_characteristic, surface.loop_count) == (0, 2)
    assert surface.face_normal[:, 2] == pytest.approx(np.ones(surface.face_count))


@pytest.mark.parametrize("again", [[0, 1, 2], [1, 2, 0], [2, 1, 0]])
def test_repeated_faces_are_left_out(again):
    mesh, surface = cleaned(SQUARE, [[0, 1, 2], [0, 2, 3], again])
    assert mesh.face_origin.tolist() == [0, 1]
    assert mesh.warnings == ["1 repeated face was left out."]
    assert surface.component_count == 1


def test_faces_of_one_or_two_corners_are_left_out():
    mesh, _ = cleaned(SQUARE, [[0], [0, 1, 2], [], [2, 3], [0, 2, 3], [1, 1, 2]])
    assert mesh.face_origin.tolist() == [1, 4]
    assert mesh.warnings == ["4 faces with fewer than three different corners were left out."]
