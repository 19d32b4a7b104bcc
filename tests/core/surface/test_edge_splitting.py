"""Pieces of triangles: conforming, filling, and told which halfedge they lie on."""

import numpy as np
import pytest

from core.surface.edge_splitting import cut_triangles
from core.surface.surface import build_surface
from tests.core.surfaces import crumpled, octant, plate_with_holes, torus


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("surface", [crumpled(octant(5), 0.2), torus(), plate_with_holes()])
def test_any_choice_of_edges(surface, share):
    edge = surface.edges[np.random.default_rng(3).random(len(surface.edges)) < share]
    middle = np.full(len(surface.twin), -1)
    middle[edge] = surface.vertex_count + np.arange(len(edge))
    inner = edge[surface.twin[edge] >= 0]
    middle[surface.twin[inner]] = middle[inner]
    added = 0.5 * (surface.points[surface.tail[edge]] + surface.points[surface.head[edge]])
    points = np.concatenate([surface.points, added])
    pieces = cut_triangles(points, surface.triangles, middle)
    finer = build_surface(points, pieces.triangles)
    assert finer.euler_characteristic == surface.euler_characteristic
    assert finer.loop_count == surface.loop_count
    area = np.bincount(pieces.face_origin, finer.face_area)
    assert area == pytest.approx(surface.face_area)
    assert (np.diff(pieces.face_origin) >= 0).all()
    source = pieces.halfedge_origin
    length = np.bincount(source[source >= 0], finer.edge_length[source >= 0])
    assert length == pytest.approx(surface.edge_length)
    assert np.array_equal(
        source[source >= 0] // 3, pieces.face_origin[np.flatnonzero(source >= 0) // 3]
    )
    # A halfedge inside a triangle has its twin in the same triangle.
    within = np.flatnonzero(source < 0)
    assert np.array_equal(
        pieces.face_origin[within // 3], pieces.face_origin[finer.twin[within] // 3]
    )
