"""Sentences about blocks that are thinner than half the wanted edge length. (method section 9)"""

from __future__ import annotations

import numpy as np

from ..blocks.blocks import Blocks
from ..sentences import PlacedSentence

# Share of the wanted edge length below which an edge of a block counts as short.
THIN = 0.5
# Short edges whose places are told, the shortest first.
_MOST_TOLD = 3


def edge_lengths(points, blocks: Blocks) -> np.ndarray:
    """(E,) float64, how long the block edges are; points (P, 3) are those of the quad mesh."""
    chain = points[blocks.edge_vertex]
    total = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(chain, axis=0), axis=1))])
    return total[blocks.edge_offset[1:] - 1] - total[blocks.edge_offset[:-1]]


def thin_blocks(points, blocks: Blocks, size: float, cause: str) -> tuple:
    """At most one PlacedSentence, with the places of the thinnest blocks; mostly none.

    points  (P, 3) float64, of the quad mesh
    size    wanted edge length of the quads, in the same lengths
    cause   why blocks are thin there, the end of the sentence

    A block is at least as wide as its shortest edge is long: without a sentence none is thin.
    """
    length = edge_lengths(points, blocks)
    short = np.flatnonzero(length < THIN * size)
    if not len(short):
        return ()
    told = short[np.argsort(length[short], kind="stable")[:_MOST_TOLD]]
    ends = blocks.edge_vertex[
        np.stack([blocks.edge_offset[told], blocks.edge_offset[told + 1] - 1], axis=1)
    ]
    places = "; ".join(
        f"{{length[{k}]}} between {{point[{2 * k}]}} and {{point[{2 * k + 1}]}}"
        for k in range(len(told))
    )
    edges = "block edge is" if len(short) == 1 else "block edges are"
    text = f"{len(short):,} {edges} shorter than half the wanted edge length ({places}): {cause}."
    return (PlacedSentence(text, tuple(points[ends.ravel()]), tuple(length[told])),)
