"""Triangulated patches and quad grids with known geometry, made in code for the tests."""

import numpy as np

from core.surface.surface import build_surface


def grid_quads(m, n, closed=False):
    """(m * n, 4) quads of a grid of (n + 1) rows; closed joins the last column to the first."""
    columns = m if closed else m + 1
    i, j = (a.ravel() for a in np.meshgrid(np.arange(m), np.arange(n)))
    k = (i + 1) % columns
    low, high = j * columns, (j + 1) * columns
    return np.stack([low + i, low + k, high + k, high + i], axis=1)


def grid_parameters(m, n, closed=False):
    """((n + 1) * columns, 2) parameters in [0, 1], row by row."""
    u = np.arange(m if closed else m + 1) / m
    v = np.arange(n + 1) / n
    return np.stack([a.ravel() for a in np.meshgrid(u, v)], axis=1)


def triangulate(quads, seed=0):
    """Two triangles a quad, diagonals by a fixed random choice."""
    other = np.random.default_rng(seed).random(len(quads)) < 0.5
    turned = np.where(other[:, None], np.roll(quads, -1, axis=1), quads)
    return np.concatenate([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]])


def flat(parameter):
    return np.column_stack([parameter, np.zeros(len(parameter))])


def octant(parameter):
    """Four-cornered patch of the unit sphere."""
    point = np.column_stack([np.tan((parameter - 0.5) * np.pi / 3), np.ones(len(parameter))])
    return point / np.linalg.norm(point, axis=1, keepdims=True)


def bump(parameter):
    """Square with a hill."""
    radius = ((parameter - 0.5) ** 2).sum(1)
    return np.column_stack([parameter, 0.3 * np.exp(-20 * radius)])


def annulus(parameter):
    """Ring of radii 1 and 2 for a closed grid, counter-clockwise."""
    angle, radius = -2 * np.pi * parameter[:, 0], 1 + parameter[:, 1]
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle])


def patch(shape, m, n=None, closed=False, jitter=0.0, seed=0):
    """TriangleSurface of a shape; jitter moves inner vertices in the parameters, in grid steps."""
    n = m if n is None else n
    parameter = grid_parameters(m, n, closed)
    inside = (parameter[:, 1] > 0) & (parameter[:, 1] < 1)
    if not closed:
        inside &= (parameter[:, 0] > 0) & (parameter[:, 0] < 1)
    move = np.random.default_rng(seed).uniform(-jitter, jitter, parameter.shape) / [m, n]
    points = shape(parameter + move * inside[:, None])
    return build_surface(points, triangulate(grid_quads(m, n, closed), seed))
