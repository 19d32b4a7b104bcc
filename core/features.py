"""Feature edges: sharp creases found by angle, and edges that the user marked.

A crease starts where two triangles meet at a large angle and is followed from its open ends, as
straight on as it goes, while the angle fades (hysteresis). Following from ends only, it never leaks
over the facets of a coarsely cut cylinder. Pieces that hardly stand out from the bends beside them
and short open pieces, both as scans have them, do not count. Masks of feature edges are (3F,) bool
over halfedges, true on both halfedges of an edge, never on the boundary. (method sections 2 and 8)
"""

from __future__ import annotations

import numpy as np

from .surface import TriangleSurface, connected_components, next_halfedge, previous_halfedge

# A crease goes on through a vertex within this angle of straight ahead.
_LARGEST_TURN = np.radians(60)
# A crease is so many times sharper than the surface bends beside it; ears of an animal are not.
_LEAST_CONTRAST = 8.0
# The same for all creases of a component against all its other edges: where everything bends, as
# on a coarse cage of an animal, sharp edges mean nothing.
_LEAST_MEAN_CONTRAST = 6.5
# Open pieces count from this share of the diameter on, or from a smaller one if made of many edges.
_OPEN_SHARE, _FINE_OPEN_SHARE, _FINE_OPEN_EDGES = 0.1, 0.03, 6
# Closed features narrower than this share of the diameter need so many edges to count: simple
# loops such as the rims of holes, and those with junctions, as spikes have them.
_CLOSED_SHARE, _LOOP_EDGES, _SPIKE_EDGES = 0.03, 12, 24
# Charts narrower than this share of the diameter are faults of the mesh, as folded needles.
_LEAST_WIDTH = 1e-3
# A crease that nears another one at less than this angle ends where they are this share of the
# diameter apart: between them no quad would have a good shape.
_CUSP_ANGLE, _CUSP_WIDTH = np.radians(20), 0.02


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
    _drop_faint(surface, crease, angle)
    _open_slivers(surface, crease)
    _trim_cusps(surface, crease, angle)
    _drop_crumpled(surface, crease, angle)
    _drop_short_ends(surface, crease)
    _drop_specks(surface, crease)
    return crease


def without_open_ends(surface: TriangleSurface, crease) -> np.ndarray:
    """(3F,) bool, the features left when every piece with an open end is taken away."""
    crease = crease.copy()
    while True:
        edge = surface.edges[crease[surface.edges]]
        chain, _ = _chains(surface, edge)
        ends = _open_ends(surface, crease)
        open_edge = np.isin(surface.tail[edge], ends) | np.isin(surface.head[edge], ends)
        if not open_edge.any():
            return crease
        gone = edge[np.isin(chain, chain[open_edge])]
        crease[gone] = crease[surface.twin[gone]] = False


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
    ends = _open_ends(surface, crease)
    while len(ends):
        came_from = np.full(surface.vertex_count, -1)
        marked = np.flatnonzero(crease)
        came_from[surface.tail[marked]] = marked
        open_end = np.zeros(surface.vertex_count, bool)
        open_end[ends] = True
        candidate = weak[open_end[surface.tail[weak]] & ~crease[weak]]
        back = came_from[surface.tail[candidate]]
        straight = -(_direction(surface, candidate) * _direction(surface, back)).sum(1)
        allowed = straight >= np.cos(_LARGEST_TURN)
        candidate, straight = candidate[allowed], straight[allowed]
        tail = surface.tail[candidate]
        order = np.lexsort((-angle[candidate] * straight, tail))
        chosen = candidate[order[np.diff(tail[order], prepend=-1) != 0]]
        crease[chosen] = crease[surface.twin[chosen]] = True
        ends = np.intersect1d(_open_ends(surface, crease), surface.head[chosen])


def _direction(surface, halfedge):
    step = surface.points[surface.head[halfedge]] - surface.points[surface.tail[halfedge]]
    return step / np.maximum(surface.edge_length[halfedge], 1e-300)[:, None]


def _open_ends(surface, crease):
    """(n,) int64, inner vertices where one crease edge ends."""
    degree = np.bincount(surface.tail[crease], minlength=surface.vertex_count)
    return np.flatnonzero((degree == 1) & ~surface.on_boundary)


def _drop_faint(surface, crease, angle):
    """Remove pieces that are not much sharper than the other edges of their triangles, in place."""
    edge = surface.edges[crease[surface.edges]]
    chain, _ = _chains(surface, edge)
    twin = surface.twin[edge]
    beside = np.stack(
        [next_halfedge(edge), previous_halfedge(edge), next_halfedge(twin), previous_halfedge(twin)]
    )
    bend = np.where(crease[beside], 0.0, angle[beside]).sum(0)
    plain = np.bincount(chain, (~crease[beside] & (surface.twin[beside] >= 0)).sum(0))
    sharp = np.bincount(chain, angle[edge]) / np.bincount(chain)
    faint = sharp * plain < _LEAST_CONTRAST * np.bincount(chain, bend)
    gone = edge[faint[chain]]
    crease[gone] = crease[surface.twin[gone]] = False


def _drop_crumpled(surface, crease, angle):
    """Remove all creases of components that bend nearly as much elsewhere, in place."""
    edge = surface.edges[surface.twin[surface.edges] >= 0]
    part, sharp = surface.component[edge // 3], crease[edge]
    weight = surface.edge_length[edge]
    bend = weight * angle[edge]

    def mean(chosen):
        length = np.bincount(part[chosen], weight[chosen], surface.component_count)
        total = np.bincount(part[chosen], bend[chosen], surface.component_count)
        return total / np.maximum(length, 1e-300)

    crumpled = mean(sharp) < _LEAST_MEAN_CONTRAST * mean(~sharp)
    crease &= ~np.repeat(crumpled[surface.component], 3)


def _drop_short_ends(surface, crease):
    """Remove short pieces with an open end, the shortest at each junction first, in place."""
    while True:
        edge = surface.edges[crease[surface.edges]]
        chain, through = _chains(surface, edge)
        length = np.bincount(chain, surface.edge_length[edge])
        count = np.bincount(chain)
        open_end = np.zeros(surface.vertex_count, bool)
        open_end[_open_ends(surface, crease)] = True
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


def _chains(surface, edge):
    """Number of the chain of each crease edge, and (V,) bool: a chain runs through the vertex."""
    ends = np.concatenate([surface.tail[edge], surface.head[edge]])
    degree = np.bincount(ends, minlength=surface.vertex_count)
    through = (degree == 2) & ~surface.on_boundary
    return _joined_at(ends, np.tile(np.arange(len(edge)), 2), through, len(edge)), through


def _joined_at(ends, number, joins, count):
    """Numbers of the groups of edges that meet at vertices where `joins` is true."""
    inner = np.flatnonzero(joins[ends])
    order = inner[np.argsort(ends[inner], kind="stable")]
    same = np.flatnonzero(np.diff(ends[order]) == 0)
    return connected_components(count, number[order[same]], number[order[same + 1]])


def _drop_specks(surface, crease):
    """Remove whole features that are tiny and made of few edges, in place."""
    edge = surface.edges[crease[surface.edges]]
    if not len(edge):
        return
    ends = np.concatenate([surface.tail[edge], surface.head[edge]])
    group = _joined_at(
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


def _trim_cusps(surface, crease, angle):
    """Shorten the fainter of two creases, or of crease and boundary, that meet at a small angle."""
    while True:
        cusps = _cusps(surface, crease)
        if not len(cusps[0]):
            return
        edge = surface.edges[crease[surface.edges]]
        chain = np.full(len(crease), -1)
        chain[edge] = chain[surface.twin[edge]] = _chains(surface, edge)[0]
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
