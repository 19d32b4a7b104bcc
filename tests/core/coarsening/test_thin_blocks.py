"""Sentences about thin blocks: their places, none where all are wide."""

import numpy as np

from core.blocks.blocks import find_blocks
from core.coarsening.thin_blocks import edge_lengths, thin_blocks
from core.unit_frame import UnitFrame
from tests.core.patches import grid_quads


def _grid(columns):
    """(points, blocks) of a plane grid, each square a block; columns are where its lines are."""
    m = len(columns) - 1
    y, x = np.meshgrid([0.0, 1.0, 2.0], columns, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    return points, find_blocks(grid_quads(m, 2), len(points), np.ones(len(points), bool))


def test_edges_are_as_long_as_their_chains():
    points, blocks = _grid([0.0, 0.5, 2.0])
    chain = [points[blocks.edge_vertex[a:b]] for a, b in zip(blocks.edge_offset, blocks.edge_offset[1:])]
    expected = [np.linalg.norm(np.diff(c, axis=0), axis=1).sum() for c in chain]
    assert np.allclose(edge_lengths(points, blocks), expected)


def test_wide_blocks_need_no_sentence():
    points, blocks = _grid([0.0, 1.0, 2.0])
    assert thin_blocks(points, blocks, 1.9, "so it is") == ()


def test_the_thinnest_are_told_with_place_and_cause():
    points, blocks = _grid([0.0, 0.1, 2.0])
    (sentence,) = thin_blocks(points, blocks, 1.0, "so it is")
    told = sentence.outward(UnitFrame(np.zeros(3), 1.0))
    assert told.startswith("3 block edges are") and told.endswith(": so it is.")
    assert "0.1 between" in told and "(0.1, 2, 0)" in told


def test_one_thin_edge_is_one():
    points, blocks = _grid([0.0, 1.0, 2.0])
    points[0] += (0.8, 0.0, 0.0)
    (sentence,) = thin_blocks(points, blocks, 1.0, "so it is")
    assert sentence.text.startswith("1 block edge is")
