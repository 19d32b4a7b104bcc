"""Where creases end: pieces too short to count, and too near to other creases for quads between.

Masks of feature edges are (3F,) bool over halfedges; they are changed in place.
"""

from __future__ import annotations

import numpy as np

from ..surface.projection import barycentric, walk
from ..surface.surface import TriangleSurface, connected_components, previous_halfedge
from .crease_chains import find_chains, open_ends

# Open pieces count from this share of the diameter on, or from a smaller one if made of many edges.
_OPEN_SHARE, _FINE_OPEN_SHARE, _FINE_OPEN_EDGES = 0.1, 0.03, 6
# A crease that nears another one at less than this angle ends where they are this share of the
# diameter apart: between them no quad would have a good shape.
_CUSP_ANGLE, _CUSP_WIDTH = np.radians(20), 0.02


def drop_short_ends(surface: TriangleSurface, crease) -> None:
    """Remove short pieces with an open end, the shortest at each junction first."""
    while True:
        edge = surface.edges[crease[surface.edges]]
        chain, through = find_chains(surface, edge)
        length = np.bincount(chain, surface.edge_length[edge])
        count = np.bincount(chain)
        open_end = np.zeros(surface.vertex_count, bool)
        open_end[open_ends(surface, crease)] = True
        ends = np.stack([surface.tail[edge], surface.head[edge]])
        is_open = np.zeros(len(length), bool)
        is_open[chain[open_end[ends].any(0)]] = True
        counts = length >= _OPEN_SHARE * surface.diameter
        fine = (length >= _FINE_OPEN_SHARE * surface.diameter) & (count >= _FINE_OPEN_EDGES)
        short = is_open & ~counts & ~fine
        # A junction loses one branch at a time: what is left may be one long piece.
        junction = np.full(len(length), -1)
        side, number = np.nonzero(~through[ends] & ~open_end[ends])
        junction[chain[number]] = ends[side, number]
        order = np.flatnonzero(short)
        order = order[np.lexsort((length[order], junction[order]))]
        first = np.diff(junction[order], prepend=-2) != 0
        dropped = order[first | (junction[order] < 0)]
        if not len(dropped):
            return
        gone = edge[np.isin(chain, dropped)]
        crease[gone] = crease[surface.twin[gone]] = False


def trim_cusps(surface: TriangleSurface, crease, angle) -> None:
    """Shorten the fainter of two creases, or of crease and boundary, that meet at a small angle.

    angle  (3F,) float64, dihedral angles in radians
    """
    while True:
        cusps = _cusps(surface, crease)
        if not len(cusps[0]):
            return
        edge = surface.edges[crease[surface.edges]]
        chain = np.full(len(crease), -1)
        chain[edge] = chain[surface.twin[edge]] = find_chains(surface, edge)[0]
        on_chain = chain >= 0
        sharpness = np.bincount(chain[on_chain], angle[on_chain]) / np.bincount(chain[on_chain])
        for right, left, opening in zip(*(column.tolist() for column in cusps)):
            sides = [h for h in (right, left) if crease[h]]
            if sides:
                faint = min(sides, key=lambda h: sharpness[chain[h]])
                width = _CUSP_WIDTH * surface.diameter
                _trim(surface, crease, faint, width / np.sin(max(opening, np.radians(2))))


def _cusps(surface, crease):
    """Narrow sectors between crease or boundary edges: their halfedges, right and left, and angle.

    Both halfedges leave the vertex; the left one is the twin of the last one round, where there is
    one: sectors whose left side is boundary have their right side twice.
    """
    wall = crease | (surface.twin < 0)
    touched = np.zeros(surface.vertex_count, bool)
    touched[surface.tail[crease]] = True
    corner = np.flatnonzero(touched[surface.tail])
    number = np.full(len(wall), -1)
    number[corner] = np.arange(len(corner))
    last = previous_halfedge(corner)
    inside = ~wall[last]
    beyond = number[surface.twin[last[inside]]]
    sector = connected_components(len(corner), np.flatnonzero(inside), beyond)
    opening = np.bincount(sector, surface.corner_angle[corner])
    right = np.full(len(opening), -1)
    left = right.copy()
    starts, ends = wall[corner], ~inside
    right[sector[starts]] = corner[starts]
    left[sector[ends]] = surface.twin[last[ends]]
    left = np.where(left < 0, right, left)
    narrow = np.flatnonzero((opening < _CUSP_ANGLE) & (right >= 0) & (crease[right] | crease[left]))
    return right[narrow], left[narrow], opening[narrow]


def _trim(surface, crease, halfedge, length):
    """Remove so much of a crease from its start on, at most up to its next node, in place."""
    degree = np.bincount(surface.tail[crease], minlength=surface.vertex_count)
    while True:
        crease[halfedge] = crease[surface.twin[halfedge]] = False
        length -= surface.edge_length[halfedge]
        vertex = surface.head[halfedge]
        if length <= 0 or degree[vertex] != 2 or surface.on_boundary[vertex]:
            return
        fan = surface.fan[surface.fan_offset[vertex] : surface.fan_offset[vertex + 1]]
        onward = fan[crease[fan]]
        if not len(onward):
            return
        halfedge = int(onward[0])


def give_ends_room(surface: TriangleSurface, crease, angle) -> None:
    """Shorten creases that end beside another crease or the boundary until their ends have room.

    angle  (3F,) float64, dihedral angles in radians

    The edges of a thin wing that is rounded in a few facets are sharp in places, now here and now
    there; what is left of them is one crease each. The faintest is shortened first.
    """
    while True:
        narrow = _narrow(surface, crease)
        runs = [_crowded_run(surface, crease, narrow, end) for end in open_ends(surface, crease)]
        runs = [run for run in runs if len(run)]
        if not runs:
            return
        gone = min(runs, key=lambda run: float((angle[run] * surface.edge_length[run]).sum()))
        crease[gone] = crease[surface.twin[gone]] = False


def _crowded_run(surface, crease, narrow, end):
    """Halfedges from an open end on, at most to the next node, that have mostly no room beside."""
    degree = np.bincount(surface.tail[crease], minlength=surface.vertex_count)
    run, vertex, back = [], int(end), -1
    while True:
        fan = surface.fan[surface.fan_offset[vertex] : surface.fan_offset[vertex + 1]]
        onward = fan[crease[fan] & (fan != back)]
        if not len(onward):
            break
        run.append(int(onward[0]))
        vertex, back = int(surface.head[run[-1]]), int(surface.twin[run[-1]])
        if degree[vertex] != 2 or surface.on_boundary[vertex]:
            break
    run = np.array(run, np.int64)
    length = surface.edge_length[run]
    excess = np.cumsum(np.where(narrow[run] | narrow[surface.twin[run]], length, -length))
    return run[: excess.argmax() + 1] if excess.max(initial=0.0) > 0 else run[:0]


def _narrow(surface, crease):
    """(3F,) bool, crease halfedges from whose middle a straight way meets another wall too soon."""
    halfedge = np.flatnonzero(crease)
    face = halfedge // 3
    tail, head = surface.points[surface.tail[halfedge]], surface.points[surface.head[halfedge]]
    inward = np.cross(surface.face_normal[face], head - tail)
    inward *= _CUSP_WIDTH * surface.diameter / np.linalg.norm(inward, axis=1, keepdims=True)
    # A little inside, or the first step would already be at the wall.
    middle, centre = 0.5 * (tail + head), surface.points[surface.triangles[face]].mean(1)
    point, end = walk(surface, middle + 1e-6 * (centre - middle), face, inward, crease)
    opposite = 3 * end[:, None] + (np.arange(3) + 1) % 3
    wall = crease[opposite] | (surface.twin[opposite] < 0)
    narrow = np.zeros(len(crease), bool)
    narrow[halfedge] = ((barycentric(surface, end, point) < 1e-9) & wall).any(1)
    return narrow
