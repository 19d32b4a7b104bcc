"""Surfaces of known topology and known singularities, made in code for the tests of the field."""

import numpy as np

from core.surface.surface import build_surface


def regular_polygon(sides, rings, jitter=0.15, seed=1):
    """Regular polygon of circumradius 1, triangulated in rings round its centre."""
    corner = np.exp(2j * np.pi * np.arange(sides + 1) / sides)
    points, triangles, first = [0j], [], [0]
    for ring in range(1, rings + 1):
        first.append(len(points))
        for side in range(sides):
            t = np.arange(ring) / ring
            points.extend(ring / rings * ((1 - t) * corner[side] + t * corner[side + 1]))
    for ring in range(1, rings + 1):
        outer_count, inner_count = sides * ring, max(1, sides * (ring - 1))
        for side in range(sides):
            for i in range(ring):
                a = first[ring] + side * ring + i
                b = first[ring] + (side * ring + i + 1) % outer_count
                c = first[ring - 1] + (side * (ring - 1) + i) % inner_count
                triangles.append((a, b, c))
                if i < ring - 1:
                    d = first[ring - 1] + (side * (ring - 1) + i + 1) % inner_count
                    triangles.append((c, b, d))
    points = np.array(points)
    inside = np.arange(len(points)) < first[rings]
    noise = np.random.default_rng(seed).uniform(-jitter, jitter, (len(points), 2)) / rings
    points = np.stack([points.real, points.imag], 1) + np.where(inside[:, None], noise, 0)
    return build_surface(np.c_[points, np.zeros(len(points))], triangles)


def disc(rings):
    """Unit disc, from a hexagon whose rings are rounded."""
    surface = regular_polygon(6, rings)
    points = surface.points.copy()
    angle = np.arctan2(points[:, 1], points[:, 0])
    sector = (angle + 2 * np.pi) % (np.pi / 3) - np.pi / 6
    return build_surface(points * (np.cos(sector) / np.cos(np.pi / 6))[:, None], surface.triangles)


def plate(mask, step=1.0, jitter=0.0, seed=3):
    """The cells of a square grid where `mask` is true, each cut along a random diagonal."""
    mask = np.asarray(mask, bool)
    m, n = mask.shape
    i, j = np.nonzero(mask)
    number = np.arange((m + 1) * (n + 1)).reshape(m + 1, n + 1)
    quads = np.stack([number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]], 1)
    grid = np.stack(np.meshgrid(np.arange(m + 1), np.arange(n + 1), indexing="ij"), -1)
    points = np.c_[grid.reshape(-1, 2) * step, np.zeros((m + 1) * (n + 1))]
    surface = _from_quads(points, quads, seed)
    noise = np.random.default_rng(seed).uniform(-jitter, jitter, (surface.vertex_count, 2)) * step
    moved = surface.points.copy()
    moved[~surface.on_boundary, :2] += noise[~surface.on_boundary]
    return build_surface(moved, surface.triangles)


def lshape(n, jitter=0.2):
    mask = np.ones((2 * n, 2 * n), bool)
    mask[n:, n:] = False
    return plate(mask, 1 / n, jitter)


def plate_with_holes(n=24):
    """Square with five square holes: six boundary loops, Euler characteristic -4."""
    mask = np.ones((n, n), bool)
    for i, j in ((3, 3), (3, 15), (15, 3), (15, 15), (9, 9)):
        mask[i : i + 4, j : j + 4] = False
    return plate(mask, 1 / n, 0.2)


def cylinder(around, along, height=2.0, share=1.0):
    """Cylinder of radius 1; closed round its axis when share is 1, half of it when 0.5."""
    closed = share == 1
    u, v = np.meshgrid(np.arange(around + (not closed)), np.arange(along + 1))
    angle = 2 * np.pi * share * u.ravel() / around
    points = np.c_[np.cos(angle), np.sin(angle), height * v.ravel() / along]
    return _from_quads(points, _grid_quads(around, along, closed, False))


def annulus(around, along, inner=0.4):
    surface = cylinder(around, along, 1.0)
    points = surface.points
    radius = 1 - (1 - inner) * points[:, 2]
    return build_surface(points * np.c_[radius, radius, np.zeros(len(points))], surface.triangles)


def torus(around=24, along=16):
    u, v = np.meshgrid(np.arange(around), np.arange(along))
    u, v = 2 * np.pi * u.ravel() / around, 2 * np.pi * v.ravel() / along
    points = np.c_[(2 + np.cos(v)) * np.cos(u), (2 + np.cos(v)) * np.sin(u), np.sin(v)]
    return _from_quads(points, _grid_quads(around, along, True, True))


def octant(n):
    """The octant x, y, z >= 0 of the unit sphere: three right angles."""
    points, triangles = _subdivided_triangle(np.eye(3), n)
    return build_surface(points / np.linalg.norm(points, axis=1, keepdims=True), triangles)


def sphere(n):
    """Unit sphere, each face of an octahedron cut into n^2 triangles."""
    corners = np.concatenate([np.eye(3), -np.eye(3)])
    points, triangles = [], []
    for x in (0, 3):
        for y in (1, 4):
            for z in (2, 5):
                odd = ((x > 2) + (y > 2) + (z > 2)) % 2
                part, face = _subdivided_triangle(corners[[x, z, y] if odd else [x, y, z]], n)
                triangles.append(face + sum(map(len, points)))
                points.append(part)
    points, triangles = np.concatenate(points), np.concatenate(triangles)
    _, first, number = np.unique(
        np.rint(points * n).astype(int), axis=0, return_index=True, return_inverse=True
    )
    points = points[first] / np.linalg.norm(points[first], axis=1, keepdims=True)
    return build_surface(points, number.ravel()[triangles])


def voxel_shell(mask, seed=4):
    """Closed surface of a plate of unit cubes; each hole in `mask` is a handle."""
    solid = np.pad(np.asarray(mask, bool)[:, :, None], 1)
    shape = np.array(solid.shape) + 1
    quads = []
    for axis in range(3):
        u, v = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
        for sign in (1, -1):
            cell = np.argwhere(solid & ~np.roll(solid, -sign, axis))
            base = cell + (np.eye(3, dtype=int)[axis] if sign > 0 else 0)
            ring = [base, base + u, base + u + v, base + v][::sign]
            quads.append(np.stack([np.ravel_multi_index(p.T, shape) for p in ring], 1))
    points = np.stack(np.unravel_index(np.arange(shape.prod()), shape), 1).astype(float)
    return _from_quads(points, np.concatenate(quads), seed)


def together(*surfaces):
    """Several surfaces as one that is not connected."""
    points = [s.points + [10 * i, 0, 0] for i, s in enumerate(surfaces)]
    offset = np.cumsum([0] + [s.vertex_count for s in surfaces])
    triangles = [s.triangles + offset[i] for i, s in enumerate(surfaces)]
    return build_surface(np.concatenate(points), np.concatenate(triangles))


def crumpled(surface, amount, seed=5):
    """The same connectivity with every vertex moved at random, in edge lengths."""
    noise = np.random.default_rng(seed).uniform(-1, 1, surface.points.shape)
    noise *= amount * surface.mean_edge_length
    return build_surface(surface.points + noise, surface.triangles)


def _grid_quads(around, along, closed_around, closed_along):
    columns, rows = around + (not closed_around), along + (not closed_along)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(around), np.arange(along)))
    k, l = (i + 1) % columns, (j + 1) % rows
    return np.stack([j * columns + i, j * columns + k, l * columns + k, l * columns + i], 1)


def _from_quads(points, quads, seed=0):
    other = np.random.default_rng(seed).random(len(quads)) < 0.5
    turned = np.where(other[:, None], np.roll(quads, -1, axis=1), quads)
    triangles = np.concatenate([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]])
    used, number = np.unique(triangles, return_inverse=True)
    return build_surface(points[used], number.reshape(-1, 3))


def _subdivided_triangle(corners, n):
    number, weights = {}, []
    for i in range(n + 1):
        for j in range(n + 1 - i):
            number[i, j] = len(weights)
            weights.append((n - i - j, i, j))
    triangles = []
    for i, j in number:
        if i + j < n:
            triangles.append((number[i, j], number[i + 1, j], number[i, j + 1]))
        if i + j < n - 1:
            triangles.append((number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]))
    return np.array(weights) @ corners / n, np.array(triangles)
