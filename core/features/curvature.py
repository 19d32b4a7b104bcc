"""Principal curvature directions as soft guides where nothing else fixes a cross.

The shape operator at a vertex is the average over a neighbourhood of the tensors of the edges: bend
of the edge times its length times the square of its direction, per area. Where its two principal
curvatures clearly differ, the cross is drawn towards their directions; noise averages out, and a
sphere or a plane leaves the field to be as smooth as it can.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..field.constraints import Constraints
from ..surface.surface import TriangleSurface
from .bending import bend_tensors, in_tangent_planes

# Radius of the averaging over the square root of the area of a component, and rounds of averaging.
RADIUS, FEWEST_ROUNDS, MOST_ROUNDS = 0.04, 4, 40
# Difference of the principal curvatures over the sum of their sizes from which it counts, and from
# which it counts in full; the same for the difference times the square root of the area.
LEAST_RATIO, FULL_RATIO = 0.15, 0.45
LEAST_BEND, FULL_BEND = 2.0, 6.0
# Length over which a guide wins against smoothness, over the square root of the area.
REACH = 0.12


def guide_by_curvature(surface: TriangleSurface, constraints: Constraints) -> Constraints:
    """The constraints with a guide on every component that has no fixed cross."""
    tied = np.zeros(surface.component_count, bool)
    tied[np.repeat(surface.component, 3)[constraints.fixed[surface.tail]]] = True
    if tied.all():
        return constraints
    vertex_component = np.empty(surface.vertex_count, np.int64)
    vertex_component[surface.tail] = np.repeat(surface.component, 3)
    area = np.bincount(surface.component, surface.face_area)[vertex_component]
    angle, difference, total = principal_directions(surface)
    ratio = difference / np.maximum(total, 1e-300)
    confidence = _rise(ratio, LEAST_RATIO, FULL_RATIO)
    confidence *= _rise(difference * np.sqrt(area), LEAST_BEND, FULL_BEND)
    strength = np.where(tied[vertex_component], 0.0, confidence / (REACH**2 * area))
    if not strength.any():
        return constraints
    return replace(constraints, guide=strength * np.exp(4j * angle))


def _rise(value, least, full):
    return np.clip((value - least) / (full - least), 0.0, 1.0)


def principal_directions(surface: TriangleSurface):
    """(angle, difference, total), each (V,) float64.

    angle       direction of a principal curvature in the frame of the vertex, radians mod pi/2
    difference  |k1 - k2|, principal curvatures per length
    total       |k1| + |k2|
    """
    xx, xy, yy = in_tangent_planes(surface, _averaged(surface, bend_tensors(surface)))
    mean, half = 0.5 * (xx + yy), np.hypot(0.5 * (xx - yy), xy)
    angle = 0.5 * np.arctan2(xy, 0.5 * (xx - yy))
    return angle, 2 * half, np.abs(mean + half) + np.abs(mean - half)


def _averaged(surface, tensor):
    """The tensors and the areas of the vertices, both spread to the neighbours; their ratio."""
    area = np.bincount(surface.tail, np.repeat(surface.face_area / 3, 3), surface.vertex_count)
    radius = RADIUS * np.sqrt(surface.face_area.sum() / surface.component_count)
    rounds = (radius / surface.mean_edge_length) ** 2 * 2
    rounds = int(np.clip(np.rint(rounds), FEWEST_ROUNDS, MOST_ROUNDS))
    degree = np.bincount(surface.tail, minlength=surface.vertex_count)
    values = np.concatenate([tensor.reshape(-1, 9), area[:, None]], axis=1)
    for _ in range(rounds):
        share = (values / degree[:, None])[surface.tail]
        spread = [
            np.bincount(surface.head, share[:, k], surface.vertex_count) for k in range(10)
        ]
        values = 0.5 * (values + np.stack(spread, axis=1))
    return (values[:, :9] / np.maximum(values[:, 9:], 1e-300)).reshape(-1, 3, 3)
