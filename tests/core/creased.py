"""Surfaces with creases, made in code for the tests of feature edges."""

import numpy as np

from core.surface.surface import build_surface
from tests.core.surfaces import _from_quads, plate


def solid(mask, refine=1, seed=0):
    """Closed surface of the unit voxels where `mask` (3D) is true, `refine` squares an edge."""
    mask = np.asarray(mask, bool)
    for axis in range(3):
        mask = np.repeat(mask, refine, axis)
    inside = np.pad(mask, 1)
    shape = np.array(inside.shape) + 1
    quads = []
    for axis in range(3):
        u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        for sign in (1, -1):
            cell = np.argwhere(inside & ~np.roll(inside, -sign, axis))
            base = cell + (np.eye(3, dtype=int)[axis] if sign > 0 else 0)
            ring = [base, base + u, base + u + v, base + v][::sign]
            quads.append(np.stack([np.ravel_multi_index(p.T, shape) for p in ring], 1))
    points = (np.stack(np.unravel_index(np.arange(shape.prod()), shape), 1) - 1) / refine
    return _from_quads(points, np.concatenate(quads), seed)


def cube(refine=1):
    return solid(np.ones((1, 1, 1)), refine)


def block(refine=2):
    """L-shaped block."""
    mask = np.ones((2, 2, 1))
    mask[1, 1] = 0
    return solid(mask, refine)


def capped_cylinder(around=32, along=8, rings=6, height=2.0):
    """Closed cylinder of radius 1."""
    angle = 2 * np.pi * np.arange(around) / around
    circle = np.stack([np.cos(angle), np.sin(angle)], 1)
    outline = [(k / rings, 0.0) for k in range(1, rings + 1)]
    outline += [(1.0, height * k / along) for k in range(1, along + 1)]
    outline += [(k / rings, height) for k in range(rings - 1, 0, -1)]
    points = [np.array([[0, 0, 0], [0, 0, height]], float)]
    points += [np.c_[radius * circle, np.full(around, z)] for radius, z in outline]
    ring = 2 + around * np.arange(len(outline))[:, None] + np.arange(around)
    after = np.roll(ring, -1, axis=1)
    a, b, c, d = ring[:-1].ravel(), after[:-1].ravel(), after[1:].ravel(), ring[1:].ravel()
    bottom = np.stack([np.zeros(around, int), after[0], ring[0]], 1)
    top = np.stack([np.ones(around, int), ring[-1], after[-1]], 1)
    sides = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return build_surface(np.concatenate(points), np.concatenate([bottom, sides, top]))


def roof(slope=1.0, n=12):
    """Plate of 2 x 1 folded along its short middle line."""
    flat = plate(np.ones((2 * n, n)), 1 / n)
    points = flat.points.copy()
    points[:, 2] = -slope * np.abs(points[:, 0] - 1.0)
    return build_surface(points, flat.triangles)


def fading_crease(n=20, slope=1.5, end=0.6):
    """Unit plate whose crease along y = 1/2 starts at x = 0 and has faded out at x = end."""
    flat = plate(np.ones((n, n)), 1 / n)
    points = flat.points.copy()
    points[:, 2] = -slope * np.maximum(end - points[:, 0], 0) * np.abs(points[:, 1] - 0.5)
    return build_surface(points, flat.triangles)


def edges_on(surface, on_line):
    """(n, 2) edges whose ends both satisfy on_line((V, 3) points) -> (V,) bool."""
    hit = on_line(surface.points)
    edge = surface.edges
    chosen = edge[hit[surface.tail[edge]] & hit[surface.head[edge]]]
    return np.stack([surface.tail[chosen], surface.head[chosen]], 1)
