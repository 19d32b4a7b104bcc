"""Arc lengths on known layouts and hostile ones; integer programmes are in another file."""

from time import process_time

import numpy as np
import pytest

from core.cells.cells import NodeKind
from core.errors import Cancelled, LayoutError
from core.quads.length_graph import (
    build_length_graph,
    cheap_walks,
    impossible_arcs,
    lengthening_walk,
)
from core.quads.lengths import count_quads, scale_to_count, solve_lengths
from tests.core.complexes import (
    balance_matrix,
    balanced,
    cost,
    disc,
    forced_zero,
    from_rectangles,
    lshape,
    random_rectangles,
    ring,
    torus,
)


def test_feasible_wishes_come_true():
    complex = from_rectangles(random_rectangles(np.random.default_rng(3), 40))
    wish = np.round(complex.arc_length)
    assert np.array_equal(solve_lengths(complex, wish), wish)


def test_rectangle_meets_in_the_middle():
    complex = from_rectangles([(0, 0, 5, 3)])
    across = np.isclose(complex.arc_length, 5)
    length = solve_lengths(complex, np.where(across, 7.2, 2.9))
    assert set(length[across]) == {7} and set(length[~across]) == {3}


def test_structurally_zero_arcs_are_found_and_left():
    complex = forced_zero()
    assert impossible_arcs(build_length_graph(complex)).tolist() == [False, True, False, False]
    assert solve_lengths(complex, np.array([3.1, 2.0, 4.0, 4.4])).tolist() == [3, 0, 4, 4]


@pytest.mark.parametrize("complex", [lshape(), disc(), ring(3), ring(1), torus(3, 2)])
def test_nothing_is_impossible_on_plain_layouts(complex):
    assert not impossible_arcs(build_length_graph(complex)).any()
    length = solve_lengths(complex, np.full(complex.arc_count, 0.01))
    assert balanced(complex, length) and set(length) == {1}


def test_fixed_nodes_joined_by_zero_are_refused():
    complex = forced_zero()
    complex.node_kind[[1, 2]] = NodeKind.SINGULARITY, NodeKind.CORNER
    with pytest.raises(LayoutError, match="stay apart"):
        solve_lengths(complex, np.full(4, 2.0))


def test_lengthening_walk_keeps_balances():
    complex = from_rectangles(random_rectangles(np.random.default_rng(7), 30))
    graph, matrix = build_length_graph(complex), balance_matrix(complex)
    for arc in range(complex.arc_count):
        change = lengthening_walk(graph, arc)
        assert (change % 2 == 0).all() and arc in change // 2
        more = np.bincount(change // 2, minlength=complex.arc_count)
        assert not (matrix @ more).any()
    with pytest.raises(LayoutError, match="zero"):
        lengthening_walk(build_length_graph(forced_zero()), 1)


def test_walks_cost_what_they_say_and_keep_balances():
    generator = np.random.default_rng(5)
    complex = torus(4, 3)
    graph, matrix = build_length_graph(complex), balance_matrix(complex)
    price = generator.normal(0.3, 1, 2 * complex.arc_count)[graph.edge_change]
    walks = cheap_walks(graph, price)
    assert len(walks) and (walks.cost < 0).all()
    for begin, end, total in zip(walks.offset[:-1], walks.offset[1:], walks.cost):
        edge = walks.edge[begin:end]
        change = graph.edge_change[edge]
        assert np.isclose(price[edge].sum(), total)
        amount = np.bincount(change // 2, 1 - 2 * (change % 2), complex.arc_count)
        assert not (matrix @ amount).any()
    assert not len(cheap_walks(graph, np.abs(price)))


def test_lower_bound_of_each_arc_and_warm_start():
    complex = from_rectangles(random_rectangles(np.random.default_rng(2), 20))
    target = complex.arc_length / 4
    lower = np.ones(complex.arc_count, np.int64)
    lower[3] = 40
    first = solve_lengths(complex, target, lower)
    assert first[3] >= 40 and balanced(complex, first)
    again = solve_lengths(complex, target, 1, start=first)
    assert np.isclose(cost(target, again), cost(target, solve_lengths(complex, target)), rtol=0.02)


@pytest.mark.parametrize("wanted", [300, 1000, 8000])
def test_wanted_number_of_quads(wanted):
    for seed in range(3):
        complex = from_rectangles(random_rectangles(np.random.default_rng(seed), 40))
        length, factor = scale_to_count(complex, complex.arc_length, wanted)
        assert balanced(complex, length) and factor > 0
        assert abs(count_quads(complex, length) / wanted - 1) < 0.10


def test_too_few_quads_give_the_coarsest_layout():
    complex = disc()
    length, _ = scale_to_count(complex, complex.arc_length, 1)
    assert set(length) == {1} and count_quads(complex, length) == 5


def test_hostile_wishes_and_cancelling():
    complex = lshape()
    with pytest.raises(LayoutError, match="finite"):
        solve_lengths(complex, np.full(complex.arc_count, np.nan))
    with pytest.raises(LayoutError, match="one for each"):
        solve_lengths(complex, np.ones(3))
    with pytest.raises(Cancelled):
        solve_lengths(complex, np.ones(complex.arc_count), cancelled=lambda: True)
    assert solve_lengths(complex, np.zeros(complex.arc_count)).min() == 1


def test_hundred_cells_in_a_third_of_a_second():
    complex = from_rectangles(random_rectangles(np.random.default_rng(1), 100))
    begin = process_time()
    solve_lengths(complex, complex.arc_length)
    assert process_time() - begin < 0.3 * 3
