#!/usr/bin/env python3
"""Makes the example meshes beside this file: plate.obj, aerofoil.obj and octant.obj.

    python3 examples/make_examples.py        needs NumPy and SciPy; always the same meshes

A planar domain is given by closed outlines made of smooth pieces. Outlines are divided by the
wanted size, the inside is seeded from a quadtree of the same size, and the points are spread by
repulsion between neighbours while Delaunay triangulation keeps up with them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial import Delaunay, cKDTree

HERE = Path(__file__).resolve().parent


def divide(piece, size):
    """Points along a dense polyline (n, 2) at spacing size(points), its last point left out."""
    step = np.linalg.norm(np.diff(piece, axis=0), axis=1)
    measure = np.append(0.0, np.cumsum(step / size((piece[1:] + piece[:-1]) / 2)))
    count = max(2, round(measure[-1]))
    wanted = np.linspace(0.0, measure[-1], count + 1)[:-1]
    return np.column_stack([np.interp(wanted, measure, piece[:, k]) for k in range(2)])


def inside(points, loops):
    """(n,) bool, whether a ray to the right crosses the loops an odd number of times."""
    odd = np.zeros(len(points), bool)
    for loop in loops:
        for a, b in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            spans = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                x = a[0] + (points[:, 1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
            odd ^= spans & (points[:, 0] < x)
    return odd


def seeds(low, high, size, largest):
    """Centres of the leaves of a quadtree whose cells are no larger than the wanted size."""
    count = np.ceil((high - low) / largest).astype(int)
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in count)), -1).reshape(-1, 2)
    centres, width, leaves = low + (cells + 0.5) * largest, largest, []
    while len(centres):
        fine = size(centres) >= width
        leaves.append(centres[fine])
        quarter = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * width / 4
        centres = (centres[~fine, None] + quarter).reshape(-1, 2)
        width /= 2
    return np.concatenate(leaves)


def triangulate(points, loops):
    """(F, 3) counter-clockwise triangles of the domain."""
    triangles = Delaunay(points).simplices
    triangles = triangles[inside(points[triangles].mean(1), loops)]
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles[area < 0] = triangles[area < 0][:, ::-1]
    return triangles[abs(area) > 1e-12]


def mesh_domain(loops, size, largest, rounds=60):
    """Points and triangles of the domain between closed loops of points."""
    wall = np.concatenate(loops)
    near = cKDTree(wall)
    free = seeds(wall.min(0), wall.max(0), size, largest)
    free = free[inside(free, loops)]
    free = free[near.query(free)[0] > 0.7 * size(free)]
    for _ in range(rounds):
        points = np.concatenate([wall, free])
        free = spread(points, triangulate(points, loops), len(wall), size)
        lost = ~inside(free, loops) | (near.query(free)[0] < 0.45 * size(free))
        free = np.where(lost[:, None], points[len(wall) :], free)
    points = np.concatenate([wall, free])
    return points, triangulate(points, loops)


def spread(points, triangles, fixed, size):
    """One round of repulsion between neighbours that are too close; the first points stay."""
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    across = points[edges[:, 1]] - points[edges[:, 0]]
    length = np.linalg.norm(across, axis=1)
    wanted = size(points[edges].mean(1))
    wanted *= 1.2 * np.sqrt((length**2).sum() / (wanted**2).sum())
    push = 0.2 * (np.maximum(wanted - length, 0) / length)[:, None] * across
    moved = points.copy()
    np.add.at(moved, edges[:, 0], -push)
    np.add.at(moved, edges[:, 1], push)
    return moved[fixed:]


def ellipse(centre, radii, turn=0.0, count=2000):
    """A closed smooth piece; negative radii[1] walks it clockwise."""
    angle = np.linspace(0, 2 * np.pi, count)
    x, y = radii[0] * np.cos(angle), radii[1] * np.sin(angle)
    cos, sin = np.cos(turn), np.sin(turn)
    return np.column_stack([centre[0] + cos * x - sin * y, centre[1] + sin * x + cos * y])


def straight(corners):
    """The sides of a polygon, each a piece."""
    following = np.roll(corners, -1, axis=0)
    return [np.linspace(a, b, 200) for a, b in zip(corners, following, strict=True)]


def plate():
    """A plate with a wavy outline, a round, a slotted and a four-cornered hole."""

    def size(points):
        return np.full(len(points), 0.037)

    angle = np.linspace(0, 2 * np.pi, 4000)
    radius = 1 + 0.12 * np.cos(3 * angle + 0.4)
    outline = np.column_stack([1.55 * radius * np.cos(angle), radius * np.sin(angle)])
    arcs = [np.linspace(-np.pi / 2, np.pi / 2, 300), np.linspace(np.pi / 2, 3 * np.pi / 2, 300)]
    slot = np.concatenate(
        [
            np.column_stack([side + 0.14 * np.cos(a), 0.14 * np.sin(a)])
            for side, a in zip((0.28, -0.28), arcs, strict=True)
        ]
    )
    slot = np.concatenate([slot, slot[:1]]) @ [[0.87, 0.5], [-0.5, 0.87]] + [0.25, 0.48]
    pieces = [[outline], [ellipse((-0.75, 0.12), (0.3, 0.3))], [slot]]
    pieces.append(straight(np.array([[0.35, -0.45], [0.85, -0.5], [0.95, -0.1], [0.5, 0.0]])))
    loops = [np.concatenate([divide(p, size) for p in loop]) for loop in pieces]
    return mesh_domain(loops, size, 0.037)


def profile(camber, thickness, chord, nose, turn):
    """Upper and lower side of a NACA four-digit aerofoil with a closed trailing edge."""
    x = (1 - np.cos(np.linspace(0, np.pi, 600))) / 2
    polynomial = 0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4
    half, middle = 5 * thickness * polynomial, camber * 4 * x * (1 - x)
    upper, lower = np.column_stack([x, middle + half]), np.column_stack([x, middle - half])
    piece = chord * np.concatenate([upper[::-1], lower[1:]])
    cos, sin = np.cos(turn), np.sin(turn)
    return piece @ [[cos, sin], [-sin, cos]] + nose


def aerofoil():
    """Slat, wing and flap in a far field that is round in front and square behind."""
    elements = [
        profile(0.10, 0.13, 0.20, (-0.21, -0.125), np.radians(24)),
        profile(0.03, 0.13, 0.80, (0.0, 0.0), 0.0),
        profile(0.05, 0.13, 0.34, (0.79, -0.045), np.radians(-28)),
    ]
    walls = cKDTree(np.concatenate(elements))

    def size(points):
        return np.clip(0.009 + 0.15 * walls.query(points)[0], 0.009, 0.06)

    front = np.linspace(np.pi / 2, 3 * np.pi / 2, 600)
    bow = np.column_stack([0.4 + 0.9 * np.cos(front), 0.9 * np.sin(front)])
    corners = np.array([[0.4, -0.9], [1.7, -0.9], [1.7, 0.9], [0.4, 0.9]])
    outline = [bow, *straight(corners)[:3]]
    pieces = [outline]
    pieces += [[element] for element in elements]
    loops = [np.concatenate([divide(p, size) for p in loop]) for loop in pieces]
    return mesh_domain(loops, size, 0.06)


def octant(count=40):
    """An eighth of the unit sphere: its curvature asks for one singularity of valence 3."""
    a, b = np.meshgrid(np.arange(count + 1), np.arange(count + 1))
    kept = (a + b) <= count
    number = np.full(a.shape, -1)
    number[kept] = np.arange(kept.sum())
    points = np.column_stack([count - a[kept] - b[kept], a[kept], b[kept]]).astype(float)
    points = np.sin(np.pi / 2 * points / count)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    up = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, :-1]], -1)[kept[:-1, 1:]]
    whole = kept[1:, 1:]
    down = np.stack([number[:-1, 1:], number[1:, 1:], number[1:, :-1]], -1)[whole]
    return points, np.concatenate([up, down])


def write(name, points, triangles):
    """Write an OBJ with nine digits, flat domains at height 0."""
    points = np.column_stack([points, np.zeros(len(points))]) if points.shape[1] == 2 else points
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in points]
    lines += ["f {} {} {}".format(*triangle) for triangle in triangles + 1]
    (HERE / name).write_text("\n".join(lines) + "\n", encoding="ascii")
    print(f"{name}: {len(points)} vertices, {len(triangles)} triangles")


if __name__ == "__main__":
    write("plate.obj", *plate())
    write("aerofoil.obj", *aerofoil())
    write("octant.obj", *octant())
