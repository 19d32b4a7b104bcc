"""Distortion of a quad mesh and its gradient.

At every corner, with a and b the edges to the next and to the previous corner, divided by the
lengths that they should have,

    f = ((1 - s) (a.a + b.b) / 2 + s (1 + J^2) / 2) / chi(J),    J = normal . (a x b),

which is 1 for a right angle between edges of the right lengths and grows without bound as the
corner flattens. chi(J) = (J + sqrt(J^2 + epsilon^2)) / 2 lets inverted corners in: they cost much
but not infinitely much, and turn over. (Garanzha et al., Foldover-free maps in 50 lines of code,
2021.) The energy is the sum of f to an even power; a high power cares for the worst corners.
"""

from __future__ import annotations

import numpy as np

_SIZE_SHARE = 0.1  # s above: weight of the area against the shape
# Quads at a time: their temporary arrays stay in the cache and in memory that is handed out again,
# which halves the time.
_AT_ONCE = 800


class QuadEnergy:
    """Energy of all corners for given wanted lengths and normals.

    quads   (Q, 4) int64
    normal  (Q, 3) float64, unit surface normal for each quad
    wanted  (Q, 2) float64, wanted length of edges 0 and 2, and of edges 1 and 3
    """

    def __init__(self, quads, normal, wanted, power=2):
        self.corner = np.ascontiguousarray(quads.T)
        inverse = 1.0 / wanted[:, [0, 1, 0, 1]]
        self.parts = [
            _Part(quads[some], normal[some], inverse[some], power // 2)
            for some in (slice(k, k + _AT_ONCE) for k in range(0, len(quads), _AT_ONCE))
        ]

    def worst_corner(self, points) -> float:
        """Smallest J of all corners; negative if a corner is inverted."""
        place = np.ascontiguousarray(points.T)
        return min((float(part.edges(place)[2].min()) for part in self.parts), default=1.0)

    def __call__(self, points, epsilon):
        """(energy float, gradient (P, 3) float64) at points (P, 3)."""
        place = np.ascontiguousarray(points.T)
        pull, total, first = np.empty((3, *self.corner.shape)), 0.0, 0
        for part in self.parts:
            last = first + part.corner.shape[1]
            value, pull[:, :, first:last] = part(place, epsilon)
            total, first = total + value, last
        vertex = self.corner.ravel()
        gradient = [np.bincount(vertex, along.ravel(), len(points)) for along in pull]
        return total, np.stack(gradient, axis=1)


class _Part:
    """The corners of some of the quads; arguments as of QuadEnergy, lengths as their inverse."""

    def __init__(self, quads, normal, inverse, half_power):
        self.corner = np.ascontiguousarray(quads.T)
        self.normal = np.ascontiguousarray(normal.T)[:, None]
        self.half_power = half_power
        self.inverse = np.ascontiguousarray(inverse.T)

    def edges(self, place):
        """Edges a (3, 4, Q) over their wanted lengths, a x normal, and J (4, Q).

        place  (3, P) float64. The edge b at a corner is minus the edge a at the corner before.
        """
        place = np.take(place, self.corner, axis=1)
        edge = (_after(place) - place) * self.inverse
        turned = _cross(edge, self.normal)
        return edge, turned, -(edge * _before(turned)).sum(0)

    def __call__(self, place, epsilon):
        """(energy float, its derivatives (3, 4, Q) by the corners of the quads)."""
        edge, turned, area = self.edges(place)
        root = np.sqrt(area * area + epsilon * epsilon)
        # Where J is negative, J + root would lose its digits: chi times half = epsilon^2 / 4.
        half = 0.5 * (np.abs(area) + root)
        chi = np.where(area < 0, 0.25 * epsilon * epsilon / half, half)
        squared = (edge * edge).sum(0)
        shape = 0.5 * (squared + _before(squared))
        value = ((1 - _SIZE_SHARE) * shape + 0.5 * _SIZE_SHARE * (area * area + 1.0)) / chi
        below = value  # value to the power minus one
        for _ in range(self.half_power - 1):
            below = below * (value * value)
        outer = (2 * self.half_power) * below / chi
        by_area = outer * (_SIZE_SHARE * area - value * chi / root)
        by_edge = outer * (1 - _SIZE_SHARE)
        pull = (by_edge + _after(by_edge)) * edge
        pull += _after(by_area * turned) - by_area * _before(turned)
        pull *= self.inverse
        return float((value * below).sum()), _before(pull) - pull


def _after(corner):
    """Values of the next corner; corners along the last axis but one."""
    return np.take(corner, (1, 2, 3, 0), axis=-2)


def _before(corner):
    """Values of the previous corner; corners along the last axis but one."""
    return np.take(corner, (3, 0, 1, 2), axis=-2)


def _cross(a, b):
    """Cross product along the first axis."""
    result = np.empty_like(a)
    result[0] = a[1] * b[2] - a[2] * b[1]
    result[1] = a[2] * b[0] - a[0] * b[2]
    result[2] = a[0] * b[1] - a[1] * b[0]
    return result


def wanted_lengths(points, quads, edge_length, share):
    """(Q, 2) float64: mean lengths of opposite edges, moved towards edge_length.

    share 0 keeps what is there, share 1 asks for squares of edge_length; geometric mean between.
    """
    corner = points[quads]
    length = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
    mean = np.maximum(0.5 * (length[:, :2] + length[:, 2:]), 0.01 * edge_length)
    return mean ** (1 - share) * edge_length**share
