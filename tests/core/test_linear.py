"""Sparse matrices against dense ones, and systems whose solutions are known."""

import numpy as np
import pytest

from core.errors import Cancelled
from core.linear import SparseMatrix, solve
from tests.core.surfaces import plate


def random_triplets(size, count, seed, complex_values=False):
    rng = np.random.default_rng(seed)
    values = rng.normal(size=count)
    if complex_values:
        values = values + 1j * rng.normal(size=count)
    return rng.integers(0, size, count), rng.integers(0, size, count), values


def plate_laplacian(n, phases=False, spread=0.0, seed=0):
    """(matrix, inner vertices) of the Laplacian of a square, boundary rows eliminated.

    phases makes it a connection Laplacian of a random gauge; spread scatters the weights over so
    many decades.
    """
    surface = plate(np.ones((n, n)), 1 / n)
    rng = np.random.default_rng(seed)
    edge = surface.edges
    tail, head = surface.tail[edge], surface.head[edge]
    weight = 10.0 ** rng.uniform(-spread / 2, spread / 2, len(edge))
    gauge = np.exp(1j * rng.uniform(0, 6, surface.vertex_count)) if phases else np.ones(len(surface.points))
    size = surface.vertex_count
    across = -weight * gauge[tail] * gauge[head].conj()
    degree = np.bincount(tail, weight, size) + np.bincount(head, weight, size)
    rows = np.concatenate([tail, head, np.arange(size)])
    columns = np.concatenate([head, tail, np.arange(size)])
    values = np.concatenate([across, across.conj(), degree])
    number = np.where(surface.on_boundary, -1, np.cumsum(~surface.on_boundary) - 1)
    keep = (number[rows] >= 0) & (number[columns] >= 0)
    inner = int((number >= 0).sum())
    return SparseMatrix.from_triplets(number[rows[keep]], number[columns[keep]], values[keep], inner)


@pytest.mark.parametrize("size, count", [(1, 1), (7, 40), (60, 20), (200, 2000), (5, 0)])
@pytest.mark.parametrize("complex_values", [False, True])
def test_matrix_agrees_with_the_dense_one(size, count, complex_values):
    rows, columns, values = random_triplets(size, count, size + count, complex_values)
    matrix = SparseMatrix.from_triplets(rows, columns, values, size)
    dense = np.zeros((size, size), complex)
    np.add.at(dense, (rows, columns), values)
    assert np.allclose(matrix.dense(), dense)
    assert np.allclose(matrix.diagonal(), dense.diagonal())
    assert np.allclose(matrix.absolute_row_sum(), np.abs(dense).sum(1))
    x = np.random.default_rng(1).normal(size=(size, 3))
    assert np.allclose(matrix.dot(x), dense @ x)
    assert np.allclose(matrix.dot(x[:, 0] + 1j * x[:, 1]), dense @ (x[:, 0] + 1j * x[:, 1]))


def test_one_long_row_does_not_widen_the_others():
    size = 4000
    spokes = np.arange(1, size)
    rows = np.concatenate([np.zeros(size - 1, int), spokes, spokes])
    columns = np.concatenate([spokes, np.zeros(size - 1, int), spokes])
    matrix = SparseMatrix.from_triplets(rows, columns, np.ones(len(rows)), size)
    assert matrix._padded[0].shape[1] == 2
    x = np.random.default_rng(0).normal(size=size)
    assert np.allclose(matrix.dot(x), np.concatenate([[x[1:].sum()], x[1:] + x[0]]))


@pytest.mark.parametrize("n", [3, 12, 40, 90])
@pytest.mark.parametrize("phases", [False, True])
@pytest.mark.parametrize("spread", [0.0, 6.0])
def test_solution_is_recovered(n, phases, spread):
    matrix = plate_laplacian(n, phases, spread)
    rng = np.random.default_rng(2)
    x = rng.normal(size=matrix.size) + (1j * rng.normal(size=matrix.size) if phases else 0)
    b = matrix.dot(x)
    found = solve(matrix, b, tolerance=1e-10)
    assert np.linalg.norm(matrix.dot(found) - b) <= 1.1e-10 * np.linalg.norm(b)


def test_several_right_hand_sides_at_once():
    matrix = plate_laplacian(20)
    x = np.random.default_rng(3).normal(size=(matrix.size, 2))
    assert np.allclose(solve(matrix, matrix.dot(x), tolerance=1e-12), x, atol=1e-8)


def test_start_at_the_solution_is_returned_unchanged():
    matrix = plate_laplacian(15)
    x = np.random.default_rng(4).normal(size=matrix.size)
    assert np.array_equal(solve(matrix, matrix.dot(x), start=x), x)


def test_zero_right_hand_side_gives_zero():
    matrix = plate_laplacian(15)
    assert not solve(matrix, np.zeros(matrix.size)).any()


def test_iteration_limit_and_cancel():
    matrix = plate_laplacian(40)
    b = np.ones(matrix.size)
    rough = solve(matrix, b, iteration_limit=3)
    assert 1e-8 < np.linalg.norm(matrix.dot(rough) - b) / np.linalg.norm(b)
    with pytest.raises(Cancelled):
        solve(matrix, b, cancelled=lambda: True)


def test_empty_system():
    matrix = SparseMatrix.from_triplets([], [], np.zeros(0), 0)
    assert solve(matrix, np.zeros(0)).shape == (0,)
