"""The coarse block mesh: one quad for each block, and the curved boundaries between the blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..blocks.blocks import Blocks
from ..blocks.chords import find_chords
from .regridding import edge_chain


@dataclass(frozen=True)
class BlockMesh:
    """Blocks as a mesh of their own; block and edge numbers are those of Blocks.

    points      (K, 3) float64, the corners of the blocks
    vertex      (K,) int64, vertex of the quad mesh at each corner
    quads       (B, 4) int64, one quad for each block, counter-clockwise
    edges       (E, 2) int64, the corners that each block edge joins
    edge_points list of E: (n + 1, 3) float64, the curve of each block edge from corner to corner
    block_edge  (B, 4) int64, edges of sides corner0-corner1, 1-2, 2-3, 3-0
    edge_chord  (E,) int64, chord of each edge: edges of one chord have the same divisions
    """

    points: np.ndarray
    vertex: np.ndarray
    quads: np.ndarray
    edges: np.ndarray
    edge_points: list
    block_edge: np.ndarray
    edge_chord: np.ndarray


def block_mesh(points, blocks: Blocks) -> BlockMesh:
    """The block mesh of a quad mesh with vertices points (P, 3)."""
    vertex, quads = np.unique(blocks.corner, return_inverse=True)
    first, last = blocks.edge_offset[:-1], blocks.edge_offset[1:] - 1
    ends = np.stack([blocks.edge_vertex[first], blocks.edge_vertex[last]], axis=1)
    return BlockMesh(
        points[vertex], vertex, quads.reshape(-1, 4), np.searchsorted(vertex, ends),
        [points[edge_chain(blocks, edge)] for edge in range(len(ends))], blocks.block_edge,
        find_chords(blocks).edge_chord,
    )


def block_mesh_obj(mesh: BlockMesh) -> bytes:
    """The block mesh as OBJ: a group `block_0007` for each quad, `edge_0012` for each curve.

    Curves are line elements through vertices of their own between the corners. The comment before
    a block names its four edges.
    """
    lines = ["# Block mesh by Crossfield"]
    lines += [_vertex(point) for point in mesh.points.tolist()]
    for block, (quad, edges) in enumerate(zip((mesh.quads + 1).tolist(), mesh.block_edge.tolist())):
        lines.append("# edges " + " ".join(map(str, edges)))
        lines += [f"g block_{block:04d}", "f " + " ".join(map(str, quad))]
    free = len(mesh.points) + 1
    for edge, (curve, ends) in enumerate(zip(mesh.edge_points, (mesh.edges + 1).tolist())):
        inner = [_vertex(point) for point in curve[1:-1].tolist()]
        chain = [ends[0], *range(free, free + len(inner)), ends[1]]
        free += len(inner)
        lines += [*inner, f"g edge_{edge:04d}", "l " + " ".join(map(str, chain))]
    return ("\n".join(lines) + "\n").encode("ascii")


def _vertex(point):
    x, y, z = point
    return f"v {x!r} {y!r} {z!r}"
