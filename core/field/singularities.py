"""Singularities of a cross-field, and the sum of their indices that topology prescribes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..surface.surface import TriangleSurface
from .constraints import Constraints
from .cross_field import CrossField


@dataclass(frozen=True)
class Singularities:
    """The singular triangles of a field.

    face      (S,) int64, ascending
    index     (S,) int64, I, never zero
    position  (S, 3) float64, incentre of the triangle
    index_sum           sum of I over the triangles plus sum of 2 - n_b over the boundary
    expected_index_sum  4 chi: index_sum equals it exactly on every surface
    """

    face: np.ndarray
    index: np.ndarray
    position: np.ndarray
    index_sum: int
    expected_index_sum: int

    @property
    def valence(self) -> np.ndarray:
        """(S,) int64, quads that meet there: 4 - I."""
        return 4 - self.index

    @property
    def k(self) -> np.ndarray:
        """(S,) int64, the paper's k = -I = valence - 4."""
        return -self.index

    def __len__(self) -> int:
        return len(self.face)


def find_singularities(
    surface: TriangleSurface, field: CrossField, constraints: Constraints
) -> Singularities:
    """Triangles round which the cross makes quarter turns (section 3.3 of the paper)."""
    face = np.flatnonzero(field.index)
    blocks = constraints.block_count[surface.on_boundary]
    index_sum = int(field.index.sum()) + int((2 - blocks).sum())
    return Singularities(
        face, field.index[face], incenters(surface, face),
        index_sum, 4 * surface.euler_characteristic,
    )


def incenters(surface: TriangleSurface, face) -> np.ndarray:
    """(n, 3) float64, centres of the inscribed circles of the given triangles."""
    # The edge opposite corner 0 is the second halfedge, and so on round.
    weight = np.roll(surface.edge_length.reshape(-1, 3)[face], -1, axis=1)
    weight = weight / weight.sum(1, keepdims=True)
    return (surface.points[surface.triangles[face]] * weight[:, :, None]).sum(1)
