"""Arcs that must not vanish: known ones, and what holds for any cells."""

from dataclasses import replace

import numpy as np
import pytest

from core.cells.cells import NodeKind
from core.coarsening.vanishing import KEPT_APART, arcs_to_blame
from core.errors import LayoutError
from core.surface.surface import connected_components
from tests.core.complexes import disc, from_rectangles, random_rectangles, ring


def all_free(complex):
    return np.ones(complex.arc_count, bool)


def test_the_longer_of_two_arcs_between_corners_is_to_blame():
    complex = from_rectangles([(0, 0, 2, 3), (2, 0, 8, 3)])
    size = complex.arc_length
    length = (size == 3).astype(np.int64)
    assert np.array_equal(arcs_to_blame(complex, length, all_free(complex)), np.flatnonzero(size == 6))


def test_arcs_that_may_not_be_blamed_vanish_first():
    complex = from_rectangles([(0, 0, 2, 3), (2, 0, 8, 3)])
    size = complex.arc_length
    length = (size == 3).astype(np.int64)
    assert np.array_equal(arcs_to_blame(complex, length, size != 6), np.flatnonzero(size == 2))


def test_corners_across_a_cell_without_width():
    """The corners at (2, 3) and (5, 3) face each other across the middle cell, on no vanished arc."""
    complex = from_rectangles([(0, 0, 2, 6), (2, 0, 5, 6), (5, 0, 9, 6), (2, 6, 5, 8), (2, -2, 5, 0)])
    across = (complex.arc_length == 3) & (complex.arc_loop < 0)
    assert across.sum() == 2
    outer = (complex.arc_length == 3) & (complex.arc_loop >= 0)
    length = 1 - (across | outer).astype(np.int64)
    blamed = arcs_to_blame(complex, length, all_free(complex))
    assert np.array_equal(blamed, np.flatnonzero(across | outer))


def test_the_two_walls_of_a_ring_stay_apart():
    complex = ring(3)
    across = complex.arc_loop < 0
    blamed = arcs_to_blame(complex, 1 - across.astype(np.int64), all_free(complex))
    assert np.array_equal(blamed, np.flatnonzero(across))


@pytest.mark.parametrize("valence, on_chart, kept", [
    (3, False, True), (3, True, True), (5, False, True), (5, True, False),
])
def test_singularities_keep_off_the_boundary(valence, on_chart, kept):
    complex = disc()
    singular = complex.node_kind == NodeKind.SINGULARITY
    complex = replace(complex, node_valence=np.where(singular, valence, 2))
    spoke = (complex.arc_loop < 0) & (complex.arc_node.max(1) >= 4)
    blamed = arcs_to_blame(complex, 1 - spoke.astype(np.int64), all_free(complex), on_chart)
    assert np.array_equal(blamed, np.flatnonzero(spoke) if kept else [])


@pytest.mark.parametrize("seed", range(6))
def test_what_is_left_joins_nothing_that_must_stay_apart(seed):
    complex = from_rectangles(random_rectangles(np.random.default_rng(seed), 25))
    length = np.zeros(complex.arc_count, np.int64)
    blamed = arcs_to_blame(complex, length, all_free(complex))
    left = np.setdiff1d(np.arange(complex.arc_count), blamed)
    group = connected_components(complex.node_count, *complex.arc_node[left].T)
    kept = np.isin(complex.node_kind, KEPT_APART)
    assert np.bincount(group[kept]).max() == 1
    assert kept.sum() == 4 and len(blamed)


def test_unbalanced_lengths_are_refused():
    complex = from_rectangles([(0, 0, 2, 3)])
    with pytest.raises(LayoutError, match="opposite sides"):
        arcs_to_blame(complex, np.arange(4), all_free(complex))
