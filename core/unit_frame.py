"""A frame in which every mesh has about the size 1 and lies at the origin.

Meshes come at 1e-7 and at an offset of 1e9. All computing is done in this frame, so that nothing
depends on scale and place but the last digit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class UnitFrame:
    """centre (3,) float64 and size, both in the user's lengths: (point - centre) / size."""

    centre: np.ndarray
    size: float

    def inward(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) float64, the user's points in this frame."""
        return (points - self.centre) / self.size

    def outward(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) float64, points of this frame in the user's coordinates."""
        return points * self.size + self.centre


def unit_frame(points: np.ndarray) -> UnitFrame:
    """The frame for points (n, 3), finite, at least one.

    Their mean becomes the origin, twice the largest distance from it becomes 1: that of a box is
    its diagonal, but unlike the bounding box it does not change when the points are turned.
    """
    # The middle first: a mean of coordinates far from the origin would lose its last digits.
    middle = 0.5 * (points.min(0) + points.max(0))
    centre = middle + (points - middle).mean(0)
    size = 2 * largest_distance(points, centre)
    return UnitFrame(centre, size if size > 1e-290 else 1.0)


def largest_distance(points: np.ndarray, centre: np.ndarray) -> float:
    """Of points (n, 3), at least one, from a centre (3,)."""
    return float(np.linalg.norm(points - centre, axis=1).max())
