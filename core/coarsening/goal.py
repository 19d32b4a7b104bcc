"""What is asked of the quads: their size or their number, and the divisions that give it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..settings import Settings
from .coarse_divisions import divide, divide_to_count
from .drafts import DraftBoard

# Layouts of few rows allow few numbers of quads; those further off are taken only for lack of others.
_COUNT_TOLERANCE = 0.1


@dataclass(frozen=True)
class Goal:
    """What is asked for: the size of the quads (object-space lengths), their number or None."""

    size: float
    quad_count: int | None

    @staticmethod
    def of(settings: Settings, area: float) -> Goal:
        """What settings ask for on a surface of the given area."""
        if settings.edge_length is not None:
            return Goal(settings.edge_length, None)
        return Goal(float(np.sqrt(area / settings.quad_count)), settings.quad_count)

    def is_met(self, count: int) -> bool:
        """Is a number of quads near the wanted one?"""
        return self.quad_count is None or abs(count / self.quad_count - 1) < _COUNT_TOLERANCE

    def divide(self, board: DraftBoard, width, row, alive) -> np.ndarray:
        """(count,) int64, valid divisions of rows of blocks, see `coarse_divisions.divide`.

        Where kinks in one row need quads between them, each of its chords is divided by itself.
        """
        together = self._divide(board, width, row, alive)
        if board.is_valid(together):
            return together
        result = self._divide(board, width, np.arange(len(row)), alive)
        for number in np.flatnonzero(np.bincount(row, alive) > 1).tolist():
            trial = np.where(row == number, together, result)
            if board.is_valid(trial):
                result = trial
        return result

    def _divide(self, board, width, row, alive):
        if self.quad_count is None:
            return divide(width, self.size, row, alive)
        complex = board.layout.complex
        return divide_to_count(complex, board.chords, width, self.quad_count, row, alive)
