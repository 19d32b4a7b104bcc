"""Spacing along graded lines: first heights, growth, regular spacing."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.divisions.grading import cells_needed, graded_positions


def cells(length, count, low, high, ratio):
    return np.diff(graded_positions([length], count, [low], [high], ratio)[0])


def test_cells_grow_from_the_first_height_to_the_regular_length():
    (count,) = cells_needed([2.0], [1e-4], [np.inf], 1.2, [0.05])
    cell = cells(2.0, int(count), 1e-4, np.inf, 1.2)
    assert cell[0] == pytest.approx(1e-4, rel=1e-9)
    growing = cell[:-1] < cell.max() * (1 - 1e-9)
    ratio = cell[1:] / cell[:-1]
    assert np.allclose(ratio[growing][:-1], 1.2, rtol=1e-9)
    assert ratio.max() <= 1.2 * (1 + 1e-9) and cell.max() <= 0.05 and cell.sum() == pytest.approx(2)


def test_the_fewest_cells_are_found():
    length = np.array([0.3, 1.0, 5.0])
    count = cells_needed(length, 1e-3, 1e-2, 1.3, 0.1)
    for size, enough in zip(length, count):
        assert np.diff(graded_positions([size], int(enough), [1e-3], [1e-2], 1.3)).max() <= 0.1
        fewer = cells(size, int(enough) - 1, 1e-3, 1e-2, 1.3)
        assert fewer.max() > 0.1 or (fewer[1:] / fewer[:-1]).max() > 1.3


def test_lines_without_first_heights_are_regular():
    assert np.allclose(cells(1.0, 7, np.inf, np.inf, 1.2), 1 / 7, rtol=1e-12)
    assert np.array_equal(cells_needed([1.0], [np.inf], [np.inf], 1.2, [0.1]), [10])


def test_too_few_cells_grow_faster_and_too_many_shrink():
    few = cells(1.0, 5, 1e-3, np.inf, 1.2)
    assert few[0] == pytest.approx(1e-3) and few[1] / few[0] > 1.2
    many = cells(1.0, 9, 0.2, np.inf, 1.2)
    assert many[0] == pytest.approx(0.2)
    assert np.allclose(many[1:] / many[:-1], many[1] / many[0]) and many[1] < many[0]
    between = cells(1.0, 12, 0.15, 0.15, 1.2)
    assert between[[0, -1]] == pytest.approx(0.15) and between.argmin() in (5, 6)


def test_far_too_many_cells_are_scaled_down_and_none_vanishes():
    cell = cells(1.0, 40, 0.9, np.inf, 1.2)
    assert cell[0] < 0.9 and cell.min() > 0.09 * cell[0]


@given(
    st.floats(1e-3, 1e3), st.integers(1, 60), st.floats(1e-6, 1.0),
    st.one_of(st.just(np.inf), st.floats(1e-6, 1.0)), st.floats(1.01, 3.0),
)
def test_positions_rise_from_end_to_end(length, count, low, high, ratio):
    position = graded_positions([length], count, [low * length], [high * length], ratio)[0]
    assert position[0] == 0 and position[-1] == pytest.approx(length, rel=1e-12)
    assert (np.diff(position) > 0).all()
    turned = graded_positions([length], count, [high * length], [low * length], ratio)[0]
    assert np.allclose(turned, length - position[::-1], atol=1e-6 * length)
