"""Faces without area go, and what they joined stays joined."""

import pytest

from core.cleaning.cleaning import clean
from core.errors import InputError
from tests.core.cleaned import cleaned


@pytest.mark.parametrize(
    "points, polygon",
    [
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [0, 1, 2]),
        ([(0, 0, 0), (0, 0, 0), (1, 0, 0)], [0, 1, 2]),
        ([(1, 1, 1)] * 3, [0, 1, 2]),
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)], [0, 1, 2, 3]),
    ],
)
def test_faces_without_area_are_left_out(points, polygon):
    good = [(5, 0, 0), (6, 0, 0), (5, 1, 0)]
    mesh, _ = cleaned(good + points, [[0, 1, 2], [v + 3 for v in polygon]])
    assert mesh.face_origin.tolist() == [0]
    with pytest.raises(InputError, match="no area"):
        clean(points, [polygon])


def test_flat_face_between_others_leaves_no_slit():
    """A corner in the middle of a neighbour's edge, with a flat triangle to fill the crack."""
    points = [(0, 0, 0), (2, 0, 0), (1, -1, 0), (1, 0, 0), (1, 1, 0)]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 4], [3, 1, 4]]
    mesh, surface = cleaned(points, faces)
    assert (surface.component_count, surface.loop_count) == (1, 1)
    assert surface.face_area.sum() == pytest.approx(2)
    assert mesh.face_origin.tolist() == [0, 0, 2, 3]
    assert mesh.warnings == ["1 face without area was left out."]


def test_row_of_flat_faces_between_others():
    k = 7
    line = [(x / k, 0, 0) for x in range(k + 1)]
    points = [*line, (0.5, 1, 0), (0.5, -1, 0)]
    upper = [[x, x + 1, k + 1] for x in range(k)]
    flat = [[0, x + 1, x] for x in range(1, k)]
    _, surface = cleaned(points, [*upper, *flat, [0, k + 2, k]])
    assert (surface.component_count, surface.loop_count) == (1, 1)
    assert surface.face_area.sum() == pytest.approx(1)
