"""Crosses that are fixed before the field is computed: those on the boundary.

A boundary vertex whose surface angle is Theta gets n_b = max(1, round(2 Theta / pi)) blocks. Its
cross lies symmetrically to its two boundary edges: on the bisector when n_b is even, 45 degrees
off it when n_b is odd (section 3.2 of the paper). The cross then deviates from each of the two
edges by the same angle |Theta - n_b pi / 2| / 2: at most 22.5 degrees, and up to 45 degrees
where Theta < 45 degrees.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..surface.surface import TriangleSurface


@dataclass(frozen=True)
class Constraints:
    """Fixed crosses and the numbers of blocks along the boundary.

    fixed        (V,) bool, the cross of the vertex is given
    angle        (V,) float64, radians in the frame of the vertex; 0 where not fixed
    block_count  (V,) int64, n_b on the boundary, 0 inside
    kink         (V,) bool, boundary vertices with n_b = 2 that turn by more than the kink angle
    lean         (V,) float64 or 0, radians by which the cross is turned from its symmetrical place
                 between the two boundary edges, where these are jagged
    guide        (V,) complex128 or None, w exp(4 i angle): the cross is drawn to this angle with a
                 strength w, one over the square of a length; 0 where free
    """

    fixed: np.ndarray
    angle: np.ndarray
    block_count: np.ndarray
    kink: np.ndarray
    lean: np.ndarray | float = 0.0
    guide: np.ndarray | None = None

    @property
    def corner(self) -> np.ndarray:
        """(V,) bool, boundary vertices where other than two blocks meet."""
        return (self.block_count > 0) & (self.block_count != 2)


def boundary_constraints(surface: TriangleSurface, kink_angle: float) -> Constraints:
    """Fix the cross of every boundary vertex by the corner rule.

    kink_angle  radians, see `Constraints.kink`
    """
    theta, fixed = surface.angle_sum, surface.on_boundary
    block_count = np.where(fixed, np.maximum(1, np.rint(2 * theta / np.pi)), 0).astype(np.int64)
    angle = np.where(fixed, cross_angle(theta, block_count), 0.0)
    kink = (block_count == 2) & (np.abs(theta - np.pi) > kink_angle)
    return Constraints(fixed, angle, block_count, kink)


def cross_angle(theta, block_count):
    """The corner rule: (n,) float64, angle of the cross from the boundary edge that leaves.

    theta (n,) float64, surface angle in radians; block_count (n,) int64
    """
    return 0.5 * theta + 0.25 * np.pi * (block_count % 2)
