"""Triangles cut at vertices on their edges: into two, three or four pieces, conforming."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Pieces:
    """What triangles were cut into.

    triangles        (F', 3) int64
    face_origin      (F',) int64, the triangle that each is a piece of, in ascending order
    halfedge_origin  (3F',) int64, the halfedge that each halfedge lies on, in the same direction;
                     -1 for those inside
    """

    triangles: np.ndarray
    face_origin: np.ndarray
    halfedge_origin: np.ndarray


def cut_triangles(points: np.ndarray, triangles: np.ndarray, middle: np.ndarray) -> Pieces:
    """Cut triangles at the given vertices on their edges.

    points     (V, 3) float64, those vertices included
    triangles  (F, 3) int64
    middle     (3F,) int64, vertex on halfedge 3 f + c, or -1; the same on both sides of an edge
    """
    middle = middle.reshape(-1, 3)
    split = middle >= 0
    count = split.sum(1)
    whole = np.flatnonzero(count == 0)
    pieces, origin, source = [triangles[whole]], [whole], [np.tile(np.arange(3), (len(whole), 1))]
    for cuts, divide in ((1, _in_two), (2, _in_three), (3, _in_four)):
        face = np.flatnonzero(count == cuts)
        # Turned so that the cut edges come first.
        turn = np.argmax(split[face], axis=1)
        turn = np.where((cuts == 2) & split[face, 2] & split[face, 0], 2, turn)
        column = (turn[:, None] + np.arange(3)) % 3
        corner, cut = triangles[face[:, None], column], middle[face[:, None], column]
        for part, side in divide(points, *corner.T, *cut.T):
            side = np.stack(np.broadcast_arrays(*side, face)[:3], axis=1)
            pieces.append(np.stack(part, axis=1))
            origin.append(face)
            source.append(np.where(side >= 0, (turn[:, None] + side) % 3, -1))
    origin, source = np.concatenate(origin), np.concatenate(source)
    order = np.argsort(origin, kind="stable")
    halfedge = np.where(source >= 0, 3 * origin[:, None] + source, -1)
    return Pieces(np.concatenate(pieces)[order], origin[order], halfedge[order].ravel())


# Each piece: its corners, and the edge (0 = ab, 1 = bc, 2 = ca, -1 = none) of each of its sides.


def _in_two(_points, a, b, c, ab, _bc, _ca):
    return ((a, ab, c), (0, -1, 2)), ((ab, b, c), (0, 1, -1))


def _in_three(points, a, b, c, ab, bc, _ca):
    """The ear at b, and the remaining quad cut along its shorter diagonal."""
    from_a = np.linalg.norm(points[bc] - points[a], axis=1)
    from_c = np.linalg.norm(points[ab] - points[c], axis=1)
    short = from_a <= from_c
    last, last_side = np.where(short, bc, c), np.where(short, -1, 2)
    first, first_side = np.where(short, a, ab), np.where(short, 2, -1)
    return (
        ((ab, b, bc), (0, 1, -1)),
        ((a, ab, last), (0, -1, last_side)),
        ((first, bc, c), (-1, 1, first_side)),
    )


def _in_four(_points, a, b, c, ab, bc, ca):
    return (
        ((a, ab, ca), (0, -1, 2)),
        ((ab, b, bc), (0, 1, -1)),
        ((ca, bc, c), (-1, 1, 2)),
        ((ab, bc, ca), (-1, -1, -1)),
    )
