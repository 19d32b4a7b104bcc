"""The last resort: valid quads on any surface, whatever its triangles look like."""

import numpy as np
import pytest

from core.blocks.blocks import find_blocks, verify_blocks
from core.filling.midpoint import split_at_midpoints
from core.quads.quad_connectivity import connect_quads, vertex_fans
from core.settings import Settings
from core.surface.boundary import build_loops
from core.surface.surface import build_surface
from tests.core import surfaces

MAKERS = {
    "triangle": lambda: build_surface(np.eye(3), [[0, 1, 2]]),
    "disc": lambda: surfaces.disc(4),
    "ring": lambda: surfaces.annulus(20, 4),
    "sphere": lambda: surfaces.sphere(4),
    "torus": lambda: surfaces.torus(12, 8),
    "crumpled": lambda: surfaces.crumpled(surfaces.annulus(20, 4), 0.2),
    "two": lambda: surfaces.together(surfaces.disc(4), surfaces.lshape(4)),
}


def split(surface, quad_count=1, crease=None):
    none = np.zeros(len(surface.twin), bool)
    fixed = np.zeros(surface.vertex_count, bool)
    return split_at_midpoints(
        surface, none if crease is None else crease, fixed, Settings(quad_count=quad_count)
    )


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("factor", [1, 12])
def test_a_valid_quad_mesh_of_the_same_topology(name, factor):
    surface = MAKERS[name]()
    filling = split(surface, factor * surface.face_count)
    quads = filling.quads
    assert len(quads.quads) == (3 if factor == 1 else 12) * surface.face_count
    mesh = connect_quads(quads.quads, len(quads.points))
    assert np.all(vertex_fans(mesh) == 1)
    euler = len(quads.points) - mesh.edge_count + len(quads.quads)
    assert euler == surface.euler_characteristic
    assert np.array_equal(mesh.on_boundary, quads.on_boundary)
    assert quads.scaled_jacobian.min() > 0
    blocks = find_blocks(quads.quads, len(quads.points), filling.source)
    verify_blocks(blocks, quads.quads)


@pytest.mark.parametrize("name", ["disc", "ring", "two"])
def test_boundary_vertices_know_their_place_on_the_loop(name):
    surface = MAKERS[name]()
    placement = split(surface, 12 * surface.face_count).placement
    wall = placement.loop >= 0
    point, _ = build_loops(surface).point(placement.loop[wall], placement.loop_position[wall])
    assert np.allclose(point, placement.point[wall], atol=1e-9)


def test_feature_edges_stay_chains_of_edges():
    surface = surfaces.plate(np.ones((6, 6), bool), 1.0, 0.0)
    x = surface.points[:, 0]
    crease = (x[surface.tail] == 3) & (x[surface.head] == 3)
    filling = split(surface, 12 * surface.face_count, crease)
    ends = filling.quads.points[filling.quads.crease]
    assert np.allclose(ends[:, :, 0], 3)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(6)


def test_every_triangle_knows_a_quad_in_it():
    surface = surfaces.disc(4)
    filling = split(surface, 12 * surface.face_count)
    middle = filling.quads.points[filling.quads.quads[filling.face_quad]].mean(1)
    centre = surface.points[surface.triangles].mean(1)
    assert np.linalg.norm(middle - centre, axis=1).max() < surface.edge_length.max()


def test_needles_stay_convex():
    points = np.array([[0, 0, 0], [1, 0, 0], [0.3, 1e-6, 0], [0.6, -1e-7, 0]])
    surface = build_surface(points, [[0, 1, 2], [1, 0, 3]])
    assert split(surface).quads.scaled_jacobian.min() > 0
