"""Cross-fields for the tests of lines and cells: smooth ones by a dense solve, rough ones by noise."""

import numpy as np

from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field


def smooth_field(surface, noise=0.0, seed=0):
    """(constraints, field): harmonic in u = exp(4 i a), with noise in radians added inside.

    A dense solve: for surfaces of up to about two thousand vertices.
    """
    constraints = boundary_constraints(surface, np.radians(20))
    angle = np.where(constraints.fixed, constraints.angle, _harmonic(surface, constraints))
    disturbance = np.random.default_rng(seed).uniform(-noise, noise, surface.vertex_count)
    angle = np.where(constraints.fixed, angle, angle + disturbance)
    return constraints, build_cross_field(surface, angle, constraints)


def _harmonic(surface, constraints):
    edge = surface.edges
    i, j = surface.tail[edge], surface.head[edge]
    turn = np.exp(4j * surface.transport[edge])
    matrix = np.zeros((surface.vertex_count, surface.vertex_count), complex)
    np.add.at(matrix, (i, i), 1.0)
    np.add.at(matrix, (j, j), 1.0)
    matrix[i, j], matrix[j, i] = -turn.conj(), -turn
    free = ~constraints.fixed
    value = np.exp(4j * constraints.angle)
    if constraints.fixed.any():
        right = -matrix[np.ix_(free, constraints.fixed)] @ value[constraints.fixed]
        value[free] = np.linalg.solve(matrix[np.ix_(free, free)], right)
    else:
        value = np.linalg.eigh(matrix)[1][:, 0]
    return np.angle(value) / 4
