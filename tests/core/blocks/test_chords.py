"""Chords: classes of block edges, locks, numbers of divisions."""

import numpy as np
import pytest

from core.blocks.blocks import find_blocks
from core.blocks.chords import (
    choose_counts,
    divisions,
    find_chords,
    locked_counts,
    mean_lengths,
    quad_total,
)
from core.errors import SettingsError
from tests.core.patches import grid_parameters, grid_quads


def grid_blocks(columns, rows, cuts=()):
    """Blocks of a grid of quads, cut at some columns."""
    source = np.zeros((columns + 1) * (rows + 1), bool)
    source[list(cuts)] = True
    return find_blocks(grid_quads(columns, rows), len(source), source)


def opposite(blocks):
    return blocks.block_edge[:, [0, 1]].ravel(), blocks.block_edge[:, [2, 3]].ravel()


def test_a_row_of_blocks_has_one_chord_through_it_and_one_across_each():
    blocks = grid_blocks(9, 4, cuts=(3, 5))
    chords = find_chords(blocks)
    assert blocks.count == 3 and chords.count == 4
    first, second = opposite(blocks)
    assert np.array_equal(chords.edge_chord[first], chords.edge_chord[second])
    assert sorted(np.bincount(chords.edge_chord)) == [2, 2, 2, 4]


def test_edges_alike_in_a_chord_run_from_the_same_side():
    blocks = grid_blocks(9, 4, cuts=(3, 5))
    chords = find_chords(blocks)
    points = grid_parameters(9, 4)
    start = blocks.edge_vertex[blocks.edge_offset[:-1]]
    end = blocks.edge_vertex[blocks.edge_offset[1:] - 1]
    direction = np.sign((points[end] - points[start]).sum(1))
    for chord in range(chords.count):
        member = chords.edge_chord == chord
        turned = np.where(chords.edge_turned[member], -direction[member], direction[member])
        assert np.ptp(turned) == 0


def test_a_ring_is_one_chord_round_and_one_for_each_block():
    blocks = find_blocks(grid_quads(12, 3, closed=True), 12 * 4, np.zeros(48, bool))
    chords = find_chords(blocks)
    assert blocks.count == 3 and chords.count == 4


def test_locks_go_to_chords_and_contradictions_name_both_edges():
    blocks = grid_blocks(9, 4, cuts=(3, 5))
    chords = find_chords(blocks)
    low, high = blocks.block_edge[0, 0], blocks.block_edge[0, 2]
    locked = locked_counts(chords, {int(low): 7, int(high): 7})
    assert np.count_nonzero(locked) == 1 and locked[chords.edge_chord[low]] == 7
    with pytest.raises(SettingsError, match=rf"{high} and block edge {low} .* both 7 and 8"):
        locked_counts(chords, [(low, 7), (high, 8)])
    with pytest.raises(SettingsError, match="both 7 and 8"):
        locked_counts(chords, [(low, 7), (low, 8)])
    with pytest.raises(SettingsError, match="no block edge 99"):
        locked_counts(chords, [(99, 3)])
    with pytest.raises(SettingsError, match="no block edge -1"):
        locked_counts(chords, [(-1, 3)])
    with pytest.raises(SettingsError, match="from 1 to"):
        locked_counts(chords, [(low, 0)])


@pytest.mark.parametrize("wanted", [40, 100, 1000, 4321, 100_000])
def test_the_number_of_quads_comes_within_a_tenth(wanted):
    blocks = grid_blocks(9, 4, cuts=(3, 5))
    chords = find_chords(blocks)
    present = np.zeros(chords.count)
    present[chords.edge_chord] = divisions(blocks)
    free = np.zeros(chords.count, np.int64)
    count = choose_counts(blocks, chords, present, free, 1, wanted)
    assert abs(quad_total(blocks, chords, count) / wanted - 1) <= 0.1
    locked = free.copy()
    locked[chords.edge_chord[blocks.block_edge[1, 0]]] = 5
    count = choose_counts(blocks, chords, present, locked, 1, wanted)
    assert count[locked > 0] == 5
    assert abs(quad_total(blocks, chords, count) / wanted - 1) <= 0.1


def test_counts_near_enough_are_kept_and_least_ones_kept_to():
    blocks = grid_blocks(9, 4, cuts=(3, 5))
    chords = find_chords(blocks)
    present = np.zeros(chords.count)
    present[chords.edge_chord] = divisions(blocks)
    free = np.zeros(chords.count, np.int64)
    assert np.array_equal(choose_counts(blocks, chords, present, free, 1, 38), present)
    assert choose_counts(blocks, chords, present / 100, free, 3).min() == 3


def test_mean_lengths_are_those_of_the_strip():
    blocks = grid_blocks(9, 4, cuts=(3, 5))
    chords = find_chords(blocks)
    length = divisions(blocks).astype(float)
    assert sorted(mean_lengths(blocks, chords, length)) == [2, 3, 4, 4]
