"""Kinks of the outline in coarse layouts: they bind no lines, and fine quads find them afterwards.

Where the outline turns by 20 to 45 degrees, direct layouts have a node. On a circle that was cut
into sixteen segments this asks for sixteen quads, however large they are wanted, and every line that
ends on the circle must take a place between two of them. A coarse layout lets go of such nodes; once
its quads are small enough, the nearest vertex on the outline slides to each kink and stays there.
(method sections 2 and 8)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..cells.cells import NodeKind
from ..cells.layout import Layout
from ..quads.placement import Placement
from ..surface.boundary import build_loops
from ..surface.surface import TriangleSurface


@dataclass(frozen=True)
class Kinks:
    """Where the outline of a surface, or of its charts, turns.

    loop      (n,) int64, boundary loops
    position  (n,) float64, arc length along them
    """

    loop: np.ndarray
    position: np.ndarray


def without_kinks(layout: Layout) -> tuple[Layout, Kinks]:
    """The layout with plain boundary nodes for kinks, and the kinks: on charts, all copies.

    A kink where other than two pieces of outline and feature curves meet, or that is a corner on
    another chart, stays.
    """
    complex, gluing = layout.complex, layout.gluing
    outline = complex.arc_loop >= 0
    if gluing is not None:
        outline |= np.bincount(gluing.arc, minlength=complex.arc_count) == 2
    pieces = np.bincount(complex.arc_node[outline].ravel(), minlength=complex.node_count)
    plain = (complex.node_kind == NodeKind.KINK) & (pieces == 2)
    if gluing is None:
        return replace(layout, complex=_as_walls(complex, plain)), _places(complex, plain)
    on_charts = plain[gluing.node] & (gluing.complex.node_kind == NodeKind.KINK)
    kinks = _places(gluing.complex, on_charts)
    gluing = replace(gluing, complex=_as_walls(gluing.complex, on_charts))
    return replace(layout, complex=_as_walls(complex, plain), gluing=gluing), kinks


def _as_walls(complex, mask):
    return replace(complex, node_kind=np.where(mask, NodeKind.WALL, complex.node_kind))


def _places(complex, mask):
    """The nodes of a mask: each of them starts one arc of the outline."""
    start = (complex.arc_loop >= 0) & mask[complex.arc_node[:, 0]]
    return Kinks(complex.arc_loop[start], complex.arc_loop_start[start])


def snap_to_kinks(
    surface: TriangleSurface, placement: Placement, kinks: Kinks, across=None, room=2
) -> Placement:
    """The nearest vertex of each kink put there and fixed, if no other kink is nearer to it.

    Loops with fewer than `room` vertices for each kink are left as they are: there the kinks are
    those of a smooth curve, and vertices on some of them would be spread unevenly.

    across  (P,) int64 or None, see `SheetQuads`: the copies on both sides of a cut go together;
            `gluing.synchronise` makes them meet exactly

    No vertex overtakes another: each goes less than half way to its neighbour, or none.
    """
    loop, position = kinks.loop, kinks.position
    vertices = np.bincount(placement.loop[placement.loop >= 0], minlength=surface.loop_count)
    roomy = room * np.bincount(loop, minlength=surface.loop_count) <= vertices
    loop, position = loop[roomy[loop]], position[roomy[loop]]
    vertex, gap = _nearest(surface, placement, loop, position)
    order = np.lexsort((gap, vertex))
    order = order[np.diff(vertex[order], prepend=-1) != 0]
    kink = order[(vertex[order] >= 0) & ~placement.fixed[vertex[order]]]
    vertex = vertex[kink]
    point, face = placement.point.copy(), placement.face.copy()
    there, fixed = placement.loop_position.copy(), placement.fixed.copy()
    point[vertex], face[vertex] = build_loops(surface).point(loop[kink], position[kink])
    there[vertex] = position[kink]
    fixed[vertex] = True
    if across is not None:
        other = across[vertex]
        fixed[other[other >= 0]] = True
    return replace(placement, point=point, face=face, loop_position=there, fixed=fixed)


def _nearest(surface, placement, loop, position):
    """The vertex (n,) on the same loop that is nearest to each place, and how far it is along it."""
    loops = build_loops(surface)
    wall = np.flatnonzero(placement.loop >= 0)
    key = loops.key_start[placement.loop[wall]] + placement.loop_position[wall]
    wall = wall[np.argsort(key, kind="stable")]
    first = np.searchsorted(placement.loop[wall], np.arange(len(loops.length) + 1))
    key = loops.key_start[placement.loop[wall]] + placement.loop_position[wall]
    after = np.searchsorted(key, loops.key_start[loop] + position)
    begin, count = first[loop], np.diff(first)[loop]
    best, least = np.full(len(loop), -1), np.full(len(loop), np.inf)
    for step in (-1, 0):
        chosen = wall[begin + np.mod(after - begin + step, np.maximum(count, 1))]
        ahead = loops.wrap(loop, placement.loop_position[chosen] - position)
        gap = np.minimum(ahead, loops.length[loop] - ahead)
        better = (count > 0) & (gap < least)
        best[better], least[better] = chosen[better], gap[better]
    return best, least
