"""Meshes cleaned in tests, with what is true of every result checked."""

import numpy as np
import pytest

from core.cleaning.cleaning import clean
from core.surface.surface import build_surface

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def cleaned(points, polygons, **settings):
    """The mesh and its surface, with what is true of every result checked."""
    points = np.array(points, float)
    mesh = clean(points, polygons, **settings)
    assert np.array_equal(mesh.points, points[mesh.vertex_origin])
    assert (np.diff(mesh.vertex_origin) >= 0).all() and (np.diff(mesh.face_origin) >= 0).all()
    assert np.array_equal(np.unique(mesh.triangles), np.arange(len(mesh.points)))
    assert np.array_equal(mesh.weld_target[mesh.vertex_origin], mesh.vertex_origin)
    for sentence in mesh.warnings:
        assert sentence.endswith(".") and "\n" not in sentence
    return mesh, build_surface(mesh.points, mesh.triangles)


def same_surface(one, other):
    """Same topology and the same shape, whatever the numbers."""
    assert one.face_count == other.face_count
    assert one.euler_characteristic == other.euler_characteristic
    assert (one.loop_count, one.component_count) == (other.loop_count, other.component_count)
    assert one.face_area.sum() == pytest.approx(other.face_area.sum())
    assert np.sort(one.edge_length) == pytest.approx(np.sort(other.edge_length))


def soup(surface):
    """The triangles of a surface with three vertices of its own for each: (points, numbers)."""
    return surface.points[surface.triangles].reshape(-1, 3), np.arange(3 * surface.face_count)
