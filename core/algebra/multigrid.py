"""Aggregation multigrid: a preconditioner for conjugate gradients on large meshes.

Every level gathers the unknowns into small aggregates, a root and its strong neighbours, and solves
for one value an aggregate. The K-cycle (Notay 2008: two steps of conjugate gradients on each coarse
level) makes this plain, cheap coarsening converge at a rate that hardly depends on the size.

Within an aggregate the unknowns follow their root by the factor that the matrix entry suggests,
-a / |a|. That is 1 for Laplacians, and parallel transport for connection Laplacians.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .sparse_matrix import SparseMatrix

SMALLEST = 150  # levels of at most this size are solved directly
STRONG = 0.25  # share of the largest entry of a row that makes a neighbour strong
DAMPING = 4 / 3  # of the inverse absolute row sums; convergent below 2
ENOUGH = 0.25  # residual reduction by the first coarse step that makes the second one superfluous
# Entries that differ by less than this share are the same: the aggregates of a symmetric mesh must
# not hang on rounding.
SAME = 1e-7


@dataclass(frozen=True)
class _Level:
    """One level and its coarsening.

    matrix     SparseMatrix
    smoother   (n,) float64, damped inverse of the absolute row sums
    aggregate  (n,) int64, the coarse unknown of each unknown, ascending in `order`
    factor     (n,) real or complex of modulus 1: value of the unknown for coarse value 1
    order      (n,) int64, unknowns sorted by aggregate
    offset     (n_coarse,) int64, where each aggregate starts in `order`
    """

    matrix: SparseMatrix
    smoother: np.ndarray
    aggregate: np.ndarray
    factor: np.ndarray
    order: np.ndarray
    offset: np.ndarray

    def restrict(self, residual):
        return np.add.reduceat((self.factor.conj() * residual)[self.order], self.offset)

    def prolong(self, coarse):
        return self.factor * coarse[self.aggregate]


class Multigrid:
    """Preconditioner: call it with a residual (n,) to get an approximate solution (n,).

    matrix  real symmetric or complex Hermitian, positive (semi)definite SparseMatrix, with an
            entry on the diagonal in each row
    """

    def __init__(self, matrix: SparseMatrix):
        levels = []
        while matrix.size > SMALLEST:
            level, coarse = _coarsen(matrix)
            if coarse.size > 0.9 * matrix.size:
                break
            levels.append(level)
            matrix = coarse
        self._finish(levels, matrix)

    def _finish(self, levels, coarsest):
        self._levels, self._coarsest = levels, coarsest
        self._inverse = _pseudo_inverse(coarsest) if coarsest.size <= 10 * SMALLEST else None

    def plus_diagonal(self, shift: np.ndarray) -> Multigrid:
        """The preconditioner of matrix.plus_diagonal(shift), with the same aggregates.

        It costs a tenth of a new one.
        """
        levels = []
        for level in self._levels:
            matrix = level.matrix.plus_diagonal(shift)
            smoother = DAMPING / (DAMPING / level.smoother + shift)
            levels.append(replace(level, matrix=matrix, smoother=smoother))
            shift = np.add.reduceat(shift[level.order], level.offset)
        result = Multigrid.__new__(Multigrid)
        result._finish(levels, self._coarsest.plus_diagonal(shift))
        return result

    def __call__(self, residual: np.ndarray) -> np.ndarray:
        return self._cycle(0, residual)

    def _cycle(self, depth, residual):
        if depth == len(self._levels):
            return self._solve_coarsest(residual)
        level = self._levels[depth]
        x = level.smoother * residual
        rest = residual - level.matrix.dot(x)
        x += level.prolong(self._coarse_solution(depth + 1, level.restrict(rest)))
        x += level.smoother * (residual - level.matrix.dot(x))
        return x

    def _solve_coarsest(self, residual):
        if self._inverse is None:
            return residual / np.maximum(self._coarsest.absolute_row_sum(), 1e-300)
        return self._inverse @ residual

    def _coarse_solution(self, depth, residual):
        """At most two steps of flexible conjugate gradients."""
        first = self._cycle(depth, residual)
        if depth == len(self._levels):
            return first
        matrix = self._levels[depth].matrix
        image = matrix.dot(first)
        curvature = np.vdot(first, image).real
        if not 0 < curvature < np.inf:
            return first
        length = np.vdot(first, residual) / curvature
        rest = residual - length * image
        if np.linalg.norm(rest) <= ENOUGH * np.linalg.norm(residual):
            return length * first
        second = self._cycle(depth, rest)
        second = second - (np.vdot(image, second) / curvature) * first
        image = matrix.dot(second)
        curvature = np.vdot(second, image).real
        if not 0 < curvature < np.inf:
            return length * first
        return length * first + (np.vdot(second, rest) / curvature) * second


def _coarsen(matrix):
    """(_Level, coarse matrix) of one step."""
    aggregate, factor = _aggregates(matrix)
    coarse = _galerkin(matrix, aggregate, factor)
    order = np.argsort(aggregate, kind="stable")
    offset = np.flatnonzero(np.diff(aggregate[order], prepend=-1))
    smoother = DAMPING / np.maximum(matrix.absolute_row_sum(), 1e-300)
    return _Level(matrix, smoother, aggregate, factor, order, offset), coarse


def _galerkin(matrix, aggregate, factor):
    """The matrix of the coarse unknowns."""
    row, column = matrix.row, matrix.column
    value = factor[row].conj() * matrix.value * factor[column]
    size = int(aggregate.max()) + 1
    return SparseMatrix.from_triplets(aggregate[row], aggregate[column], value, size)


def _aggregates(matrix):
    """Aggregate and factor of each unknown.

    An unknown joins a neighbour only if the entry between them is strong in its own row: two
    unknowns that are tied firmly to others must not be tied to each other by a weak third.
    """
    row, column, value, start = _strong_entries(matrix)
    root = _roots(matrix, row, column, start)
    strength = np.abs(value)
    strength[~root[column]] = 0.0
    strength[row == column] = np.where(root, np.inf, 0.0)
    chosen = _first_largest(strength, row, start)
    entry = value[chosen]
    factor = -entry / np.maximum(np.abs(entry), 1e-300)
    factor[root] = 1.0
    return (np.cumsum(root) - 1)[column[chosen]], factor


def _strong_entries(matrix):
    """Rows, columns, values and row starts of the strong entries and the diagonal."""
    row, column = matrix.row, matrix.column
    size = np.where(row == column, 0.0, np.abs(matrix.value))
    largest = np.maximum.reduceat(size, matrix.row_offset[:-1])
    keep = np.flatnonzero((row == column) | (size > 0) & (size >= (1 - SAME) * STRONG * largest[row]))
    start = np.searchsorted(row[keep], np.arange(matrix.size))
    return row[keep], column[keep], matrix.value[keep], start


def _first_largest(strength, row, start):
    """(n,) int64, the first of the largest entries of each row."""
    largest = np.flatnonzero(strength >= (1 - SAME) * np.maximum.reduceat(strength, start)[row])
    return largest[np.flatnonzero(np.diff(row[largest], prepend=-1))]


def _roots(matrix, row, column, start):
    """(n,) bool, unknowns such that every other one has a strong entry towards one of them.

    Luby's algorithm with fixed priorities: all undecided unknowns that come first among their
    undecided neighbours join at once. Strongly tied unknowns come first, then chance decides.
    """
    size = matrix.size
    shuffled = np.random.default_rng(0).permutation(size)
    tie = np.frexp((1 + SAME) * matrix.absolute_row_sum())[1].astype(np.int64)
    priority = (tie - tie.min()) // 2 * size + shuffled + 1
    root = np.zeros(size, bool)
    while priority.any():
        first = np.maximum.reduceat(priority[column], start)
        np.maximum.at(first, column, priority[row])
        root |= (priority > 0) & (first == priority)
        priority[np.maximum.reduceat(root[column], start)] = 0
    return root


def _pseudo_inverse(matrix):
    """Dense inverse; what is singular to rounding stays out of it. None where there is none."""
    if not matrix.size:
        return np.zeros((0, 0))
    dense = matrix.dense()
    scale = 1.0 / np.sqrt(np.maximum(dense.diagonal().real, 1e-300))
    try:
        eigenvalue, vector = np.linalg.eigh(scale[:, None] * dense * scale)
    except np.linalg.LinAlgError:
        return None
    kept = eigenvalue > 1e-13 * max(eigenvalue[-1], 0.0)
    inverse = np.where(kept, 1.0 / np.where(kept, eigenvalue, 1.0), 0.0)
    vector = scale[:, None] * vector
    return (vector * inverse) @ vector.conj().T
