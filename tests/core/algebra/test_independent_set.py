"""Independent sets of small graphs, against all subsets."""

from itertools import combinations

import numpy as np
import pytest

from core.algebra.independent_set import independent_set


def best(count, pairs):
    for size in range(count, -1, -1):
        for subset in combinations(range(count), size):
            if not any(set(pair) <= set(subset) for pair in pairs.tolist()):
                return size
    return 0


@pytest.mark.parametrize("seed", range(20))
def test_no_pair_and_as_many_as_there_can_be(seed):
    generator = np.random.default_rng(seed)
    pairs = generator.integers(0, 10, (int(generator.integers(0, 25)), 2))
    chosen = independent_set(np.ones(10, bool), pairs, np.zeros(10))
    assert not chosen[pairs].all(1).any()
    assert chosen.sum() == best(10, pairs)


def test_an_exchange_finds_what_the_first_choice_misses():
    # Fewest opponents first: 0, which leaves two of 2, 4 and 5; only 0 keeps out 1 and 3.
    pairs = np.array([[0, 1], [0, 3], [1, 4], [2, 4], [2, 5], [3, 4], [3, 5], [4, 5]])
    chosen = independent_set(np.ones(6, bool), pairs, np.arange(6.0))
    assert np.flatnonzero(chosen).tolist() == [1, 2, 3]


@pytest.mark.parametrize("seed", range(4))
def test_lines_of_two_directions(seed):
    """Rows and columns of a grid with some squares marked: Koenig's theorem on the marks."""
    marks = np.random.default_rng(seed).random((30, 40)) < 0.06
    pairs = np.argwhere(marks) + [0, 30]
    chosen = independent_set(np.ones(70, bool), pairs, np.zeros(70))
    assert not chosen[pairs].all(1).any()
    # The others cover all marks; marks that share no row and no column are as many.
    apart, rows, columns = 0, set(), set()
    for row, column in _matching(marks):
        assert marks[row, column] and row not in rows and column not in columns
        rows.add(row)
        columns.add(column)
        apart += 1
    assert (~chosen).sum() == apart


def _matching(marks):
    """Pairs of rows and columns, as many as there can be, by augmenting paths."""
    partner = {}

    def augment(row, seen):
        for column in np.flatnonzero(marks[row]).tolist():
            if column not in seen:
                seen.add(column)
                if column not in partner or augment(partner[column], seen):
                    partner[column] = row
                    return True
        return False

    for row in range(len(marks)):
        augment(row, set())
    return [(row, column) for column, row in partner.items()]


def test_preference_decides_between_equals():
    pairs = np.array([[0, 1]])
    for preference in ([0.0, 1.0], [1.0, 0.0]):
        chosen = independent_set(np.ones(2, bool), pairs, np.array(preference))
        assert chosen.tolist() == [preference[0] == 0, preference[1] == 0]


def test_elements_not_wanted_or_at_odds_with_themselves_stay_out():
    wanted = np.array([True, False, True, True])
    chosen = independent_set(wanted, np.array([[2, 2], [0, 1]]), np.zeros(4))
    assert chosen.tolist() == [True, False, False, True]
    none = np.zeros((0, 2), np.int64)
    assert independent_set(wanted, none, np.zeros(4)).tolist() == wanted.tolist()
    assert len(independent_set(np.zeros(0, bool), none, np.zeros(0))) == 0
