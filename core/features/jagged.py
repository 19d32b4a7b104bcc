"""Jagged boundaries of scans: the corner rule reads a smoothed curve, so that noise makes no corners.

A stretch of boundary is jagged where many neighbouring vertices turn sharply and the turns cancel.
There the direction of the boundary is the mean over several edges; a corner remains where the mean
direction itself turns by about a right angle. Everything else keeps the corner rule unchanged.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..field.constraints import Constraints, cross_angle
from ..surface.surface import TriangleSurface

# Edges to either side over which directions are averaged.
WINDOW = 5
# Loops of fewer edges are what they are: the window would see half of them.
SHORTEST_LOOP = 40
# Radians from which a vertex turns sharply, how many of them in a window make it jagged, and the
# least turning in the window that other turning undoes.
SHARP, MOST_SHARP, UNDONE = np.radians(25), 4, np.pi
# Radians up to which a vertex goes straight on, and the share of them in a window that noise has.
STRAIGHT, MOST_STRAIGHT = np.radians(2), 0.4
# Mean direction before and after a vertex must differ by more for a corner, in radians.
CORNER = np.radians(75)


def smooth_jagged(
    surface: TriangleSurface, constraints: Constraints, cut=False
) -> Constraints:
    """The constraints with those along jagged stretches of the boundary read off a smoothed curve.

    cut  (3F,) bool, boundary halfedges along which the surface was cut: near them all corners count

    The sum of 2 - n_b may be any: the field inside makes up for it with other singularities.
    """
    outer = ~np.broadcast_to(cut, surface.twin.shape)
    loops = [
        _smoothed_loop(surface, constraints, surface.loop_halfedges[begin:end], outer)
        for begin, end in zip(surface.loop_offset[:-1], surface.loop_offset[1:], strict=True)
    ]
    changes = [change for change in loops if change is not None]
    if not changes:
        return constraints
    vertex, blocks, lean = (np.concatenate(column) for column in zip(*changes, strict=True))
    block_count, kink = constraints.block_count.copy(), constraints.kink.copy()
    block_count[vertex], kink[vertex] = blocks, False
    leaning = np.zeros(surface.vertex_count)
    leaning[vertex] = lean
    angle = constraints.angle.copy()
    angle[vertex] = cross_angle(surface.angle_sum[vertex], blocks) + lean
    return replace(constraints, block_count=block_count, angle=angle, kink=kink, lean=leaning)


def _smoothed_loop(surface, constraints, halfedge, outer):
    """(vertices, block counts, leans of the cross) along the jagged stretches of a loop, or None."""
    count = len(halfedge)
    vertex = surface.tail[halfedge]
    turn = np.pi - surface.angle_sum[vertex]
    whole = _round_about(count, np.arange(-WINDOW, WINDOW))
    jagged = _is_jagged(turn) & outer[halfedge][whole].all(1)
    if count < SHORTEST_LOOP or not jagged.any():
        return None
    # Directions of the edges after and before each vertex, against the edge that leaves it.
    ahead, behind = _directions(turn)
    step = surface.edge_length[halfedge]
    weight_ahead = step[_round_about(count, np.arange(WINDOW))]
    weight_behind = step[_round_about(count, -1 - np.arange(WINDOW))]
    bend = _mean(ahead, weight_ahead) - _mean(behind, weight_behind)
    corner = jagged & (np.abs(bend) > CORNER) & _is_peak(np.abs(np.where(jagged, bend, 0.0)))
    corner |= ~jagged & (constraints.block_count[vertex] != 2)
    blocks = np.where(corner, np.maximum(2 - np.rint(bend / (np.pi / 2)), 1), 2).astype(np.int64)
    open_ahead = _unbroken(corner, np.arange(WINDOW))
    open_behind = _unbroken(corner, -np.arange(WINDOW))
    directions = np.concatenate([ahead, behind], axis=1)
    weights = np.concatenate([weight_ahead * open_ahead, weight_behind * open_behind], axis=1)
    # The symmetrical cross of two blocks follows the mean of the two edges, half the turn back.
    lean = np.where(corner, 0.0, _mean(directions, weights) + 0.5 * turn)
    return vertex[jagged], blocks[jagged], lean[jagged]


def _round_about(count, offset):
    """(count, len(offset)) int64, positions on a loop at the given offsets from each position."""
    return (np.arange(count)[:, None] + offset) % count


def _is_jagged(turn):
    near = turn[_round_about(len(turn), np.arange(-WINDOW, WINDOW + 1))]
    undone = np.abs(near).sum(1) - np.abs(near.sum(1))
    sharp = np.abs(near) > SHARP
    # Steps and teeth have straight runs between their corners; noise has none.
    straight = (np.abs(near) < STRAIGHT).mean(1) > MOST_STRAIGHT
    both = (near > SHARP).any(1) & (near < -SHARP).any(1)
    return (sharp.sum(1) >= MOST_SHARP) & (undone > UNDONE) & both & ~straight


def _directions(turn):
    """(n, WINDOW) angles of the edges ahead and behind, relative to the edge leaving each vertex."""
    count = len(turn)
    ahead = np.cumsum(turn[_round_about(count, 1 + np.arange(WINDOW))], axis=1)
    ahead = np.concatenate([np.zeros((count, 1)), ahead[:, :-1]], axis=1)
    behind = -np.cumsum(turn[_round_about(count, -np.arange(WINDOW))], axis=1)
    return ahead, behind


def _mean(values, weights):
    return (values * weights).sum(1) / np.maximum(weights.sum(1), 1e-300)


def _is_peak(value):
    """True where a value is the first largest one within half a window to either side."""
    reach = np.arange(-WINDOW, WINDOW + 1)
    near = value[_round_about(len(value), reach)]
    return np.argmax(near, axis=1) == WINDOW


def _unbroken(corner, offset):
    """(n, WINDOW) bool, edges that no corner parts from the vertex, nearest first."""
    parted = corner[_round_about(len(corner), offset)]
    parted[:, 0] = False
    return ~np.logical_or.accumulate(parted, axis=1)
