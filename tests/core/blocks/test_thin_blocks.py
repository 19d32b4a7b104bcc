"""Sentences about thin blocks: their places, what keeps them, none where all are wide."""

import numpy as np
import pytest

from core.blocks.blocks import find_blocks
from core.blocks.thin_blocks import (
    edge_lengths,
    find_thin_rows,
    thin_as_traced,
    thin_rows_told,
)
from core.quads.quad_mesh import QuadMesh
from core.unit_frame import UnitFrame
from tests.core.patches import grid_quads


def _grid(columns, rows=(0.0, 1.0, 2.0), crease=()):
    """(QuadMesh, blocks) of a plane grid, each square a block, its lines at these places."""
    m, n = len(columns) - 1, len(rows) - 1
    y, x = np.meshgrid(rows, columns, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    quads = grid_quads(m, n)
    valence = np.bincount(quads.ravel(), minlength=len(points))
    crease = np.array(crease, np.int64).reshape(-1, 2)
    mesh = QuadMesh(points, quads, valence < 4, valence, np.ones(len(quads)), crease)
    return mesh, find_blocks(quads, len(points), np.ones(len(points), bool), crease)


def _told(sentences):
    (sentence,) = sentences
    return sentence.outward(UnitFrame(np.zeros(3), 1.0))


def _rows(mesh, blocks, size=1.0, fixed=()):
    return thin_rows_told(mesh, np.isin(np.arange(len(mesh.points)), fixed), blocks, size)


def test_edges_are_as_long_as_their_chains():
    mesh, blocks = _grid([0.0, 0.5, 2.0])
    offset, points = blocks.edge_offset, mesh.points
    chain = [points[blocks.edge_vertex[a:b]] for a, b in zip(offset, offset[1:])]
    expected = [np.linalg.norm(np.diff(c, axis=0), axis=1).sum() for c in chain]
    assert np.allclose(edge_lengths(points, blocks), expected)


def test_wide_blocks_need_no_sentence():
    mesh, blocks = _grid([0.0, 1.0, 2.0])
    assert thin_as_traced(mesh, blocks, 1.9) == () and _rows(mesh, blocks, 1.9) == ()


def test_the_thinnest_as_traced_are_told_with_their_places():
    told = _told(thin_as_traced(*_grid([0.0, 0.1, 2.0]), 1.0))
    assert told.startswith("3 block edges are") and told.endswith("as traced.")
    assert "0.1 between" in told and "(0.1, 2, 0)" in told


def test_one_thin_edge_is_one():
    mesh, blocks = _grid([0.0, 1.0, 2.0])
    mesh.points[0] += (0.8, 0.0, 0.0)
    assert _told(thin_as_traced(mesh, blocks, 1.0)).startswith("1 block edge is")


def test_a_row_between_a_corner_and_a_kink():
    """The lower side of the thin row lies between them, its upper one could be taken out."""
    told = _told(_rows(*_grid([0.0, 0.1, 2.0]), fixed=[1]))
    assert told.startswith("3 block edges are")
    assert told.endswith("apart: the corner at (0, 0, 0) and the corner at (0.1, 0, 0), 0.1 apart.")


def test_a_row_between_a_singularity_and_the_boundary():
    mesh, blocks = _grid([0.0, 0.1, 2.0])
    mesh.valence[4] = 5
    told = _told(_rows(mesh, blocks))
    assert "the singularity of valence 5 at (0.1, 1, 0) and the boundary at (0, 1, 0)" in told


def test_a_row_between_a_crease_and_the_boundary():
    told = _told(_rows(*_grid([0.0, 0.1, 2.0], crease=[(1, 4), (4, 7)])))
    assert "the boundary at (0, 1, 0) and the crease at (0.1, 1, 0), 0.1 apart" in told


def test_a_row_that_nothing_keeps_is_told_as_such():
    told = _told(_rows(*_grid([0.0, 1.0, 1.1, 2.0])))
    assert "apart: (1, " in told and "for the shapes" in told


@pytest.mark.parametrize("count", [3, 30])
def test_every_row_is_told_once_up_to_twelve(count):
    columns = np.arange(count + 1) * 0.1
    mesh, blocks = _grid(columns, rows=(0.0, 1.0, 2.0, 3.0))
    told = _told(_rows(mesh, blocks, fixed=np.arange(count + 1)))
    assert told.startswith(f"{4 * count} block edges are")
    assert told.count(" apart, ") + told.count(" apart;") + told.count(" apart.") == min(count, 12)


def test_rows_know_their_edges_and_the_two_vertices_that_keep_them():
    mesh, blocks = _grid([0.0, 0.1, 2.0, 2.3])
    fixed = np.isin(np.arange(len(mesh.points)), [1, 2, 11])
    thin, wide = find_thin_rows(mesh, fixed, blocks, 1.0)
    assert thin.ends.tolist() == [0, 1] and thin.names == ("corner", "corner")
    assert wide.ends.tolist() == [2, 3] and wide.gap == pytest.approx(0.3)
    length = edge_lengths(mesh.points, blocks)
    assert np.allclose(length[thin.edges], 0.1) and np.allclose(length[wide.edges], 0.3)
    assert len(thin.edges) == len(wide.edges) == 3
    assert find_thin_rows(mesh, fixed, blocks, 0.1) == []
