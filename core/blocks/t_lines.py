"""The motorcycle graph of a quad mesh: the fewest lines that cut it into four-sided cells.

Every line that ends on another one costs half a cell, every crossing a whole one. So lines that
join two vertices from which lines must run come first, as many as do not cross; the others race
from their ports and stop where they meet a track; corners take as few lines as they can, short
ones. (Eppstein, Goodrich, Kim, Tamstorf: Motorcycle graphs, 2008; the choice of joining lines is
that of the smallest partition of a rectilinear polygon into rectangles)
"""

from __future__ import annotations

from heapq import heapify, heappop, heappush

import numpy as np

from ..algebra.independent_set import independent_set
from ..quads.quad_connectivity import QuadConnectivity, previous_side
from ..surface.surface import connected_components
from .cutting import to_the_end
from .separatrices import Sectors, conflicts, find_sectors, find_separatrices


def t_lines(mesh: QuadConnectivity, fixed, length, longest=np.inf) -> np.ndarray:
    """(E,) bool, edges that part the mesh into four-sided cells with T-junctions, few of them.

    fixed   (E,) bool, inner edges that no cell may straddle; those of the boundary are in any case
    length  (E,) float64, lengths of the edges
    longest (E,) float64 or float, of the lines through the edges that are laid to join two vertices

    A part without irregular vertices and corners that closes up into a ring is cut once across.
    """
    fixed = fixed.copy()
    fixed[mesh.edge[mesh.boundary]] = True
    sectors = find_sectors(mesh, fixed)
    lines = find_separatrices(mesh, fixed, sectors)
    on_line = lines.line >= 0
    extent = np.bincount(lines.line[on_line], length[on_line], len(lines.joins))
    limit = np.full(len(extent), np.inf)
    limit[lines.line[on_line]] = np.broadcast_to(longest, on_line.shape)[on_line]
    wanted = lines.joins & (extent <= limit)
    chosen = independent_set(wanted, conflicts(mesh, sectors, lines), extent)
    kept = fixed
    kept[on_line] |= chosen[lines.line[on_line]]
    tracks = _Tracks(mesh, kept, lines.stop, length)
    tracks.race(np.flatnonzero(lines.must & ~kept[mesh.edge]))
    _complete_corners(tracks, sectors)
    _open_rings(tracks)
    return tracks.kept


class _Tracks:
    """Tracks that grow along straight mesh lines until they meet one another.

    kept      (E,) bool, edges on tracks, fixed ones included
    occupied  (P,) bool, vertices where a new track ends
    """

    def __init__(self, mesh: QuadConnectivity, kept, stop, length):
        self.mesh, self.kept, self.length = mesh, kept, length
        self.occupied = stop.copy()
        self.occupied[mesh.edge_vertex[kept]] = True

    def race(self, ports):
        """Tracks from all ports at equal speed, each until it meets another."""
        mesh = self.mesh
        running = [(float(self.length[mesh.edge[port]]), int(port)) for port in ports]
        heapify(running)
        while running:
            time, halfedge = heappop(running)
            self.kept[mesh.edge[halfedge]] = True
            if not self.occupied[mesh.head[halfedge]]:
                self.occupied[mesh.head[halfedge]] = True
                onward = int(mesh.straight[halfedge])
                heappush(running, (time + float(self.length[mesh.edge[onward]]), onward))

    def path(self, port) -> list:
        """Halfedges from a port to the first occupied vertex."""
        result = [int(port)]
        while not self.occupied[self.mesh.head[result[-1]]]:
            result.append(int(self.mesh.straight[result[-1]]))
        return result

    def lay(self, halfedges):
        """Keep a path."""
        self.kept[self.mesh.edge[halfedges]] = True
        self.occupied[self.mesh.head[halfedges]] = True

    def distance(self, ports) -> float:
        return sum(float(self.length[self.mesh.edge[self.path(port)]].sum()) for port in ports)


def _complete_corners(tracks: _Tracks, sectors: Sectors):
    """Lines from corners until at most two quads lie between one and the next; short ones first."""
    wide = np.flatnonzero(~sectors.round & (sectors.size > 2) & (sectors.place == 0))
    waiting = []
    for first in wide.tolist():
        ports = _best_ports(tracks, first, int(sectors.size[first]))
        if ports:
            waiting.append((tracks.distance(ports), first))
    for _, first in sorted(waiting):
        for port in _best_ports(tracks, first, int(sectors.size[first])):
            if not tracks.kept[tracks.mesh.edge[port]]:
                tracks.lay(tracks.path(port))


def _best_ports(tracks: _Tracks, first, size) -> list:
    """Halfedges along which lines are missing at a corner, the shortest of all smallest choices."""
    mesh, around = tracks.mesh, [first]
    while len(around) < size:
        around.append(int(mesh.twin[previous_side(around[-1])]))
    taken = [k for k in range(size) if tracks.kept[mesh.edge[around[k]]]]
    result = []
    for low, high in zip(taken, [*taken[1:], size]):
        choices = [[around[k] for k in choice] for choice in _smallest_choices(low, high)]
        result += min(choices, key=tracks.distance)
    return result


def _smallest_choices(low, high):
    """Places between two lines so that steps of 2, and 1 once if needed, lead from low to high."""
    if (high - low) % 2 == 0:
        return [list(range(low + 2, high, 2))]
    return [
        [*range(low + 2, single + 1, 2), *range(single + 1, high, 2)]
        for single in range(low, high, 2)
    ]


def _open_rings(tracks: _Tracks):
    """Cut parts without corners: a torus along its shortest line, then every ring across."""
    mesh = tracks.mesh
    inner = np.flatnonzero(mesh.twin >= 0)
    inner = inner[~tracks.kept[mesh.edge[inner]]]
    part = connected_components(len(mesh.quad), inner // 4, mesh.twin[inner] // 4)
    side = tracks.kept[mesh.edge]
    corner = side & side[previous_side(np.arange(len(side)))]
    bare = np.bincount(part, side.reshape(-1, 4).sum(1)) == 0
    for number in np.flatnonzero(bare):
        tracks.lay(_shortest_loop(tracks, np.flatnonzero(np.repeat(part == number, 4))))
    for number in np.flatnonzero(np.bincount(part, corner.reshape(-1, 4).sum(1)) == 0):
        tracks.lay(_shortest_cut(tracks, np.flatnonzero(np.repeat(part == number, 4))))


def _shortest_loop(tracks: _Tracks, halfedges):
    """Halfedges of the shortest closed line of a torus."""
    mesh = tracks.mesh
    loop = connected_components(len(mesh.tail), halfedges, mesh.straight[halfedges])
    extent = np.bincount(loop[halfedges], tracks.length[mesh.edge[halfedges]], len(mesh.tail))
    used = np.unique(loop[halfedges])
    return halfedges[loop[halfedges] == used[extent[used].argmin()]]


def _shortest_cut(tracks: _Tracks, halfedges):
    """Halfedges of a line across a ring: between junctions that are there, then the shortest."""
    mesh = tracks.mesh
    onward = np.arange(len(mesh.tail))
    going = halfedges[~tracks.occupied[mesh.head[halfedges]]]
    onward[going] = mesh.straight[going]
    last, _ = to_the_end(onward)
    side = tracks.kept[mesh.edge]
    port = halfedges[~side[halfedges] & side[previous_side(halfedges)]]
    ends = np.bincount(mesh.edge_vertex[tracks.kept].ravel(), minlength=mesh.vertex_count)
    free = halfedges[~side[halfedges]]
    extent = np.bincount(last[free], tracks.length[mesh.edge[free]], len(mesh.tail))[last[port]]
    fresh = (ends[mesh.tail[port]] < 3).astype(int) + (ends[mesh.head[last[port]]] < 3)
    return np.array(tracks.path(port[np.lexsort([port, extent, fresh])[0]]))
