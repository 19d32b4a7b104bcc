"""Feature edges: sharp creases found by angle, and edges that the user marked.

A crease starts where two triangles meet at a large angle and is followed from its open ends, as
straight on as it goes, while the angle fades (hysteresis). Following from ends only, it never leaks
over the facets of a coarsely cut cylinder. Pieces that hardly stand out from the bends beside them
and short open pieces, both as scans have them, do not count. Masks of feature edges are (3F,) bool
over halfedges, true on both halfedges of an edge, never on the boundary. (method sections 2 and 8)
"""

from __future__ import annotations

import numpy as np

from ..surface.surface import TriangleSurface, connected_components
from .crease_chains import direction, find_chains, joined_at, open_ends
from .crease_contrast import drop_crumpled, drop_faint
from .crease_ends import drop_short_ends, give_ends_room, trim_cusps

# A crease goes on through a vertex within this angle of straight ahead.
_LARGEST_TURN = np.radians(60)
# Closed features narrower than this share of the diameter need so many edges to count: simple
# loops such as the rims of holes, and those with junctions, as spikes have them.
_CLOSED_SHARE, _LOOP_EDGES, _SPIKE_EDGES = 0.03, 12, 24
# Charts narrower than this share of the diameter are faults of the mesh, as folded needles.
_LEAST_WIDTH = 1e-3


def dihedral_angle(surface: TriangleSurface) -> np.ndarray:
    """(3F,) float64, radians between the normals on both sides; 0 where flat and on the boundary."""
    here = np.arange(len(surface.twin))
    there = np.where(surface.twin >= 0, surface.twin, here)
    a, b = surface.face_normal[here // 3], surface.face_normal[there // 3]
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(1))


def detect_features(
    surface: TriangleSurface, start_angle: float, follow_angle: float
) -> np.ndarray:
    """Creases by angle with hysteresis: (3F,) bool.

    start_angle   radians between normals from which an edge is a crease by itself
    follow_angle  radians down to which a crease is followed from its ends
    """
    angle = dihedral_angle(surface)
    crease = angle >= start_angle
    if not crease.any():
        return crease
    _follow(surface, crease, angle, follow_angle)
    drop_faint(surface, crease, angle)
    _open_slivers(surface, crease)
    trim_cusps(surface, crease, angle)
    drop_crumpled(surface, crease, angle)
    drop_short_ends(surface, crease)
    give_ends_room(surface, crease, angle)
    drop_short_ends(surface, crease)
    _drop_specks(surface, crease)
    return crease


def without_open_ends(surface: TriangleSurface, crease) -> np.ndarray:
    """(3F,) bool, the features left when every piece with an open end is taken away."""
    crease = crease.copy()
    while True:
        edge = surface.edges[crease[surface.edges]]
        chain, _ = find_chains(surface, edge)
        ends = open_ends(surface, crease)
        open_edge = np.isin(surface.tail[edge], ends) | np.isin(surface.head[edge], ends)
        if not open_edge.any():
            return crease
        gone = edge[np.isin(chain, chain[open_edge])]
        crease[gone] = crease[surface.twin[gone]] = False


def without_chains_near(surface: TriangleSurface, crease, points, distance, kept) -> np.ndarray:
    """(3F,) bool, the features left when pieces that come near some points are taken away.

    points    (n, 3) float64; distance (n,) float64, how near to each, to the middle of an edge
    kept      (3F,) bool, feature edges that stay
    """
    edge = surface.edges[(crease & ~kept)[surface.edges]]
    chain, _ = find_chains(surface, edge)
    middle = 0.5 * (surface.points[surface.tail[edge]] + surface.points[surface.head[edge]])
    reach = distance + 0.5 * surface.edge_length[edge][:, None]
    near = (np.linalg.norm(middle[:, None] - points, axis=2) < reach).any(1)
    gone = edge[np.isin(chain, chain[near])]
    crease = crease.copy()
    crease[gone] = crease[surface.twin[gone]] = False
    return crease


def marked_features(surface: TriangleSurface, vertex_origin, pairs) -> np.ndarray:
    """Edges that the user marked: (3F,) bool.

    vertex_origin  (V,) int, the user's vertex of each vertex of the surface
    pairs          (n, 2) int, the user's vertices at the ends of marked edges, in either order;
                   pairs that are no inner edges of the surface are ignored
    """
    pairs = np.sort(np.asarray(pairs, np.int64).reshape(-1, 2), axis=1)
    ends = np.stack([vertex_origin[surface.tail], vertex_origin[surface.head]], axis=1)
    ends = np.sort(ends, axis=1).astype(np.int64)
    span = np.int64(max(ends.max(initial=0), pairs.max(initial=0)) + 1)
    return np.isin(ends @ [span, 1], pairs @ [span, 1]) & (surface.twin >= 0)


def _follow(surface, crease, angle, follow_angle):
    """Extend the open ends of creases along weaker edges, all ends at once, in place."""
    weak = np.flatnonzero(angle >= follow_angle)
    ends = open_ends(surface, crease)
    while len(ends):
        came_from = np.full(surface.vertex_count, -1)
        marked = np.flatnonzero(crease)
        came_from[surface.tail[marked]] = marked
        open_end = np.zeros(surface.vertex_count, bool)
        open_end[ends] = True
        candidate = weak[open_end[surface.tail[weak]] & ~crease[weak]]
        back = came_from[surface.tail[candidate]]
        straight = -(direction(surface, candidate) * direction(surface, back)).sum(1)
        allowed = straight >= np.cos(_LARGEST_TURN)
        candidate, straight = candidate[allowed], straight[allowed]
        tail = surface.tail[candidate]
        order = np.lexsort((-angle[candidate] * straight, tail))
        chosen = candidate[order[np.diff(tail[order], prepend=-1) != 0]]
        crease[chosen] = crease[surface.twin[chosen]] = True
        ends = np.intersect1d(open_ends(surface, crease), surface.head[chosen])


def _drop_specks(surface, crease):
    """Remove whole features that are tiny and made of few edges, in place."""
    edge = surface.edges[crease[surface.edges]]
    if not len(edge):
        return
    ends = np.concatenate([surface.tail[edge], surface.head[edge]])
    group = joined_at(
        ends, np.tile(np.arange(len(edge)), 2), np.ones(surface.vertex_count, bool), len(edge)
    )
    count = np.bincount(group)
    low = np.full((len(count), 3), np.inf)
    high = -low
    np.minimum.at(low, np.tile(group, 2), surface.points[ends])
    np.maximum.at(high, np.tile(group, 2), surface.points[ends])
    size = np.linalg.norm(high - low, axis=1)
    least = np.full(len(count), _LOOP_EDGES)
    degree = np.bincount(ends, minlength=surface.vertex_count)
    least[group[(degree[ends] > 2).reshape(2, -1).any(0)]] = _SPIKE_EDGES
    speck = (size < _CLOSED_SHARE * surface.diameter) & (count < least)
    gone = edge[speck[group]]
    crease[gone] = crease[surface.twin[gone]] = False


def _open_slivers(surface, crease):
    """Join very narrow charts to the neighbours that they share most of their outline with."""
    while True:
        inner = np.flatnonzero((surface.twin >= 0) & ~crease)
        chart = connected_components(surface.face_count, inner // 3, surface.twin[inner] // 3)
        outline = np.flatnonzero((surface.twin < 0) | crease)
        around = np.bincount(chart[outline // 3], surface.edge_length[outline], chart.max() + 1)
        area = np.bincount(chart, surface.face_area)
        sliver = 2 * area < _LEAST_WIDTH * surface.diameter * around
        cut = np.flatnonzero(crease)
        here, there = chart[cut // 3], chart[surface.twin[cut] // 3]
        keep = sliver[here] & (here != there)
        if not keep.any():
            return
        cut, here, there = cut[keep], here[keep], there[keep]
        pair, member = np.unique(here * np.int64(len(area)) + there, return_inverse=True)
        shared = np.bincount(member.ravel(), surface.edge_length[cut])
        owner = pair // len(area)
        order = np.lexsort((-shared, owner))
        longest = order[np.diff(owner[order], prepend=-1) != 0]
        gone = cut[np.isin(member.ravel(), longest)]
        crease[gone] = crease[surface.twin[gone]] = False
