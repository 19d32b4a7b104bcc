"""Bends of walls that get nodes where cells beside them are thin, lest quads cut them off."""

from __future__ import annotations

import numpy as np

from ..blocks.blocks import Blocks
from ..quads.placement import Placement
from ..surface.boundary import BoundaryLoops

# Bends of the boundary by more than this, in radians, get a node.
_BEND = np.radians(15)
# Nodes stay apart by this share of the distance that they had.
_APART = 0.4


def edge_bends(loops: BoundaryLoops, placement: Placement, blocks: Blocks, arcs, direction) -> list:
    """List of E: (k,) float64, ascending places of bends inside each block edge between its vertices,
    of 1; none on edges inside the surface.

    arcs       list of E, arc lengths at the vertices of each edge
    direction  (E,) int, 1 where a boundary edge runs as its loop does, else -1
    """
    result = [np.zeros(0) for _ in arcs]
    for edge in np.flatnonzero(blocks.edge_on_boundary):
        start, arc = blocks.edge_vertex[blocks.edge_offset[edge]], arcs[edge]
        bends = _loop_bends(
            loops, placement.loop[start], placement.loop_position[start], direction[edge]
        )
        inside = bends[(bends > 0) & (bends < arc[-1])]
        result[edge] = np.interp(inside, arc, np.linspace(0, 1, len(arc)))
    return result


def _loop_bends(loops, loop, start, sign):
    """(n,) float64, ascending, arc lengths from a place on a loop to its bends, counted along sign."""
    piece = slice(loops.first[loop], loops.first[loop + 1])
    ahead = loops.step[piece] / np.maximum(loops.step_length[piece], 1e-300)[:, None]
    bent = (ahead * np.roll(ahead, 1, axis=0)).sum(1) < np.cos(_BEND)
    return np.sort(np.mod(sign * (loops.position[piece][bent] - start), loops.length[loop]))


def moved_to_bends(place, bends, kept):
    """Ascending places (n + 1,) of nodes, of which the nearest ones moved to bends.

    kept  (n + 1,) bool, nodes that stay

    The nodes between share in the movement. Bends give way to nearer ones where two nodes would come close to each other.
    """
    node = np.array([np.argmin(np.abs(place - bend)) for bend in bends], np.int64)
    held, result = kept.copy(), place.copy()
    held[[0, -1]] = True
    for number in np.argsort(np.abs(place[node] - bends), kind="stable"):
        there = node[number]
        if held[there]:
            continue
        before, result[there] = result[there], bends[number]
        around = slice(there - 1, there + 2)
        if (np.diff(result[around]) < _APART * np.diff(place[around])).any():
            result[there] = before
            continue
        held[there] = True
    return place + np.interp(place, place[held], (result - place)[held])
