"""Arc lengths against exact integer programmes, known layouts and hostile ones."""

from time import process_time

import numpy as np
import pytest
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_matrix

from core.cells import NodeKind
from core.errors import Cancelled, LayoutError
from core.length_graph import (
    build_length_graph, cheap_walks, impossible_arcs, lengthening_walk,
)
from core.lengths import (
    SHORTEST_WISH, count_quads, scale_to_count, side_lengths, solve_lengths,
)
from tests.core.complexes import (
    build_complex, disc, forced_zero, from_rectangles, lshape, random_rectangles, ring, torus,
)


def balanced(complex, length):
    sides = side_lengths(complex, length)
    return bool((sides[:, :2] == sides[:, 2:]).all())


def cost(target, length):
    return float(((length - target) ** 2 / np.maximum(target, SHORTEST_WISH)).sum())


def balance_matrix(complex):
    """(2 C, A): the two balances of each cell."""
    side, arc = complex.slot_side, complex.side_halfarc // 2
    sign = np.where(side % 4 < 2, 1.0, -1.0)
    shape = (2 * complex.cell_count, complex.arc_count)
    return coo_matrix((sign, (2 * (side // 4) + side % 2, arc)), shape).tocsr()


def exact(complex, target, lower):
    """Optimal cost by an integer programme: the cost by its secants between integers."""
    count, top = len(target), int(3 * target.max() + 12)
    rows, columns, values, right = [], [], [], []
    weight = 1 / np.maximum(target, SHORTEST_WISH)
    for k in range(top):
        slope = weight * ((k + 1 - target) ** 2 - (k - target) ** 2)
        row = k * count + np.arange(count)
        rows += [row, row]
        columns += [np.arange(count), count + np.arange(count)]
        values += [slope, -np.ones(count)]
        right.append(slope * k - weight * (k - target) ** 2)
    secants = coo_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        (top * count, 2 * count),
    )
    balance = balance_matrix(complex)
    balance.resize((balance.shape[0], 2 * count))
    result = milp(
        np.repeat([0.0, 1.0], count),
        constraints=[
            LinearConstraint(secants.tocsr(), -np.inf, np.concatenate(right)),
            LinearConstraint(balance, 0, 0),
        ],
        integrality=np.repeat([1, 0], count),
        bounds=Bounds(
            np.concatenate([np.broadcast_to(lower, count), np.zeros(count)]),
            np.repeat([top, np.inf], count),
        ),
        options={"time_limit": 20, "mip_rel_gap": 1e-3},
    )
    return cost(target, np.round(result.x[:count]))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("mean", [1.0, 4.0])
def test_within_five_percent_of_integer_programme(seed, mean):
    generator = np.random.default_rng(seed)
    complex = from_rectangles(random_rectangles(generator, 24))
    target = complex.arc_length * np.exp(generator.normal(0, 0.4, complex.arc_count))
    target *= mean / target.mean()
    length = solve_lengths(complex, target)
    assert balanced(complex, length) and length.min() >= 1
    assert cost(target, length) <= 1.05 * exact(complex, target, 1) + 1e-9


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


def test_impossible_arcs_agree_with_linear_programme():
    generator = np.random.default_rng(0)
    seen = 0
    for _ in range(30):
        complex = random_gluing(generator, 6)
        matrix = balance_matrix(complex)
        count = complex.arc_count
        possible = np.array([
            -milp(-np.eye(count)[a], bounds=Bounds(0, 1),
                  constraints=LinearConstraint(matrix, 0, 0)).fun > 1e-9
            for a in range(count)
        ])
        impossible = impossible_arcs(build_length_graph(complex))
        assert np.array_equal(impossible, ~possible)
        length = solve_lengths(complex, generator.uniform(0.2, 6, count))
        assert balanced(complex, length)
        assert (length[impossible] == 0).all() and (length[~impossible] >= 1).all()
        seen += impossible.sum()
    assert seen > 10


def random_gluing(generator, cells):
    """Cells whose sides of one to three slots are glued at random: balances and nothing else."""
    sizes = generator.integers(1, 4, 4 * cells)
    slots = generator.permutation(int(sizes.sum()))
    pairs = int(len(slots) * 0.4)
    arc = np.empty(len(slots), np.int64)
    arc[slots[:pairs]] = arc[slots[pairs : 2 * pairs]] = np.arange(pairs)
    arc[slots[2 * pairs :]] = np.arange(pairs, len(slots) - pairs)
    name, seen, sides = [f"a{a}" for a in arc], set(), []
    for begin, size in zip(np.cumsum(sizes) - sizes, sizes):
        side = []
        for label in name[begin : begin + size]:
            side.append("-" + label if label in seen else label)
            seen.add(label)
        sides.append(side)
    count = len(slots) - pairs
    ends = {f"a{k}": (2 * k, 2 * k + 1) for k in range(count)}
    kind = np.full(2 * count, NodeKind.JUNCTION)
    cells = [sides[4 * k : 4 * k + 4] for k in range(cells)]
    return build_complex(ends, cells, [4] * 2 * count, kind)


@pytest.mark.parametrize("seed", range(4))
def test_random_gluings_near_integer_programme(seed):
    generator = np.random.default_rng(100 + seed)
    complex = random_gluing(generator, 8)
    complex_possible = ~impossible_arcs(build_length_graph(complex))
    target = generator.uniform(0.5, 6, complex.arc_count)
    length = solve_lengths(complex, target)
    best = exact(complex, target, np.where(complex_possible, 1, 0))
    assert cost(target, length) <= 1.05 * best + 1e-9


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
    price = generator.normal(0.3, 1, 2 * complex.arc_count)
    walks = cheap_walks(graph, price)
    assert len(walks) and (walks.cost < 0).all()
    for begin, end, total in zip(walks.offset[:-1], walks.offset[1:], walks.cost):
        change = walks.change[begin:end]
        assert np.isclose(price[change].sum(), total)
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
