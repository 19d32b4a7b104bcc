"""Edges of more than two faces and vertices where parts only touch are cut apart."""

import numpy as np
import pytest

from tests.core.cleaned import cleaned


def test_edge_of_three_faces_is_cut():
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0.1), (0, 0, 1)]
    mesh, surface = cleaned(points, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    assert surface.component_count == 2 and surface.loop_count == 2
    # The pair that bends least stays together.
    assert surface.component.tolist() == [0, 0, 1]
    assert mesh.vertex_origin.tolist() == [0, 0, 1, 1, 2, 3, 4]
    assert mesh.warnings == ["The surface was cut apart along 1 edge of more than two faces."]


def box(corner):
    x, y, z = np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")
    points = np.c_[x.ravel(), y.ravel(), z.ravel()] + np.array(corner)
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    return points.astype(float), quads


def merged(parts):
    points = np.concatenate([p for p, _ in parts])
    offset = np.cumsum([0] + [len(p) for p, _ in parts])
    quads = np.concatenate([q + o for (_, q), o in zip(parts, offset)])
    points, number = np.unique(points, axis=0, return_inverse=True)
    return points, number.ravel()[quads]


@pytest.mark.parametrize("corners", [[(0, 0, 0), (1, 1, 0)], [(1, 0, 0), (0, 1, 0), (5, 5, 5)]])
def test_boxes_that_share_an_edge_become_closed_boxes(corners):
    mesh, surface = cleaned(*merged([box(c) for c in corners]))
    assert surface.component_count == len(corners) and surface.loop_count == 0
    assert surface.euler_characteristic == 2 * len(corners)
    assert mesh.warnings == ["The surface was cut apart along 1 edge of more than two faces."]
    centre = surface.points[surface.triangles].mean(1)
    for k in range(len(corners)):
        own = surface.component == k
        out = centre[own] - centre[own].mean(0)
        assert (out * surface.face_normal[own]).sum(1).min() > 0


def test_boxes_that_share_a_corner():
    mesh, surface = cleaned(*merged([box((0, 0, 0)), box((1, 1, 1))]))
    assert surface.component_count == 2 and surface.loop_count == 0
    assert mesh.warnings == ["1 vertex in which parts of the surface only touched was split."]


def test_crossing_planes_stay_planes():
    """Two planes that cross along a row of edges: each stays in one piece, and flat."""
    n = 6
    grid = np.stack(np.meshgrid(np.arange(n + 1), np.arange(-3, 4), indexing="ij"), -1)
    flat = np.c_[grid.reshape(-1, 2), np.zeros(7 * (n + 1))]
    number = np.arange(7 * (n + 1)).reshape(n + 1, 7)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], -1)
    upright = flat[:, [0, 2, 1]]
    _, surface = cleaned(*merged([(flat, quads.reshape(-1, 4)), (upright, quads.reshape(-1, 4))]))
    assert (surface.component_count, surface.loop_count) == (2, 2)
    for k in range(2):
        normal = surface.face_normal[surface.component == k]
        assert normal == pytest.approx(np.broadcast_to(normal[0], normal.shape))


@pytest.mark.parametrize("sheets", [3, 4, 5, 40])
def test_sheets_that_meet_in_a_line(sheets):
    points, quads = [(0, 0, z) for z in range(6)], []
    for k in range(sheets):
        x, y = np.cos(2 * np.pi * k / sheets), np.sin(2 * np.pi * k / sheets)
        first = len(points)
        points += [(x, y, z) for z in range(6)]
        quads += [[z, first + z, first + z + 1, z + 1] for z in range(5)]
    _, surface = cleaned(points, quads)
    assert surface.face_count == 10 * sheets
    pieces = (sheets + 1) // 2 if sheets < 30 else sheets
    assert surface.component_count == pieces == surface.loop_count
