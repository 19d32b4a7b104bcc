"""Blocks cut in parts whose corners alone make valid hexahedra, as some readers of blocks demand.

The sides of a block are curves: where one winds far round a wall, the hexahedron with straight
edges between the corners of the block may be inside out, although every cell of its grid is fine.
"""

from __future__ import annotations

import numpy as np

from ..blocks.blocks import Blocks, find_blocks

# Corners of the six faces of a hexahedron, counter-clockwise seen from outside; its second four
# corners lie above the first four.
_FACES = np.array([
    (0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7),
])
# The centre of a hexahedron lies inside each face by at least this share of the face's width.
_LEAST_DEPTH = 1e-3


def cut_to_plain_hexahedra(points, back, quads, blocks: Blocks):
    """The blocks, or parts of them as few as seem needed, and the block of each part (B',) int64.

    points  (P, 3) float64, the vertices of the quad mesh
    back    (P, 3) float64, the same moved along the normals
    quads   (Q, 4) int64

    Cuts are whole mesh lines, so that the parts conform, too. A single quad is never cut.
    """
    source = np.zeros(len(points), bool)
    source[blocks.corner] = True
    parts = blocks
    while True:
        depth = hexahedron_depth(points, back, parts.corner)
        depth[(parts.shape == 1).all(1)] = np.inf
        worst = int(np.argmin(depth))
        if depth[worst] > _LEAST_DEPTH:
            return parts, _owners(blocks, parts)
        source[_best_cut(points, back, parts, worst)] = True
        parts = find_blocks(quads, len(points), source)


def hexahedron_depth(points, back, corner) -> np.ndarray:
    """(B,) float64: how far inside its faces the centre of each hexahedron lies.

    points, back  (P, 3) float64, the first four and the second four corners are taken from
    corner        (B, 4) int64, counter-clockwise about the direction from points to back

    As a share of the square root of the face's area, the smallest of all faces; both the mean of
    the corners and the centre of volume must lie inside. Negative where one lies outside.
    """
    solid = np.concatenate([points[corner], back[corner]], axis=1)
    face = solid[:, _FACES]
    middle = face.mean(2)
    side = np.roll(face, -1, axis=2)
    triangle = np.cross(side - face, middle[:, :, None] - face) / 2
    normal = triangle.sum(2)
    size = np.linalg.norm(triangle, axis=3)
    centre = ((face + side + middle[:, :, None]) / 3 * size[..., None]).sum(2)
    centre /= np.maximum(size.sum(2), 1e-300)[..., None]
    mean = solid.mean(1)[:, None]
    pyramid = ((centre - mean) * normal).sum(2)
    volume = pyramid.sum(1)[:, None]
    weight = np.where(volume > 0, pyramid / np.where(volume > 0, volume, 1.0), 1 / 6)[..., None]
    heart = (weight * (0.75 * centre + 0.25 * mean)).sum(1)[:, None]
    area = np.maximum(np.linalg.norm(normal, axis=2), 1e-300)
    inside = [((centre - inner) * normal).sum(2) / area**1.5 for inner in (mean, heart)]
    return np.minimum(*inside).min(1)


def _best_cut(points, back, parts: Blocks, part):
    """The middle of a side of a part across which it is cut: the better one of both directions."""
    m, n = parts.shape[part]
    begin, end = parts.grid_offset[part : part + 2]
    grid = parts.grid_vertex[begin:end].reshape(n + 1, m + 1)
    found = []
    for rows in (grid, grid.T[:, ::-1]):
        half = (rows.shape[1] - 1) // 2
        if half == 0:
            continue
        halves = (rows[:, : half + 1], rows[:, half:])
        corner = np.array([(r[0, 0], r[0, -1], r[-1, -1], r[-1, 0]) for r in halves])
        depth = hexahedron_depth(points, back, corner).min()
        found.append((depth, rows[0, half]))
    return max(found, key=lambda cut: cut[0])[1]


def _owners(blocks: Blocks, parts: Blocks):
    """(B',) int64, the block that each part lies in."""
    owner = np.zeros(parts.count, np.int64)
    owner[parts.quad_block] = blocks.quad_block
    return owner
