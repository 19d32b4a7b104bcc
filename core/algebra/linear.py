"""Linear systems: preconditioned conjugate gradients for symmetric positive definite matrices."""

from __future__ import annotations

import numpy as np

from ..errors import Cancelled
from .multigrid import Multigrid
from .sparse_matrix import SparseMatrix

__all__ = ["SparseMatrix", "jacobi", "preconditioner_for", "solve"]

# Multigrid pays above this size, unless the diagonal dominates so much that Jacobi is good enough.
LARGE = 6000
DOMINATED = 0.97


def solve(
    matrix: SparseMatrix,
    right_hand_side: np.ndarray,
    start: np.ndarray | None = None,
    tolerance: float = 1e-8,
    iteration_limit: int = 2000,
    cancelled=None,
    preconditioner=None,
) -> np.ndarray:
    """Solve matrix x = right_hand_side by conjugate gradients.

    matrix           real symmetric or complex Hermitian, positive definite; semidefinite if the
                     right-hand side lies in its range
    right_hand_side  (n,) or (n, k), real or complex; columns are solved one after the other
    start            first guess, shape of the right-hand side; zero if None
    tolerance        stop when |residual| <= tolerance |right_hand_side|
    iteration_limit  stop after so many steps for each column, with the x reached by then
    cancelled        callable, asked before each step
    preconditioner   callable that maps a residual (n,) to an approximate solution; None makes one

    Returns x, shape of the right-hand side. Raises Cancelled.
    """
    right_hand_side = np.asarray(right_hand_side)
    kind = np.result_type(matrix.value, right_hand_side, np.float64)
    if preconditioner is None:
        preconditioner = preconditioner_for(matrix)
    columns = np.atleast_2d(right_hand_side.T).astype(kind)
    if start is None:
        guesses = np.zeros_like(columns)
    else:
        guesses = np.atleast_2d(np.asarray(start).T).astype(kind)
    solved = [
        _conjugate_gradients(matrix, b, x, tolerance, iteration_limit, preconditioner, cancelled)
        for b, x in zip(columns, guesses)
    ]
    return np.array(solved).T.reshape(right_hand_side.shape)


def preconditioner_for(matrix: SparseMatrix):
    """The preconditioner that `solve` uses; make it once to solve with one matrix several times."""
    if matrix.size < LARGE:
        return jacobi(matrix)
    diagonal = matrix.diagonal().real
    beside = matrix.absolute_row_sum() - diagonal
    if np.all(beside <= DOMINATED * diagonal):
        return jacobi(matrix)
    return Multigrid(matrix)


def jacobi(matrix: SparseMatrix):
    """The diagonal as a preconditioner: callable residual (n,) -> (n,)."""
    diagonal = matrix.diagonal().real
    inverse = 1.0 / np.where(diagonal > 0, diagonal, 1.0)
    return lambda residual: inverse * residual


def _conjugate_gradients(matrix, b, x, tolerance, iteration_limit, preconditioner, cancelled):
    """Flexible conjugate gradients: the preconditioner need not be a fixed linear map."""
    residual = b - matrix.dot(x)
    limit = tolerance * np.linalg.norm(b)
    direction, old_step, curvature = None, None, None
    for _ in range(iteration_limit):
        if np.linalg.norm(residual) <= limit:
            break
        if cancelled is not None and cancelled():
            raise Cancelled("The computation was cancelled.")
        correction = preconditioner(residual)
        if direction is None:
            direction = correction
        else:
            # Making the new direction conjugate to the last one explicitly is what keeps
            # the method sound with a preconditioner that varies.
            slope = np.vdot(old_step, correction) / curvature
            direction = correction - slope * direction
        image = matrix.dot(direction)
        curvature = np.vdot(direction, image).real
        if curvature <= 0:
            break
        length = np.vdot(direction, residual) / curvature
        x = x + length * direction
        residual = residual - length * image
        old_step = image
    return x
