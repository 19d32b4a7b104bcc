"""The quad mesh made solid: a second sheet of vertices, one cell away along the normals."""

from __future__ import annotations

import numpy as np

from ..errors import LayoutError, SettingsError
from ..quads.quality import quad_normal


def extrusion_height(points, quads) -> float:
    """The mean edge length of the quads: the height of one cell as deep as it is wide."""
    corner = np.asarray(points)[quads]
    return float(np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).mean())


def extrude(points, quads, height: float | None = None) -> np.ndarray:
    """(P, 3) float64, the points moved along the normals of the quads by a height.

    points  (P, 3) float64
    quads   (Q, 4) int64, counter-clockwise
    height  object-space length, or None for the mean edge length

    A vertex moves along the mean normal of its quads, weighted by area. Raises SettingsError for
    a height that is not positive, LayoutError where it folds the other side.
    """
    points = np.asarray(points, np.float64)
    height = extrusion_height(points, quads) if height is None else height
    if not (np.isfinite(height) and height > 0):
        raise SettingsError(f"The height {height} of the extrusion must be a positive number.")
    corner = points[quads]
    area = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]) / 2
    normal = np.zeros_like(points)
    np.add.at(normal, quads.ravel(), np.repeat(area, 4, axis=0))
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    moved = points + height * normal
    folded = (quad_normal(points, quads) * quad_normal(moved, quads)).sum(1) <= 0
    if folded.any():
        raise LayoutError(
            f"Extruded by {height:g}, {np.count_nonzero(folded)} quads fold over; give a smaller"
            " height."
        )
    return moved
