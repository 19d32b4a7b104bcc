"""Which triangles hold together at an edge, and the cut along the edges where they do not.

Triangles are glued by *mates*: halfedge 3 f + c runs from corner c of triangle f to the next one,
and its mate is the halfedge of the other triangle at that edge, in whatever direction it runs.
Where an edge has more than two triangles they are glued two by two, and the pairs are cut apart;
so are fans of triangles that touch in one vertex only.
"""

from __future__ import annotations

import numpy as np

from ..surface.projection import expand_ranges, first_smallest
from ..surface.surface import connected_components, next_halfedge, previous_halfedge

_MOST_AT_AN_EDGE = 32  # of more triangles at one edge none are glued
_SAME_POLYGON = -100.0  # costs of gluing two triangles, in radians of bending
_AGAINST_ORIENTATION = 10.0
_OUTSIDE_OF_SOLID = 5.0


def edge_keys(triangles: np.ndarray, vertex_count: int) -> np.ndarray:
    """(3F,) int64, one number for each undirected edge."""
    tail, head = triangles.ravel(), triangles[:, [1, 2, 0]].ravel()
    return np.minimum(tail, head) * np.int64(vertex_count) + np.maximum(tail, head)


def crowded_halfedges(triangles: np.ndarray, vertex_count: int) -> np.ndarray:
    """(3F,) bool, halfedges of edges with more than two triangles."""
    _, inverse, count = np.unique(
        edge_keys(triangles, vertex_count), return_inverse=True, return_counts=True
    )
    return (count > 2)[inverse.ravel()]


def glue(points: np.ndarray, triangles: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """(3F,) int64, the mate of each halfedge, -1 where there is none.

    points     (V, 3) float64 in a box of size 1
    triangles  (F, 3) int64, three distinct vertices each, in any orientation
    polygon    (F,) int64; triangles of one polygon stay together

    At an edge of several triangles: first those that agree on their orientation and, between
    solids that touch, lie round the same solid; of sheets the pair that bends least.
    """
    key = edge_keys(triangles, len(points))
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.concatenate([[True], key[order[1:]] != key[order[:-1]]]))
    count = np.diff(np.append(first, len(order)))
    mate = np.full(len(key), -1, np.int64)
    plain = first[count == 2]
    _join(mate, order[plain], order[plain + 1])
    crowded = (count > 2) & (count <= _MOST_AT_AN_EDGE)
    if crowded.any():
        edge, place = expand_ranges(first[crowded], (first + count)[crowded])
        _glue_crowded(mate, points, triangles, polygon, order[place], edge)
    return mate


def _join(mate, one, two):
    mate[one], mate[two] = two, one


def _glue_crowded(mate, points, triangles, polygon, halfedge, edge):
    """Glue the given halfedges, sorted by edge, two by two, the cheapest pairs first."""
    rank = np.arange(len(edge)) - np.searchsorted(edge, edge)
    direction, angle = _round_the_edge(points, triangles, halfedge, edge)
    one, two = expand_ranges(np.arange(len(edge)) + 1, np.searchsorted(edge, edge, side="right"))
    cost = _pair_costs(direction, angle, edge, one, two)
    cost += np.where(polygon[halfedge[one] // 3] == polygon[halfedge[two] // 3], _SAME_POLYGON, 0)
    sheet = _sheets(mate, len(triangles))[halfedge // 3]
    cost += 1e-6 * (rank[one] + rank[two]) / _MOST_AT_AN_EDGE  # decides between equals
    cost = _alike_along_sheets(cost, sheet[one], sheet[two])
    free = np.ones(len(edge), bool)
    while len(one):
        best = first_smallest(edge[one], cost)
        _join(mate, halfedge[one[best]], halfedge[two[best]])
        free[one[best]] = free[two[best]] = False
        left = free[one] & free[two]
        one, two, cost = one[left], two[left], cost[left]


def _round_the_edge(points, triangles, halfedge, edge):
    """Direction (n,) bool and angle (n,) round the edge of the triangle at each halfedge.

    Angles are counted from the first triangle of the edge, counter-clockwise seen against the
    direction from the smaller to the larger end.
    """
    flat = triangles.ravel()
    tail, head = flat[halfedge], flat[next_halfedge(halfedge)]
    apex = points[flat[previous_halfedge(halfedge)]]
    low, high = np.minimum(tail, head), np.maximum(tail, head)
    axis = points[high] - points[low]
    axis /= np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), 1e-300)
    out = apex - points[low]
    out -= (out * axis).sum(1, keepdims=True) * axis
    reference = out[np.searchsorted(edge, edge)]
    angle = np.arctan2((np.cross(reference, out) * axis).sum(1), (reference * out).sum(1))
    return tail < head, np.mod(angle, 2 * np.pi)


def _pair_costs(direction, angle, edge, one, two):
    """Radians that each pair of triangles bends by, with the extra costs."""
    bend = np.abs(np.pi - np.abs(angle[one] - angle[two]))
    order = np.lexsort((angle, edge))
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order)) - np.searchsorted(edge, edge)
    count = np.bincount(edge)[edge]
    # Where orientations alternate round the edge, it lies between solids, whose insides are
    # behind the triangles: clockwise of one that runs from the smaller to the larger end.
    expected = (place + direction) % 2
    start = np.searchsorted(edge, edge)
    solid = np.bincount(edge, expected != expected[start], len(edge))[edge] == 0
    solid &= count % 2 == 0
    step = np.mod(place[two] - place[one], count[one])
    inward = np.where(direction[one], (step == count[one] - 1), step == 1)
    cost = np.where(solid[one], np.where(inward, 0.0, _OUTSIDE_OF_SOLID), bend)
    return cost + _AGAINST_ORIENTATION * (direction[one] == direction[two])


def _sheets(mate, face_count):
    """(F,) int64, number of the piece of surface between crowded edges that each triangle is in."""
    glued = np.flatnonzero(mate >= 0)
    return connected_components(face_count, glued // 3, mate[glued] // 3)


def _alike_along_sheets(cost, one, two):
    """The mean cost over all edges where the same two sheets meet, so that these pair alike."""
    low, high = np.minimum(one, two), np.maximum(one, two)
    _, inverse = np.unique(np.stack([low, high]), axis=1, return_inverse=True)
    inverse = inverse.ravel()
    mean = np.bincount(inverse, cost) / np.bincount(inverse)
    return np.where(low == high, cost, mean[inverse])


def fan_of_corner(triangles: np.ndarray, mate: np.ndarray) -> np.ndarray:
    """(3F,) int64, number of the fan of glued triangles round its vertex that a corner is in.

    Numbers count up in the order of the smallest corners. Mates may run in either direction.
    """
    halfedge = np.flatnonzero(mate >= 0)
    return _fans(triangles, halfedge, mate[halfedge])


def _fans(triangles, halfedge, other):
    vertex = triangles.ravel()
    same = vertex[other] == vertex[halfedge]
    beyond = next_halfedge(other)
    start, end = np.where(same, other, beyond), np.where(same, beyond, other)
    return connected_components(
        len(vertex),
        np.concatenate([halfedge, next_halfedge(halfedge)]),
        np.concatenate([start, end]),
    )


def find_touching(triangles: np.ndarray, vertex_count: int) -> np.ndarray:
    """Vertices (n,) in which triangles touch that are not joined there over any edges."""
    key = edge_keys(triangles, vertex_count)
    order = np.argsort(key, kind="stable")
    pair = np.flatnonzero(key[order[1:]] == key[order[:-1]])
    fan = _fans(triangles, order[pair], order[pair + 1])
    vertex = np.zeros(int(fan.max(initial=-1)) + 1, np.int64)
    vertex[fan] = triangles.ravel()
    return np.flatnonzero(np.bincount(vertex) > 1)


def split_fans(triangles: np.ndarray, mate: np.ndarray) -> np.ndarray:
    """(3F,) int64, a number for each corner: equal where fans of glued triangles share a vertex.

    triangles  (F, 3) int64, and mate (3F,): glued triangles run along their edge in opposite
               directions; mates that no manifold allows are undone in place

    Numbers count up in the order of the vertices, and of the corners at one vertex; they are
    those of the vertices, without gaps, where nothing has to be split.
    """
    while True:
        fan = fan_of_corner(triangles, mate)
        vertex = np.empty(int(fan.max(initial=-1)) + 1, np.int64)
        vertex[fan] = triangles.ravel()
        order = np.argsort(vertex, kind="stable")
        rank = np.empty_like(order)
        rank[order] = np.arange(len(order))
        corner = rank[fan]
        repeated = _repeated_halfedges(corner)
        if not len(repeated):
            return corner
        # Of two edges with the same ends one gets an end of its own.
        around = previous_halfedge(repeated)
        beyond = mate[repeated]
        around = np.concatenate([around, next_halfedge(beyond[beyond >= 0])])
        around = around[mate[around] >= 0]
        mate[mate[around]] = -1
        mate[around] = -1


def _repeated_halfedges(corner):
    """Halfedges (n,) with the same ends, in order, as one before."""
    key = corner * np.int64(len(corner)) + corner[next_halfedge(np.arange(len(corner)))]
    order = np.argsort(key, kind="stable")
    return order[1:][key[order[1:]] == key[order[:-1]]]


def find_bow_ties(triangles: np.ndarray, mate: np.ndarray) -> np.ndarray:
    """Vertices (n,) where fans of triangles touch that share no edge there.

    triangles  (F, 3) int64; mate (3F,) runs along the edge in the opposite direction
    """
    tail = triangles.ravel()
    vertex_count = int(tail.max(initial=-1)) + 1
    degree = np.bincount(tail, minlength=vertex_count)
    start = np.full(vertex_count, -1, np.int64)
    start[tail] = np.arange(len(tail))
    boundary = np.flatnonzero(mate < 0)
    start[tail[boundary]] = boundary
    reached = np.zeros(vertex_count, np.int64)
    vertex = np.flatnonzero(degree)
    current = start[vertex]
    while len(vertex):
        reached[vertex] += 1
        current = mate[previous_halfedge(current)]
        on = (current >= 0) & (current != start[vertex])
        vertex, current = vertex[on], current[on]
    return np.flatnonzero(reached < degree)
