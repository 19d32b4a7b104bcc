"""The cut that opens a one-sided surface, like a Möbius band, along a shortest path of edges.

A loop of triangles that comes back upside down is found first. Then the shortest path of edges
that crosses the loop an odd number of times: from boundary to boundary, or closed where there is
no boundary. Such a path lives on two storeys, between which each crossing of the loop leads.
"""

from __future__ import annotations

import numpy as np

from ..surface.surface import next_halfedge
from .manifold import fan_of_corner

_STARTS = 8  # places from which a closed path is tried


def shortest_cut(points, triangles, mate, twisted, face) -> np.ndarray:
    """Halfedges (n,) int64 along which the one-sided component that holds `face` is to be cut.

    points (V, 3) float64, triangles (F, 3), mate (3F,) int64, twisted (3F,) bool: halfedges that
    run in the same direction as their mates.

    One cut leaves a Möbius band two-sided; where handles or holes are left over, cut again.
    """
    parent, depth, upside_down = _spanning_tree(mate, twisted, face)
    crossed = _turning_loop(mate, twisted, parent, depth, upside_down)
    halfedge = np.flatnonzero((mate >= 0) & (np.repeat(depth, 3) >= 0))
    halfedge = halfedge[halfedge < mate[halfedge]]
    storey = np.zeros(len(mate), bool)
    storey[crossed] = storey[mate[crossed]] = True
    corner = fan_of_corner(triangles, mate)
    tail, head = corner[halfedge], corner[next_halfedge(halfedge)]
    length = np.linalg.norm(
        points[triangles.ravel()[next_halfedge(halfedge)]] - points[triangles.ravel()[halfedge]],
        axis=1,
    )
    graph = _Storeys(tail, head, length, storey[halfedge], int(corner.max()) + 1)
    wall = np.flatnonzero((mate < 0) & (np.repeat(depth, 3) >= 0))
    if len(wall):
        wall = np.unique(np.concatenate([corner[wall], corner[next_halfedge(wall)]]))
        path = graph.shortest(wall, wall)[1]
    else:
        on_loop = np.unique(corner[crossed])
        starts = on_loop[:: max(1, len(on_loop) // _STARTS)]
        path = min((graph.shortest(s, s) for s in starts[:, None]), key=lambda found: found[0])[1]
    return halfedge[path]


def _spanning_tree(mate, twisted, root):
    """Breadth first over the triangles: the halfedge (F,) through which each was reached, its
    depth (F,), -1 where not reached, and (F,) bool whether it is upside down there."""
    count = len(mate) // 3
    parent, depth = np.full(count, -1, np.int64), np.full(count, -1, np.int64)
    upside_down = np.zeros(count, bool)
    depth[root] = 0
    front = np.array([root])
    while len(front):
        halfedge = (3 * front[:, None] + np.arange(3)).ravel()
        halfedge = halfedge[mate[halfedge] >= 0]
        face = mate[halfedge] // 3
        new = depth[face] < 0
        front, first = np.unique(face[new], return_index=True)
        halfedge = halfedge[new][first]
        parent[front] = mate[halfedge]
        depth[front] = depth[halfedge // 3] + 1
        upside_down[front] = upside_down[halfedge // 3] ^ twisted[halfedge]
    return parent, depth, upside_down


def _turning_loop(mate, twisted, parent, depth, upside_down):
    """Halfedges (n,) crossed by a short loop of triangles that comes back upside down."""
    halfedge = np.flatnonzero((mate >= 0) & (np.repeat(depth, 3) >= 0))
    here, there = halfedge // 3, mate[halfedge] // 3
    closes = upside_down[here] ^ upside_down[there] ^ twisted[halfedge]
    halfedge = halfedge[closes]
    best = halfedge[np.argmin(depth[halfedge // 3] + depth[mate[halfedge] // 3])]
    crossed = [int(best)]
    a, b = int(best) // 3, int(mate[best]) // 3
    while a != b:
        if depth[a] < depth[b]:
            a, b = b, a
        crossed.append(int(parent[a]))
        a = int(mate[parent[a]]) // 3
    return np.array(crossed)


class _Storeys:
    """A graph of edges in two copies; some edges lead from one copy to the other."""

    def __init__(self, tail, head, length, changes, vertex_count):
        self.count = vertex_count
        change = np.where(changes, vertex_count, 0)
        below = np.stack([tail, head + change]), np.stack([head, tail + change])
        above = np.stack([tail + vertex_count, head + vertex_count - change])
        above = above, np.stack([head + vertex_count, tail + vertex_count - change])
        self.source, self.target = np.concatenate([*below, *above], axis=1)
        self.length = np.tile(length, 4)
        self.edges = len(tail)

    def shortest(self, start, end):
        """Length, and edges (n,) of the shortest path from a start (s,) to an end one storey up."""
        distance = np.full(2 * self.count, np.inf)
        through = np.full(2 * self.count, -1, np.int64)
        distance[start] = 0
        active = np.ones(len(self.source), bool)
        while active.any():
            arrow = np.flatnonzero(active)
            value = distance[self.source[arrow]] + self.length[arrow]
            better = value < distance[self.target[arrow]]
            arrow, value = arrow[better], value[better]
            order = np.argsort(-value, kind="stable")
            before = distance[self.target[arrow]]
            # Written in descending order, so that the least one stays.
            distance[self.target[arrow[order]]] = value[order]
            through[self.target[arrow[order]]] = arrow[order]
            fell = np.zeros(len(distance), bool)
            fell[self.target[arrow][distance[self.target[arrow]] < before]] = True
            active = fell[self.source]
        last = self.count + end[np.argmin(distance[self.count + end])]
        path, place = [], int(last)
        while through[place] >= 0:
            path.append(int(through[place]) % self.edges)
            place = int(self.source[through[place]])
        return float(distance[last]), np.unique(path)
