"""Propagation of the cross-field from the fixed crosses, in the order of the arrival distance.

Every vertex takes the cross that minimises the energy of the one element its front came through
(sections 3.1 and 3.2 of the paper, eq. 11 in closed form). All vertices whose parents are done are
computed together, which gives exactly what one after the other would give.
"""

from __future__ import annotations

import numpy as np

from ..surface.surface import TriangleSurface
from .constraints import Constraints
from .cross_field import wrap
from .distance import ArrivalDistance


def propagate(
    surface: TriangleSurface, constraints: Constraints, arrival: ArrivalDistance
) -> np.ndarray:
    """(V,) float64, crosses in the frames of their vertices, radians.

    The sources of the arrival distance keep the angle of the constraints.
    """
    angle = np.where(arrival.source, constraints.angle, 0.0)
    for vertex in _levels(arrival):
        angle[vertex] = wrap(_optimal_angle(arrival, vertex, angle))
    return angle


def _optimal_angle(arrival, vertex, angle):
    """The minimiser of eq. 11 at these vertices over their upwind elements.

    Each term of the energy, quadratic in the angle sought, adds to a numerator and a denominator
    whose quotient is the minimiser.
    """
    parent, transport = arrival.parent[vertex], arrival.transport[vertex]
    first = angle[parent[:, 0]] + transport[:, 0]
    second = first + wrap(angle[parent[:, 1]] + transport[:, 1] - first)
    numerator, denominator = smoothness_term(
        arrival.base[vertex], arrival.apex[vertex], first, second
    )
    return numerator / denominator


def smoothness_term(base, apex, first, second):
    """Numerator and denominator of the Dirichlet energy of the angle, eq. 6 of the paper.

    base, apex     (n,), (n, 2) the elements, as in ArrivalDistance; base 0 for a single parent
    first, second  (n,) angles at the two parents in the frame of the target, matched

    The weight of a parent is the cotangent of the angle at the other one, so the minimiser is the
    value at the foot of the target's altitude. A foot beyond the edge is moved to its end: an
    obtuse element would extrapolate.
    """
    along, away = apex.T
    joined = base > 0
    away = np.where(joined, away, 1.0)
    weight_first = np.where(joined, np.maximum(base - along, 0.0), 1.0) / away
    weight_second = np.where(joined, np.maximum(along, 0.0), 0.0) / away
    return weight_first * first + weight_second * second, weight_first + weight_second


def _levels(arrival):
    """Yields index arrays: the vertices that are neither sources nor wait for others any more."""
    target = np.flatnonzero(~arrival.source)
    parents = arrival.parent[target]
    order = np.argsort(parents.T.ravel(), kind="stable")
    child = np.concatenate([target, target])[order]
    count = np.bincount(parents.ravel(), minlength=len(arrival.source))
    offset = np.concatenate([[0], np.cumsum(count)])
    waits_for = np.where(arrival.source, 0, 2)
    done = np.flatnonzero(arrival.source)
    while len(done):
        freed = child[_ranges(offset[done], count[done])]
        np.subtract.at(waits_for, freed, 1)
        done = np.unique(freed[waits_for[freed] == 0])
        if len(done):
            yield done


def _ranges(first, count):
    """first[0], first[0] + 1, ... count[0] numbers, then first[1], ..."""
    before = np.cumsum(count) - count
    return np.arange(count.sum()) + np.repeat(first - before, count)
