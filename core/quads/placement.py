"""Where the vertices of a quad mesh lie on the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Placement:
    """Positions that know their place on the surface.

    point          (P, 3) float64, exactly on the surface
    face           (P,) int64, triangle of the surface that holds the point
    loop           (P,) int64, boundary loop that the point lies on, -1 inside
    loop_position  (P,) float64, arc length along that loop from the tail of its first halfedge,
                   in [0, loop length); 0 inside
    fixed          (P,) bool, corners and kinks
    """

    point: np.ndarray
    face: np.ndarray
    loop: np.ndarray
    loop_position: np.ndarray
    fixed: np.ndarray
