"""Sparse matrices against dense ones, and systems whose solutions are known."""

import numpy as np
import pytest

from core.algebra.linear import SparseMatrix, jacobi, preconditioner_for, solve
from core.algebra.multigrid import Multigrid
from core.errors import Cancelled
from tests.core.surfaces import plate, torus


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
    size = surface.vertex_count
    gauge = np.exp(1j * rng.uniform(0, 6, size)) if phases else np.ones(size)
    across = -weight * gauge[tail] * gauge[head].conj()
    degree = np.bincount(tail, weight, size) + np.bincount(head, weight, size)
    rows = np.concatenate([tail, head, np.arange(size)])
    columns = np.concatenate([head, tail, np.arange(size)])
    values = np.concatenate([across, across.conj(), degree])
    number = np.where(surface.on_boundary, -1, np.cumsum(~surface.on_boundary) - 1)
    keep = (number[rows] >= 0) & (number[columns] >= 0)
    rows, columns, inner = number[rows[keep]], number[columns[keep]], int((number >= 0).sum())
    return SparseMatrix.from_triplets(rows, columns, values[keep], inner)


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


def iterations(matrix, preconditioner, tolerance=1e-6):
    count = 0

    def counted(residual):
        nonlocal count
        count += 1
        return preconditioner(residual)

    b = np.ones(matrix.size)
    x = solve(matrix, b, tolerance=tolerance, preconditioner=counted)
    assert np.linalg.norm(matrix.dot(x) - b) <= 1.01 * tolerance * np.linalg.norm(b)
    return count


@pytest.mark.parametrize("phases", [False, True])
def test_multigrid_iterations_hardly_grow_with_the_size(phases):
    coarse, fine = plate_laplacian(30, phases), plate_laplacian(120, phases)
    assert iterations(fine, Multigrid(fine)) <= iterations(coarse, Multigrid(coarse)) + 6
    assert iterations(fine, Multigrid(fine)) <= 20
    assert iterations(fine, jacobi(fine)) >= 100


@pytest.mark.parametrize("spread", [2.0, 6.0])
def test_multigrid_helps_where_weights_differ(spread):
    matrix = plate_laplacian(60, spread=spread)
    assert iterations(matrix, Multigrid(matrix)) < 0.15 * iterations(matrix, jacobi(matrix))


def test_multigrid_of_a_singular_system_with_a_solution():
    surface = torus(60, 50)
    edge, size = surface.edges, surface.vertex_count
    tail, head = surface.tail[edge], surface.head[edge]
    ends, others = np.concatenate([tail, head]), np.concatenate([head, tail])
    matrix = SparseMatrix.from_triplets(
        np.concatenate([ends, ends]), np.concatenate([ends, others]),
        np.repeat([1.0, -1.0], len(ends)), size,
    )
    x = surface.points[:, 0] - surface.points[:, 0].mean()
    found = solve(matrix, matrix.dot(x), tolerance=1e-9, preconditioner=Multigrid(matrix))
    assert np.allclose(found - found.mean(), x, atol=1e-6)


def test_a_coarsest_level_without_eigenvalues_only_costs_iterations(monkeypatch):
    def fail(_):
        raise np.linalg.LinAlgError("Eigenvalues did not converge")

    matrix = plate_laplacian(40)
    x = np.random.default_rng(2).normal(size=matrix.size)
    monkeypatch.setattr(np.linalg, "eigh", fail)
    found = solve(matrix, matrix.dot(x), tolerance=1e-9, preconditioner=Multigrid(matrix))
    assert np.allclose(found, x, atol=1e-5)


def test_disconnected_unknowns_do_not_trouble_multigrid():
    loose = SparseMatrix.from_triplets(np.arange(5000), np.arange(5000), np.arange(1, 5001), 5000)
    b = np.linspace(1, 2, 5000)
    assert np.allclose(solve(loose, b, preconditioner=Multigrid(loose)), b / np.arange(1, 5001))


def test_choice_of_preconditioner():
    assert not isinstance(preconditioner_for(plate_laplacian(20)), Multigrid)
    large = plate_laplacian(90)
    assert isinstance(preconditioner_for(large), Multigrid)
    value = large.value + np.where(large.row == large.column, 8.0, 0.0)
    dominant = SparseMatrix(large.row_offset, large.column, value)
    assert not isinstance(preconditioner_for(dominant), Multigrid)
