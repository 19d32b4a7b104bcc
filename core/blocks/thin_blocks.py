"""Sentences about blocks that are thinner than half the wanted edge length. (method section 9)

A row of blocks stays however thin it is where two things lie on its two sides that must not become
one: singularities, corners, or one of these and the boundary. The sentence names them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..quads.quad_mesh import QuadMesh
from ..sentences import PlacedSentence
from .blocks import Blocks
from .chords import find_chords

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
    text = f"{_so_many(len(short))} ({places}): there the blocks are those of the lines as traced."
    return (PlacedSentence(text, tuple(mesh.points[ends.ravel()]), tuple(length[told])),)


@dataclass(frozen=True)
class ThinRow:
    """A row of blocks with short edges, and the edge across it that shows why it stays.

    edges  (n,) int64, the short block edges across the row, the shortest first
    ends   (2,) int64, vertices of the quad mesh on its two sides that must not become one; where
           there are none, the ends of its shortest edge
    gap    length of the block edge between them
    names  what the two vertices are, or None where only shapes keep the row
    """

    edges: np.ndarray
    ends: np.ndarray
    gap: float
    names: tuple | None


def find_thin_rows(mesh: QuadMesh, fixed, blocks: Blocks, size: float) -> list:
    """All ThinRow of a block layout, in the order of their shortest edges.

    mesh   QuadMesh, with its blocks
    fixed  (P,) bool, vertices at corners and kinks
    size   wanted edge length of the quads, in the same lengths
    """
    length = edge_lengths(mesh.points, blocks)
    short = _short(length, size)
    chord = find_chords(blocks).edge_chord
    kind, ends = _kinds(mesh, fixed), _ends(blocks)
    keeps = _keeps_apart(mesh, blocks, kind[ends])
    rows = []
    for row in dict.fromkeys(chord[short].tolist()):
        kept = np.flatnonzero((chord == row) & keeps)
        edges = short[chord[short] == row]
        edge = kept[np.argmin(length[kept])] if len(kept) else edges[0]
        vertex = np.array(sorted(ends[edge].tolist(), key=lambda v: (-kind[v], v)))
        names = tuple(_name(mesh, kind, v) for v in vertex) if len(kept) else None
        rows.append(ThinRow(edges, vertex, float(length[edge]), names))
    return rows


def thin_rows_told(mesh: QuadMesh, fixed, blocks: Blocks, size: float) -> tuple:
    """At most one PlacedSentence about thin rows of few blocks; arguments as of `find_thin_rows`."""
    rows = find_thin_rows(mesh, fixed, blocks, size)
    if not rows:
        return ()
    told = rows[:_MOST_TOLD]
    parts = "; ".join(_told_row(number, row.names) for number, row in enumerate(told))
    short = sum(len(row.edges) for row in rows)
    text = f"{_so_many(short)}, since these must stay apart: {parts}."
    points = mesh.points[np.concatenate([row.ends for row in told])]
    return (PlacedSentence(text, tuple(points), tuple(row.gap for row in told)),)


def _told_row(number, names) -> str:
    """What keeps row `number`, to be filled with its length and places; names of both ends."""
    first, second = f"{{point[{2 * number}]}}", f"{{point[{2 * number + 1}]}}"
    gap = f"{{length[{number}]}} apart"
    if names is None:
        return f"{first} and {second}, {gap}, for the shapes of the quads"
    return f"the {names[0]} at {first} and the {names[1]} at {second}, {gap}"


def _short(length, size):
    """Numbers of the short edges, the shortest first."""
    short = np.flatnonzero(length < THIN * size)
    return short[np.argsort(length[short], kind="stable")]


def _so_many(short: int) -> str:
    edges = "block edge is" if short == 1 else "block edges are"
    return f"{short:,} {edges} shorter than half the wanted edge length"


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
    crease = np.sort(mesh.crease, axis=1)
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
