"""Conforming blocks: the base complex of a quad mesh, every block a grid with four distinct corners.

`t_layout` joins them to fewer blocks that do not conform.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import LayoutError
from ..quads.quad_connectivity import QuadConnectivity, connect_quads
from ..quads.quads import grid_quads
from ..surface.surface import connected_components
from .cutting import Chains, edges_between, find_chains, find_grids


@dataclass(frozen=True)
class Blocks:
    """The conforming multi-block decomposition of a quad mesh: blocks share whole sides.

    quad_block   (Q,) int64, block of each quad
    shape        (B, 2) int64, quads along the first and second direction
    grid_offset  (B + 1,) int64; grid_vertex[grid_offset[b]:grid_offset[b + 1]]
    grid_vertex  .reshape(n + 1, m + 1): rows along the first direction, counter-clockwise corners
                 [0, 0], [0, -1], [-1, -1], [-1, 0]
    corner       (B, 4) int64, vertices of the four distinct corners, counter-clockwise
    edge_offset  (E + 1,) int64; block edge e is the chain of vertices
    edge_vertex  edge_vertex[edge_offset[e]:edge_offset[e + 1]], both ends included
    block_edge   (B, 4) int64, edge number of sides corner0-corner1, 1-2, 2-3, 3-0
    edge_on_boundary (E,) bool
    """

    quad_block: np.ndarray
    shape: np.ndarray
    grid_offset: np.ndarray
    grid_vertex: np.ndarray
    corner: np.ndarray
    edge_offset: np.ndarray
    edge_vertex: np.ndarray
    block_edge: np.ndarray
    edge_on_boundary: np.ndarray

    @property
    def count(self) -> int:
        return len(self.shape)

    @property
    def side_offset(self) -> np.ndarray:
        """(4 B + 1,) int64; side 4 * block + k has one edge, as sides of a TLayout have several."""
        return np.arange(4 * self.count + 1)

    @property
    def side_edge(self) -> np.ndarray:
        """(4 B,) int64, the edge of each side."""
        return self.block_edge.ravel()

    @property
    def side_start(self) -> np.ndarray:
        """(4 B,) int64, node of each side at which its edge begins."""
        return np.zeros(4 * self.count, np.int64)

    @property
    def side_forward(self) -> np.ndarray:
        """(4 B,) bool: does a side, counter-clockwise, run in the direction its edge is stored in?"""
        start = self.edge_vertex[self.edge_offset[self.block_edge]]
        return (start == self.corner).ravel()


def find_blocks(quad, vertex_count: int, source, crease=()) -> Blocks:
    """Cut a quad mesh along straight mesh lines into blocks.

    quad    (Q, 4) int64, oriented and manifold, every vertex used
    source  (P,) bool, vertices from which all mesh lines are cut; irregular vertices (not 4 quads
            inside, not 2 on the boundary) are sources in any case
    crease  (n, 2) int, end vertices of inner edges that no block may straddle

    Lines run from a source until they reach the boundary or a source. Where a block would close up
    into a ring or touch itself, or two block edges would join the same two corners, further whole
    mesh lines are cut: at least three blocks then go round. Raises LayoutError if the quads are no
    manifold. (method section 8)
    """
    mesh = connect_quads(quad, vertex_count)
    source = np.asarray(source, bool) | mesh.irregular
    straight = np.where(source[mesh.head], -1, mesh.straight)
    line = _mesh_lines(mesh, straight)
    cut = _separatrices(mesh, source, line)
    cut |= np.isin(line, line[edges_between(mesh, crease)])
    _cut_bare_parts(mesh, line, cut)
    while True:
        chains = find_chains(mesh, straight, cut)
        vertices = _places_to_cut(mesh, chains)
        if not len(vertices):
            return _assemble(mesh, cut, chains)
        beside = np.isin(mesh.edge_vertex, vertices).any(1) & ~cut
        cut |= np.isin(line, line[beside])


def verify_blocks(blocks: Blocks, quad):
    """Test that blocks are grids with four distinct corners that conform.

    quad  (Q, 4) int64, the quads that the blocks were made of

    Every quad lies in the grid of its block; the sides of each block are its block edges, vertex by
    vertex; every edge belongs to one side (boundary) or to two, in opposite directions; no block
    corner lies inside an edge; no two edges join the same corners. Raises LayoutError.
    """
    filled, owner = grid_quads(blocks.shape, blocks.grid_offset, blocks.grid_vertex)
    rows = np.column_stack([np.sort(filled, axis=1), owner])
    wanted = np.column_stack([np.sort(quad, axis=1), blocks.quad_block])
    _demand(
        rows.shape == wanted.shape
        and np.array_equal(rows[np.lexsort(rows.T)], wanted[np.lexsort(wanted.T)]),
        "the grids of the blocks are not the quads",
    )
    distinct = (np.diff(np.sort(blocks.corner, axis=1), axis=1) > 0).all()
    _demand(distinct, "a block meets one of its corners twice")
    start = blocks.edge_vertex[blocks.edge_offset[:-1]]
    end = blocks.edge_vertex[blocks.edge_offset[1:] - 1]
    ends = np.sort(np.stack([start, end], 1), axis=1)
    _demand(len(np.unique(ends, axis=0)) == len(ends), "two block edges join the same corners")
    inner = np.ones(len(blocks.edge_vertex), bool)
    inner[blocks.edge_offset[:-1]] = inner[blocks.edge_offset[1:] - 1] = False
    touched = np.isin(blocks.edge_vertex[inner], blocks.corner)
    _demand(not touched.any(), "a block corner lies inside a block edge")
    _verify_sides(blocks, start)


def _demand(condition, cause):
    if not condition:
        raise LayoutError(f"The blocks do not conform: {cause}; use another size.")


def _verify_sides(blocks, edge_start):
    """The border of every grid is made of its edges; each edge has its one or two sides."""
    (m, n), first, last = blocks.shape.T, blocks.grid_offset[:-1], blocks.grid_offset[1:] - 1
    start = np.stack([first, first + m, last, last - m], 1).ravel()
    stride = np.stack([0 * m + 1, m + 1, 0 * m - 1, -m - 1], 1).ravel()
    size = np.stack([m, n, m, n], 1).ravel() + 1
    edge = blocks.block_edge.ravel()
    same_size = np.array_equal(size, np.diff(blocks.edge_offset)[edge])
    same_start = np.array_equal(blocks.grid_vertex[start], blocks.corner.ravel())
    _demand(same_size and same_start, "a side is not its block edge")
    forward = blocks.grid_vertex[start] == edge_start[edge]
    side = np.repeat(np.arange(len(size)), size)
    step = np.arange(len(side)) - np.repeat(np.cumsum(size) - size, size)
    along = np.where(forward[side], step, size[side] - 1 - step)
    chain = blocks.edge_vertex[blocks.edge_offset[edge[side]] + along]
    border = blocks.grid_vertex[start[side] + step * stride[side]]
    _demand(np.array_equal(chain, border), "a side is not its block edge")
    used = np.zeros((2, len(edge_start)), np.int64)
    np.add.at(used, (forward.astype(int), edge), 1)
    sides = np.where(blocks.edge_on_boundary, 1, 2)
    _demand(
        (used <= 1).all() and np.array_equal(used.sum(0), sides),
        "a block edge has a wrong number of sides",
    )


def _mesh_lines(mesh: QuadConnectivity, straight) -> np.ndarray:
    """(E,) int64, number of the straight line that each edge lies on."""
    onward = np.flatnonzero(straight >= 0)
    return connected_components(mesh.edge_count, mesh.edge[onward], mesh.edge[straight[onward]])


def _separatrices(mesh, source, line) -> np.ndarray:
    """(E,) bool, edges on the boundary and on lines that end at a source."""
    cut = np.zeros(mesh.edge_count, bool)
    cut[mesh.edge[mesh.boundary]] = True
    inner_start = source[mesh.edge_vertex].any(1) & ~cut
    return cut | np.isin(line, line[inner_start])


def _cut_bare_parts(mesh, line, cut):
    """In parts of the mesh without any cut (tori), cut both lines through one vertex; in place."""
    inner = np.flatnonzero(mesh.twin >= 0)
    part = connected_components(len(mesh.quad), inner // 4, mesh.twin[inner] // 4)
    is_cut = np.bincount(part, cut[mesh.edge].reshape(-1, 4).sum(1)) > 0
    first = np.unique(part, return_index=True)[1][~is_cut]
    sides = mesh.edge.reshape(-1, 4)[first]
    cut |= np.isin(line, line[sides[:, [0, 3]].ravel()])


def _places_to_cut(mesh, chains: Chains) -> np.ndarray:
    """Vertices through which further lines must run; empty when all blocks are grids."""
    if chains.closed.any():
        return mesh.edge_vertex[chains.closed].min(keepdims=True).ravel()
    ends, size = chains.ends, np.diff(chains.offset) - 1
    loops = np.flatnonzero(ends[:, 0] == ends[:, 1])
    if len(loops):
        longest = loops[np.argmax(size[loops])]
        share, parts = size[longest] * np.array([1, 2]), 3
    else:
        order = np.lexsort([size, ends[:, 1], ends[:, 0]])
        same = (np.diff(ends[order], axis=0) == 0).all(1)
        if not same.any():
            return np.zeros(0, np.int64)
        # The longer one of two edges that join the same corners.
        longest = order[1:][same][0]
        share, parts = size[longest : longest + 1], 2
    return chains.vertex[chains.offset[longest] + (share + parts // 2) // parts]


def _assemble(mesh: QuadConnectivity, cut, chains: Chains) -> Blocks:
    """The grids between the cut edges, and their block edges."""
    grids = find_grids(mesh, cut)
    on_boundary = np.zeros(len(chains.offset) - 1, bool)
    on_boundary[chains.chain[mesh.edge[mesh.boundary]]] = True
    start = chains.chain[mesh.edge[grids.corner_halfedge]]
    return Blocks(
        grids.quad_block, grids.shape, grids.offset, grids.vertex, grids.corner, chains.offset,
        chains.vertex, start, on_boundary,
    )
