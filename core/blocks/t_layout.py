"""The T-layout: blocks that meet at T-junctions, the fewest that a quad mesh can be divided into.

The quad mesh stays what it is, conforming; only the blocks do not conform: the corner of one may
lie inside the side of another. Every block is a structured grid; across every piece of a side the
nodes of both blocks coincide. A ring without corners is one block that closes upon itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import LayoutError
from ..quads.quad_connectivity import QuadConnectivity, connect_quads
from ..quads.quads import grid_quads
from ..surface.surface import connected_components
from .blocks import Blocks
from .cutting import (
    Chains,
    Grids,
    cut_corners,
    edges_between,
    find_chains,
    find_grids,
    turned,
)
from .t_lines import t_lines

# Lines longer than so many diagonals of the bounding box wind round: blocks between would be strips.
WINDING = 2.5


@dataclass(frozen=True)
class TLayout:
    """Blocks with T-junctions. Build it with `build_t_layout`.

    quad_block, shape, grid_offset, grid_vertex, corner   as in Blocks; corners may coincide where
                 a block closes upon itself
    edge_offset  (E + 1,) int64; edge e, a piece of a side between two junctions, is the chain
    edge_vertex  edge_vertex[edge_offset[e]:edge_offset[e + 1]], both ends included
    edge_on_boundary (E,) bool
    side_offset  (4 B + 1,) int64; side s = 4 * block + k, k = 0 from corner 0 to corner 1, then
                 1-2, 2-3, 3-0, counter-clockwise
    side_edge    side_edge[side_offset[s]:side_offset[s + 1]], the edges along a side in order
    side_start   int64, node of the side, 0 at its first corner, at which each of these edges begins
    side_forward bool, does a side run in the direction its edge is stored in?
    """

    quad_block: np.ndarray
    shape: np.ndarray
    grid_offset: np.ndarray
    grid_vertex: np.ndarray
    corner: np.ndarray
    edge_offset: np.ndarray
    edge_vertex: np.ndarray
    edge_on_boundary: np.ndarray
    side_offset: np.ndarray
    side_edge: np.ndarray
    side_start: np.ndarray
    side_forward: np.ndarray

    @property
    def count(self) -> int:
        return len(self.shape)

    @property
    def junction_count(self) -> int:
        """T-junctions: places where a corner of a block lies inside a side of a block."""
        later = np.ones(len(self.side_edge), bool)
        later[self.side_offset[:-1]] = False
        edge, forward = self.side_edge[later], self.side_forward[later]
        start = np.where(forward, self.edge_offset[edge], self.edge_offset[edge + 1] - 1)
        return int(np.isin(self.edge_vertex[start], self.corner).sum())


def find_t_edges(points, blocks: Blocks, crease=()) -> np.ndarray:
    """(E,) bool, edges of conforming blocks to keep: those between the blocks of the T-layout.

    points  (P, 3) float64
    blocks  Blocks, the base complex of the quad mesh: all lines between T-blocks are block edges
    crease  (n, 2) int, end vertices of inner edges that no block may straddle; lines of them end
            at block corners

    Every irregular vertex inside is a corner of all blocks round it; elsewhere one quad at a vertex
    makes a corner of a block and two a straight side. Lines that join two such vertices but wind
    round the surface on their way are not taken for that: the fewest blocks would be long strips.
    """
    vertex, corner = np.unique(blocks.corner, return_inverse=True)
    mesh = connect_quads(corner.reshape(-1, 4), len(vertex))
    number = np.empty(mesh.edge_count, np.int64)
    number[mesh.edge] = blocks.block_edge.ravel()
    first, step = _edge_steps(blocks)
    size = np.linalg.norm(points[step[:, 1]] - points[step[:, 0]], axis=1)
    length = np.bincount(first, size, len(number))
    feature = np.zeros(len(number), bool)
    feature[first[_among(step, crease, len(points))]] = True
    kept = np.zeros(len(number), bool)
    part = connected_components(len(vertex), *mesh.edge_vertex.T)
    longest = WINDING * _diagonals(points, blocks, part[mesh.quad[:, 0]])
    longest = longest[part[mesh.edge_vertex[:, 0]]]
    kept[number] = t_lines(mesh, feature[number], length[number], longest)
    return kept


def _diagonals(points, blocks: Blocks, part) -> np.ndarray:
    """(parts,) float64, diagonals of the bounding boxes of the parts; part (B,) of each block."""
    owner = np.repeat(part, np.diff(blocks.grid_offset))
    low = np.full((int(part.max()) + 1, points.shape[1]), np.inf)
    high = -low
    np.minimum.at(low, owner, points[blocks.grid_vertex])
    np.maximum.at(high, owner, points[blocks.grid_vertex])
    return np.linalg.norm(high - low, axis=1)


def build_t_layout(quad, blocks: Blocks, kept) -> TLayout:
    """The T-layout between some edges of conforming blocks.

    quad    (Q, 4) int64, the quads of the blocks, with any divisions
    kept    (E,) bool, as from `find_t_edges`

    Raises LayoutError where a part between them is no grid.
    """
    mesh = connect_quads(quad, int(np.max(quad)) + 1)
    first, step = _edge_steps(blocks)
    cut = edges_between(mesh, step[kept[first]])
    ends = np.bincount(mesh.edge_vertex[cut].ravel(), minlength=mesh.vertex_count)
    chains = find_chains(mesh, mesh.straight, cut, cut_corners(mesh, cut) | (ends > 2))
    grids = find_grids(mesh, cut)
    on_boundary = np.zeros(len(chains.offset) - 1, bool)
    on_boundary[chains.chain[mesh.edge[mesh.boundary]]] = True
    return TLayout(
        grids.quad_block, grids.shape, grids.offset, grids.vertex, grids.corner, chains.offset,
        chains.vertex, on_boundary, *_sides(mesh, grids, chains),
    )


def conforming_edges(layout: TLayout, blocks: Blocks, kept) -> list:
    """List of E: for each edge of the T-layout the conforming block edges along it, in its order.

    blocks, kept  those that the layout was built from
    """
    number, step = _edge_steps(layout)
    edge = np.flatnonzero(kept)
    start = blocks.edge_offset[edge]
    first = np.stack([blocks.edge_vertex[start], blocks.edge_vertex[start + 1]], axis=1)
    span = np.array([int(blocks.edge_vertex.max()) + 1, 1])
    key = np.sort(step, axis=1) @ span
    order = np.argsort(key)
    place = order[np.searchsorted(key[order], np.sort(first, axis=1) @ span)]
    along = np.argsort(place)
    owner = number[place[along]]
    ends = np.searchsorted(owner, np.arange(1, len(layout.edge_on_boundary)))
    return [some.tolist() for some in np.split(edge[along], ends)]


def verify_t_layout(layout: TLayout, quad, crease=()):
    """Test what a T-layout promises.

    quad    (Q, 4) int64, the quads that it was made of
    crease  (n, 2) int, end vertices of inner edges that no block may straddle

    The grids of the blocks are the quads, each once; their borders are their edges, node by node,
    each with one side (boundary) or two, in opposite directions; junctions lie at the ends of
    edges; irregular vertices inside are corners of all blocks round them; feature edges lie on
    edges. Raises LayoutError.
    """
    filled, owner = grid_quads(layout.shape, layout.grid_offset, layout.grid_vertex)
    rows = np.column_stack([np.sort(filled, axis=1), owner])
    wanted = np.column_stack([np.sort(quad, axis=1), layout.quad_block])
    _demand(
        rows.shape == wanted.shape
        and np.array_equal(rows[np.lexsort(rows.T)], wanted[np.lexsort(wanted.T)]),
        "the grids of the blocks are not the quads",
    )
    _verify_sides(layout)
    inner = np.ones(len(layout.edge_vertex), bool)
    inner[layout.edge_offset[:-1]] = inner[layout.edge_offset[1:] - 1] = False
    touched = np.isin(layout.edge_vertex[inner], layout.corner)
    _demand(not touched.any(), "a block corner lies inside an edge")
    mesh = connect_quads(quad, int(np.max(quad)) + 1)
    on_feature = edges_between(mesh, crease)
    missing = on_feature & ~edges_between(mesh, _edge_steps(layout)[1])
    _demand(not missing.any(), "a feature edge lies inside a block")
    free = mesh.irregular & ~mesh.on_boundary
    free[mesh.edge_vertex[on_feature]] = False
    corners = np.bincount(layout.corner.ravel(), minlength=mesh.vertex_count)
    _demand(
        np.array_equal(corners[free], mesh.face_count[free]),
        "an irregular vertex is no corner of a block beside it",
    )


def _demand(condition, cause):
    if not condition:
        raise LayoutError(f"The T-layout is not valid ({cause}): the blocks conform instead.")


def _verify_sides(layout: TLayout):
    """The edges along each side are the border of its grid; each edge has its one or two sides."""
    (m, n), first, last = layout.shape.T, layout.grid_offset[:-1], layout.grid_offset[1:] - 1
    start = np.stack([first, first + m, last, last - m], 1).ravel()
    stride = np.stack([0 * m + 1, m + 1, 0 * m - 1, -m - 1], 1).ravel()
    extent = np.stack([m, n, m, n], 1).ravel()
    size = (np.diff(layout.edge_offset) - 1)[layout.side_edge]
    side = np.repeat(np.arange(4 * layout.count), np.diff(layout.side_offset))
    begins = np.concatenate([[0], np.cumsum(size)])[:-1]
    begins = begins - begins[layout.side_offset[:-1]][side]
    _demand(
        np.array_equal(layout.side_start, begins)
        and np.array_equal(np.bincount(side, size, 4 * layout.count), extent)
        and np.array_equal(layout.grid_vertex[start], layout.corner.ravel()),
        "the edges along a side do not fill it",
    )
    piece = np.repeat(np.arange(len(size)), size + 1)
    step = np.arange(len(piece)) - np.repeat(np.cumsum(size + 1) - size - 1, size + 1)
    along = np.where(layout.side_forward[piece], step, size[piece] - step)
    chain = layout.edge_vertex[layout.edge_offset[layout.side_edge[piece]] + along]
    node = start[side[piece]] + (begins[piece] + step) * stride[side[piece]]
    _demand(np.array_equal(chain, layout.grid_vertex[node]), "an edge is not the border of a block")
    used = np.zeros((2, len(layout.edge_on_boundary)), np.int64)
    np.add.at(used, (layout.side_forward.astype(int), layout.side_edge), 1)
    sides = np.where(layout.edge_on_boundary, 1, 2)
    _demand(
        (used <= 1).all() and np.array_equal(used.sum(0), sides),
        "an edge has a wrong number of sides",
    )


def _edge_steps(blocks):
    """Block edge (n,) and end vertices (n, 2) of all mesh edges on block edges."""
    size = np.diff(blocks.edge_offset) - 1
    number = np.repeat(np.arange(len(size)), size)
    start = np.arange(len(number)) + number
    return number, np.stack([blocks.edge_vertex[start], blocks.edge_vertex[start + 1]], 1)


def _among(pairs, others, vertex_count):
    """(n,) bool, which pairs of vertices (n, 2) are among the others, in either direction."""
    span = np.array([vertex_count, 1])
    others = np.sort(np.asarray(others, np.int64).reshape(-1, 2), axis=1)
    return np.isin(np.sort(pairs, axis=1) @ span, others @ span)


def _sides(mesh: QuadConnectivity, grids: Grids, chains: Chains):
    """Offsets, edges, starts and directions of the sides of the blocks."""
    column, row = grids.column, grids.row
    m, n = grids.shape[grids.quad_block].T
    found = []
    for k, (border, node) in enumerate((
        (row == 0, column), (column == m - 1, row),
        (row == n - 1, m - 1 - column), (column == 0, n - 1 - row),
    )):
        halfedge = turned(grids.base[border], k)
        found.append(np.stack([4 * grids.quad_block[border] + k, node[border], halfedge]))
    side, node, halfedge = np.concatenate(found, axis=1)
    order = np.lexsort([node, side])
    side, node, halfedge = side[order], node[order], halfedge[order]
    edge = chains.chain[mesh.edge[halfedge]]
    _demand((edge >= 0).all(), "a block has an open border")
    first = np.flatnonzero((np.diff(edge, prepend=-1) != 0) | (np.diff(side, prepend=-1) != 0))
    offset = np.searchsorted(side[first], np.arange(4 * len(grids.shape) + 1))
    edge, begin = edge[first], chains.offset[edge[first]]
    forward = (chains.vertex[begin] == mesh.tail[halfedge[first]]) & (
        chains.vertex[begin + 1] == mesh.head[halfedge[first]]
    )
    return offset, edge, node[first], forward
