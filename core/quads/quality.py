"""Shape measures of quads: scaled Jacobian, aspect ratio, skewness."""

from __future__ import annotations

import numpy as np


def scaled_jacobian(points, quads, normals=None) -> np.ndarray:
    """(Q,) float64, the worst over the four corners of the sine of the corner angle, signed.

    points   (P, 3) float
    quads    (Q, 4) int, vertex numbers, counter-clockwise
    normals  (P, 3) float or None: surface normals at the points. A corner is measured against the
             quad's own normal (the cross product of its diagonals); with surface normals that
             normal is turned to their side first, so that a quad folded over is negative.

    1 is a rectangle, 0 a degenerate quad, below 0 an inverted corner. (method section 10)
    """
    return corner_jacobian(points, quads, normals).min(1, initial=1.0)


def corner_jacobian(points, quads, normals=None) -> np.ndarray:
    """(Q, 4) float64, the scaled Jacobian at each corner; arguments as in `scaled_jacobian`."""
    corner = np.asarray(points, np.float64)[quads]
    leaving = np.roll(corner, -1, axis=1) - corner
    entering = np.roll(leaving, 1, axis=1)
    normal = quad_normal(points, quads)
    if normals is not None:
        opposed = (normal * np.asarray(normals)[quads].sum(1)).sum(1) < 0
        normal = np.where(opposed[:, None], -normal, normal)
    length = np.linalg.norm(leaving, axis=2)
    product = length * np.roll(length, 1, axis=1)
    area = (np.cross(entering, leaving) * normal[:, None]).sum(2)
    return area / np.maximum(product, 1e-300)


def quad_normal(points, quads) -> np.ndarray:
    """(Q, 3) float64, unit normals: cross product of the diagonals; zero for degenerate quads."""
    corner = np.asarray(points, np.float64)[quads]
    vector = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    return vector / np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), 1e-300)


def aspect_ratio(points, quads) -> np.ndarray:
    """(Q,) float64, longest over shortest edge; inf for a quad with an edge of length zero."""
    corner = np.asarray(points, np.float64)[quads]
    length = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
    shortest = length.min(1, initial=np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(shortest > 0, length.max(1, initial=0.0) / shortest, np.inf)


def skewness(points, quads) -> np.ndarray:
    """(Q,) float64 in [0, 1], largest deviation of a corner angle from 90 degrees over 90 degrees.

    0 is a rectangle; 1 a corner of 0 or of 180 degrees or more.
    """
    corner = np.asarray(points, np.float64)[quads]
    leaving = np.roll(corner, -1, axis=1) - corner
    backward = -np.roll(leaving, 1, axis=1)
    area = (np.cross(leaving, backward) * quad_normal(points, quads)[:, None]).sum(2)
    angle = np.arctan2(area, (leaving * backward).sum(2))
    deviation = np.abs(angle / (np.pi / 2) - 1)
    return np.minimum(np.where(area < 0, 1.0, deviation).max(1, initial=0.0), 1.0)
