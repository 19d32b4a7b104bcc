"""Arc lengths against exact integer programmes."""

import numpy as np
import pytest

from core.quads.length_graph import build_length_graph, impossible_arcs
from core.quads.lengths import SHORTEST_WISH, solve_lengths
from tests.core.complexes import (
    balance_matrix,
    balanced,
    cost,
    from_rectangles,
    random_gluing,
    random_rectangles,
)

optimize = pytest.importorskip("scipy.optimize")
sparse = pytest.importorskip("scipy.sparse")


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
    secants = sparse.coo_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        (top * count, 2 * count),
    )
    balance = balance_matrix(complex)
    balance = np.hstack([balance, np.zeros_like(balance)])
    result = optimize.milp(
        np.repeat([0.0, 1.0], count),
        constraints=[
            optimize.LinearConstraint(secants.tocsr(), -np.inf, np.concatenate(right)),
            optimize.LinearConstraint(balance, 0, 0),
        ],
        integrality=np.repeat([1, 0], count),
        bounds=optimize.Bounds(
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


def test_impossible_arcs_agree_with_linear_programme():
    generator = np.random.default_rng(0)
    seen = 0
    for _ in range(30):
        complex = random_gluing(generator, 6)
        matrix = balance_matrix(complex)
        count = complex.arc_count
        possible = np.array([
            -optimize.milp(-np.eye(count)[a], bounds=optimize.Bounds(0, 1),
                  constraints=optimize.LinearConstraint(matrix, 0, 0)).fun > 1e-9
            for a in range(count)
        ])
        impossible = impossible_arcs(build_length_graph(complex))
        assert np.array_equal(impossible, ~possible)
        length = solve_lengths(complex, generator.uniform(0.2, 6, count))
        assert balanced(complex, length)
        assert (length[impossible] == 0).all() and (length[~impossible] >= 1).all()
        seen += impossible.sum()
    assert seen > 10


@pytest.mark.parametrize("seed", range(4))
def test_random_gluings_near_integer_programme(seed):
    generator = np.random.default_rng(100 + seed)
    complex = random_gluing(generator, 8)
    complex_possible = ~impossible_arcs(build_length_graph(complex))
    target = generator.uniform(0.5, 6, complex.arc_count)
    length = solve_lengths(complex, target)
    best = exact(complex, target, np.where(complex_possible, 1, 0))
    assert cost(target, length) <= 1.05 * best + 1e-9
