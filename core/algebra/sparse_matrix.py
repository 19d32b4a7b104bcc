"""Square sparse matrices, real or complex, with a fast product in plain NumPy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

# A column of the padded table must be used by this share of the rows to be worth its zeros.
FULL_ENOUGH = 0.3


@dataclass(frozen=True)
class SparseMatrix:
    """A square matrix in compressed rows; make one with `from_triplets`.

    row_offset  (n + 1,) int64, row i holds the entries row_offset[i]:row_offset[i + 1]
    column      (m,) int64, ascending within each row, no column twice
    value       (m,) float64 or complex128
    """

    row_offset: np.ndarray
    column: np.ndarray
    value: np.ndarray

    @classmethod
    def from_triplets(cls, rows, columns, values, size: int) -> SparseMatrix:
        """Matrix of the sum of values[k] at (rows[k], columns[k]); duplicates are added up.

        rows, columns  (m,) int in [0, size)
        values         (m,) real or complex
        """
        key = np.asarray(rows, np.int64) * size + np.asarray(columns, np.int64)
        values = np.asarray(values)
        values = values.astype(np.result_type(values, np.float64), copy=False)
        order = np.argsort(key, kind="stable")
        key = key[order]
        first = np.flatnonzero(np.diff(key, prepend=-1))
        if len(key):
            values = np.add.reduceat(values[order], first)
        row, column = np.divmod(key[first], max(size, 1))
        count = np.bincount(row, minlength=size)
        return cls(np.concatenate([[0], np.cumsum(count)]), column, values)

    @property
    def size(self) -> int:
        """Number of rows, and of columns."""
        return len(self.row_offset) - 1

    @cached_property
    def row(self) -> np.ndarray:
        """(m,) int64, row of each entry."""
        return np.repeat(np.arange(self.size), np.diff(self.row_offset))

    def dot(self, x: np.ndarray) -> np.ndarray:
        """The product with a vector (n,) or with the columns of an (n, k) array; same shape."""
        x = np.asarray(x)
        if x.ndim == 2:
            return np.stack([self.dot(np.ascontiguousarray(c)) for c in x.T], axis=1)
        column, value, surplus = self._padded
        result = np.einsum("ij,ij->i", value, np.take(x, column, mode="clip"))
        if len(surplus):
            product = self.value[surplus] * x[self.column[surplus]]
            result = result.astype(product.dtype, copy=False)
            np.add.at(result, self.row[surplus], product)
        return result

    def diagonal(self) -> np.ndarray:
        """(n,) entries on the diagonal, 0 where there is none."""
        result = np.zeros(self.size, self.value.dtype)
        on_diagonal = self.row == self.column
        result[self.row[on_diagonal]] = self.value[on_diagonal]
        return result

    def absolute_row_sum(self) -> np.ndarray:
        """(n,) float64, sum of the absolute values in each row."""
        return np.bincount(self.row, np.abs(self.value), self.size)

    def dense(self) -> np.ndarray:
        """(n, n) array."""
        result = np.zeros((self.size, self.size), self.value.dtype)
        result[self.row, self.column] = self.value
        return result

    def plus_diagonal(self, shift: np.ndarray) -> SparseMatrix:
        """The sum with a real diagonal matrix, given as (n,); every row must have its diagonal."""
        value, place = self.value.copy(), self._diagonal_place
        value[place] += shift
        result = SparseMatrix(self.row_offset, self.column, value)
        column, table, surplus = self._padded
        # The table of the sum differs in as few places, and is not made anew.
        width, table = table.shape[1], table.copy()
        within = place - self.row_offset[:-1]
        inside = np.flatnonzero(within < width)
        table[inside, within[inside]] += shift[inside]
        shared = {"row": self.row, "_diagonal_place": place, "_padded": (column, table, surplus)}
        result.__dict__.update(shared)
        return result

    @cached_property
    def _diagonal_place(self):
        return np.flatnonzero(self.row == self.column)

    @cached_property
    def _padded(self):
        """Rows as a table of columns and values, padded with zeros, and the entries beyond it.

        One gather and one row sum over this table take half the time of a segmented sum over
        compressed rows. A few very long rows must not widen the table for all the others: what is
        beyond its width is listed apart.
        """
        count = np.diff(self.row_offset)
        used = 1.0 - np.cumsum(np.bincount(count)) / max(self.size, 1)
        width = int(np.count_nonzero(used > FULL_ENOUGH))
        place = np.arange(len(self.column)) - np.repeat(self.row_offset[:-1], count)
        inside = place < width
        column = np.zeros((self.size, width), np.int64)
        value = np.zeros((self.size, width), self.value.dtype)
        column[self.row[inside], place[inside]] = self.column[inside]
        value[self.row[inside], place[inside]] = self.value[inside]
        return column, value, np.flatnonzero(~inside)
