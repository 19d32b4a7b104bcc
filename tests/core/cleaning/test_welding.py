"""Vertices in one place become one: loose faces, edges without length, on request."""

import numpy as np
import pytest

from core.cleaning.cleaning import clean
from core.errors import InputError
from tests.core.cleaned import SQUARE, cleaned, soup
from tests.core.surfaces import octant, plate_with_holes, sphere, torus


@pytest.mark.parametrize("surface", [sphere(4), torus(), octant(5), plate_with_holes()])
@pytest.mark.parametrize("noise", [0, 1e-8])
def test_loose_triangles_are_joined(surface, noise):
    points, number = soup(surface)
    points = points + noise * np.random.default_rng(1).uniform(-1, 1, points.shape)
    mesh, joined = cleaned(points, number.reshape(-1, 3))
    assert joined.face_count == surface.face_count
    assert joined.euler_characteristic == surface.euler_characteristic
    assert joined.loop_count == surface.loop_count
    gone = len(points) - surface.vertex_count
    (sentence,) = mesh.warnings
    assert sentence.startswith(f"{gone:,} vertices were merged into one in the same place")
    # Every vertex of the user goes to one in its place, and that one is in the mesh.
    assert np.abs(points[mesh.weld_target] - points).max() <= 4 * noise
    assert np.isin(mesh.weld_target, mesh.vertex_origin).all()


def test_loose_faces_beside_a_joined_mesh():
    whole, loose = octant(4), sphere(3)
    points, number = soup(loose)
    points = np.concatenate([whole.points + [3, 0, 0], points])
    faces = np.concatenate([whole.triangles, number.reshape(-1, 3) + whole.vertex_count])
    _, surface = cleaned(points, faces)
    assert (surface.component_count, surface.loop_count) == (2, 1)


def test_sheets_that_touch_are_not_joined_unasked():
    points = np.array([*SQUARE, *SQUARE], float)
    points[4:, 0] += 1
    points = np.concatenate([points, [(0.5, 2, 0), (1.5, 2, 0)]])
    faces = [[0, 1, 2, 3], [4, 5, 6, 7], [3, 2, 8], [7, 6, 9]]
    mesh, surface = cleaned(points, faces)
    assert surface.component_count == 2 and len(mesh.warnings) == 1
    mesh, surface = cleaned(points, faces, weld_distance=1e-3)
    assert surface.component_count == 1
    assert mesh.warnings == ["2 vertices were merged into one within the welding distance."]
    assert mesh.weld_target.tolist() == [0, 1, 2, 3, 1, 5, 6, 2, 8, 9]


def test_welding_distance_is_in_the_users_lengths():
    gap = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1.01, 0, 0), (0.01, 1, 0), (1, 1, 0)]
    faces = [[0, 1, 2], [3, 5, 4]]
    for scale in (1e-7, 1, 1e7):
        points = scale * np.array(gap) + 3 * scale
        assert cleaned(points, faces, weld_distance=0.02 * scale)[1].component_count == 1
        assert cleaned(points, faces, weld_distance=0.002 * scale)[1].component_count == 2


def test_welding_everything_is_refused():
    surface = octant(12)
    with pytest.raises(InputError, match="no area"):
        clean(surface.points, surface.triangles, weld_distance=10)


def test_edges_without_length_are_closed():
    points = [*SQUARE, (1, 0, 0), (2, 0, 0), (2, 1, 0)]
    # Vertex 4 lies on vertex 1; the two are the ends of an edge.
    mesh, surface = cleaned(points, [[0, 1, 4, 2, 3], [4, 5, 6, 2]])
    assert surface.component_count == 1 and surface.face_count == 4
    assert mesh.weld_target[4] == 1
    assert "end of an edge without length" in mesh.warnings[0]
