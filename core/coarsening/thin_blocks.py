"""Sentences about blocks that are thinner than half the wanted edge length. (method section 9)

A row of blocks stays however thin it is where two things lie on its two sides that must not become
one: singularities, corners, or one of these and the boundary. The sentence names them.
"""

from __future__ import annotations

import numpy as np

from ..blocks.blocks import Blocks
from ..blocks.chords import find_chords
from ..quads.quad_mesh import QuadMesh
from ..sentences import PlacedSentence

# Share of the wanted edge length below which an edge of a block counts as short.
THIN = 0.5
# Places that are told, the shortest first.
_MOST_TOLD, _MOST_TRACED = 12, 3
# What a vertex is, in ascending order of what must not be joined with what.
_PLAIN, _WALL, _CORNER, _SINGULARITY = range(4)


def edge_lengths(points, blocks: Blocks) -> np.ndarray:
    """(E,) float64, how long the block edges are; points (P, 3) are those of the quad mesh."""
    chain = points[blocks.edge_vertex]
    total = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(chain, axis=0), axis=1))])
    return total[blocks.edge_offset[1:] - 1] - total[blocks.edge_offset[:-1]]


def thin_as_traced(mesh: QuadMesh, blocks: Blocks, size: float) -> tuple:
    """At most one PlacedSentence about the short edges of blocks that nobody tried to join.

    mesh  QuadMesh, with its blocks
    size  wanted edge length of the quads, in the same lengths

    A block is at least as wide as its shortest edge is long: without a sentence none is thin.
    """
    length = edge_lengths(mesh.points, blocks)
    short = _short(length, size)
    if not len(short):
        return ()
    told = short[:_MOST_TRACED]
    ends = _ends(blocks)[told]
    places = "; ".join(
        f"{{length[{k}]}} between {{point[{2 * k}]}} and {{point[{2 * k + 1}]}}"
        for k in range(len(told))
    )
    text = f"{_so_many(short)} ({places}): there the blocks are those of the lines as traced."
    return (PlacedSentence(text, tuple(mesh.points[ends.ravel()]), tuple(length[told])),)


def thin_rows(mesh: QuadMesh, fixed, blocks: Blocks, size: float) -> tuple:
    """At most one PlacedSentence about thin rows of few blocks, and which nodes keep each of them.

    mesh   QuadMesh, with its blocks
    fixed  (P,) bool, vertices at corners and kinks
    size   wanted edge length of the quads, in the same lengths
    """
    length = edge_lengths(mesh.points, blocks)
    short = _short(length, size)
    if not len(short):
        return ()
    chord = find_chords(blocks).edge_chord
    kind, ends = _kinds(mesh, fixed), _ends(blocks)
    keeps = _keeps_apart(mesh, blocks, kind[ends])
    parts, told = [], []
    # The rows in the order of their shortest edges.
    for row in list(dict.fromkeys(chord[short].tolist()))[:_MOST_TOLD]:
        edges = np.flatnonzero(chord == row)
        kept = edges[keeps[edges]]
        edge = min(kept if len(kept) else edges, key=lambda e: length[e])
        ends[edge] = sorted(ends[edge], key=lambda v: (-kind[v], v))
        names = [_name(mesh, kind, v) for v in ends[edge]] if len(kept) else None
        parts.append(_told_row(len(told), names))
        told.append(edge)
    text = f"{_so_many(short)}, since these must stay apart: {'; '.join(parts)}."
    return (PlacedSentence(text, tuple(mesh.points[ends[told].ravel()]), tuple(length[told])),)


def _told_row(number, names) -> str:
    """What keeps row `number`, to be filled with its length and places; names of both ends."""
    first, second = f"{{point[{2 * number}]}}", f"{{point[{2 * number + 1}]}}"
    gap = f"{{length[{number}]}} apart"
    if names is None:
        return f"{first} and {second}, {gap}, without which shapes would suffer"
    return f"the {names[0]} at {first} and the {names[1]} at {second}, {gap}"


def _short(length, size):
    """Numbers of the short edges, the shortest first."""
    short = np.flatnonzero(length < THIN * size)
    return short[np.argsort(length[short], kind="stable")]


def _so_many(short) -> str:
    edges = "block edge is" if len(short) == 1 else "block edges are"
    return f"{len(short):,} {edges} shorter than half the wanted edge length"


def _ends(blocks: Blocks):
    """(E, 2) int64, the vertices at both ends of each block edge."""
    offset = blocks.edge_offset
    return blocks.edge_vertex[np.stack([offset[:-1], offset[1:] - 1], axis=1)]


def _kinds(mesh: QuadMesh, fixed):
    """(P,) int64, what each vertex is: _PLAIN, _WALL, _CORNER or _SINGULARITY."""
    wall = mesh.on_boundary.copy()
    wall[mesh.crease.ravel()] = True
    irregular = mesh.valence != np.where(mesh.on_boundary, 2, 4)
    kind = np.where(wall, _WALL, _PLAIN)
    kind[irregular] = np.where(wall[irregular], _CORNER, _SINGULARITY)
    kind[np.asarray(fixed, bool)] = _CORNER
    return kind


def _keeps_apart(mesh: QuadMesh, blocks: Blocks, kind):
    """(E,) bool: would two things become one that must not, were the edge taken out?

    kind  (E, 2) int64 of the ends. An edge along a wall may join a corner and a point of the wall.
    """
    count = np.int64(len(mesh.points))
    crease = np.sort(np.asarray(mesh.crease, np.int64).reshape(-1, 2), axis=1)
    start = blocks.edge_offset[:-1]
    step = np.sort(np.stack([blocks.edge_vertex[start], blocks.edge_vertex[start + 1]]), axis=0)
    along = blocks.edge_on_boundary | np.isin(
        step[0] * count + step[1], crease[:, 0] * count + crease[:, 1]
    )
    low, high = np.sort(kind, axis=1).T
    return (low >= _CORNER) | ((low == _WALL) & ((high == _SINGULARITY) | ~along))


def _name(mesh: QuadMesh, kind, vertex) -> str:
    if kind[vertex] == _SINGULARITY:
        return f"singularity of valence {mesh.valence[vertex]}"
    if kind[vertex] == _WALL:
        return "boundary" if mesh.on_boundary[vertex] else "crease"
    return "corner" if kind[vertex] == _CORNER else "line"
