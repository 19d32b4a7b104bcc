"""Separatrices of a quad mesh: the ports from which lines must or may run, and where these end.

A line between two cells starts at an irregular vertex or at a corner of the boundary or of a
feature line that more than two quads meet at. From an irregular vertex inside, a line leaves along
every edge. At a corner of n quads, lines leave so that at most two quads lie between one and the
next: two are a straight side, one is a corner of a cell.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..quads.quad_connectivity import QuadConnectivity, next_side, previous_side
from .cutting import to_the_end


@dataclass(frozen=True)
class Sectors:
    """The quads round each vertex, parted by fixed edges. Arrays of halfedges, by their tails.

    first  (4 Q,) int64, the halfedge that begins the sector, clockwise; the sector's name
    place  (4 Q,) int64, quads between the beginning of the sector and the halfedge
    size   (4 Q,) int64, quads in the sector
    round  (4 Q,) bool, no fixed edge at the vertex; first and place mean nothing then
    """

    first: np.ndarray
    place: np.ndarray
    size: np.ndarray
    round: np.ndarray


@dataclass(frozen=True)
class Separatrices:
    """Where lines between cells leave and run.

    stop      (P,) bool, vertices where every line ends: irregular or on a fixed edge
    must      (4 Q,) bool, halfedges along which a line has to leave
    may       (4 Q,) bool, halfedges of a smallest choice of lines at a corner
    line      (E,) int64, the line that each edge lies on; -1 on fixed edges and closed lines
    joins     (lines,) bool, does a line join two ports that must or may be taken?
    """

    stop: np.ndarray
    must: np.ndarray
    may: np.ndarray
    line: np.ndarray
    joins: np.ndarray


def find_sectors(mesh: QuadConnectivity, fixed) -> Sectors:
    """The sectors of a quad mesh; fixed (E,) bool, with all edges of the boundary."""
    halfedge = np.arange(len(mesh.tail))
    clockwise = np.where(fixed[mesh.edge], halfedge, next_side(mesh.twin))
    first, place = to_the_end(clockwise)
    on_fixed = np.zeros(mesh.vertex_count, bool)
    on_fixed[mesh.edge_vertex[fixed]] = True
    round_ = ~on_fixed[mesh.tail]
    size = np.bincount(first[~round_], minlength=len(halfedge))[first]
    return Sectors(first, place, np.where(round_, mesh.face_count[mesh.tail], size), round_)


def find_separatrices(mesh: QuadConnectivity, fixed, sectors: Sectors) -> Separatrices:
    """Ports and the lines from them; fixed (E,) bool, with all edges of the boundary."""
    stop = mesh.irregular.copy()
    stop[mesh.edge_vertex[fixed]] = True
    free = ~fixed[mesh.edge]
    must = free & sectors.round & mesh.irregular[mesh.tail]
    may = free & ~sectors.round & (sectors.size > 2)
    # An even number of quads leaves only one smallest choice: every second edge.
    may &= (sectors.size % 2 == 1) | (sectors.place % 2 == 0)
    halfedge = np.arange(len(mesh.tail))
    onward = np.where(stop[mesh.head], halfedge, mesh.straight)
    last, _ = to_the_end(onward)
    ended = free & (onward[last] == last)
    line = np.full(mesh.edge_count, -1)
    here = np.flatnonzero(ended)
    _, number = np.unique(
        np.minimum(last[here], last[mesh.twin[here]]), return_inverse=True
    )
    line[mesh.edge[here]] = number
    ends = np.bincount(line[mesh.edge[must | may]], minlength=int(line.max(initial=-1)) + 1)
    return Separatrices(stop, must, may, line, ends == 2)


def conflicts(mesh: QuadConnectivity, sectors: Sectors, lines: Separatrices) -> np.ndarray:
    """(n, 2) int64, pairs of joining lines of which keeping both saves no cell.

    They cross (a line may cross itself), or no smallest choice of lines at a corner has both.
    """
    joining = np.full(mesh.edge_count, -1)
    on_line = lines.line >= 0
    joining[on_line] = np.where(lines.joins[lines.line[on_line]], lines.line[on_line], -1)
    before = mesh.edge[previous_side(np.arange(len(mesh.tail)))]
    inside = np.flatnonzero(~lines.stop[mesh.tail])
    pairs = [np.stack([joining[mesh.edge[inside]], joining[before[inside]]], 1)]
    # An odd place before an even one leaves an odd number of quads between, and so before and after.
    port = np.flatnonzero(lines.may & (sectors.place % 2 == 1))
    ahead = port
    while len(port):
        ahead = mesh.twin[previous_side(ahead)]
        within = (ahead >= 0) & lines.may[ahead]
        port, ahead = port[within], ahead[within]
        even = sectors.place[ahead] % 2 == 0
        pairs.append(np.stack([joining[mesh.edge[port[even]]], joining[mesh.edge[ahead[even]]]], 1))
    pairs = np.concatenate(pairs)
    return np.unique(np.sort(pairs[(pairs >= 0).all(1)], axis=1), axis=0)
