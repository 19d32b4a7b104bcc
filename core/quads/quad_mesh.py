"""The conforming all-quad mesh that a decomposition hands out."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class QuadMesh:
    """The conforming all-quad mesh.

    points           (P, 3) float64, on the input surface; boundary vertices on its boundary
    quads            (Q, 4) int64, counter-clockwise
    on_boundary      (P,) bool
    valence          (P,) int64, number of quads round each vertex
    scaled_jacobian  (Q,) float64, the worst of the four corners
    crease           (n, 2) int64, end vertices of the edges that lie on feature edges
    """

    points: np.ndarray
    quads: np.ndarray
    on_boundary: np.ndarray
    valence: np.ndarray
    scaled_jacobian: np.ndarray
    crease: np.ndarray = field(default_factory=lambda: np.zeros((0, 2), np.int64))
