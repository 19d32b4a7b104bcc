"""New divisions for a block layout: the fine grid of each block is sampled again.

The existing grid of a block is its geometry: a bilinear map from grid indices to space. Nodes of
block edges are placed by arc length, those of boundary edges exactly on the boundary of the
surface; nodes inside are placed where the lines between opposite edges meet, corrected by what the
edges gained in exactness, and projected to the surface.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ..blocks.blocks import Blocks
from ..blocks.chords import forward_sides
from ..errors import LayoutError
from ..quads.placement import Placement
from ..quads.quads import grid_quads
from ..surface.boundary import build_loops
from ..surface.projection import closest_point
from ..surface.surface import TriangleSurface
from .grid_filling import fill_grid
from .smooth_curves import sample_curve, sample_line
from .wall_spacing import Grading, line_heights

# Nodes this near to an old vertex, in old divisions, are that vertex.
_SAME_INDEX = 1e-9
# Points this near to the surface, in diagonals of its bounding box, lie on it.
_ON_SURFACE = 1e-12


@dataclass(frozen=True)
class Crease:
    """Feature edges of the surface, which some block edges run along.

    edge         (E,) bool, block edges along feature edges
    start, end   (n, 3) float64, ends of the feature edges of the surface
    face         (n,) int64, a triangle beside each
    """

    edge: np.ndarray
    start: np.ndarray
    end: np.ndarray
    face: np.ndarray

    def closest(self, points):
        """Closest points (k, 3) on the feature edges, and a triangle (k,) beside each."""
        step = self.end - self.start
        along = ((points[:, None] - self.start) * step).sum(2) / (step**2).sum(1)
        place = self.start + np.clip(along, 0, 1)[..., None] * step
        best = ((points[:, None] - place) ** 2).sum(2).argmin(1)
        return place[np.arange(len(points)), best], self.face[best]


@dataclass(frozen=True)
class Division:
    """What every block edge is to be divided into.

    count      (E,) int64, divisions
    index      list of E: (n + 1,) float64, where the nodes lie between the old vertices of the
               edge, of 1, from its stored start
    wall_side  (B, 4) bool, block sides towards which the grid is graded, or None
    grading    Grading or None
    measured   what `measured_heights` gives, or None
    asked      (block, side) -> (k,) float64, filled in by `regrid`: the first cells that it asked of
               the lines that leave a wall, counter-clockwise along the side
    crease     Crease or None
    """

    count: np.ndarray
    index: list
    wall_side: np.ndarray | None = None
    grading: Grading | None = None
    measured: dict | None = None
    asked: dict = field(default_factory=dict)
    crease: Crease | None = None


@dataclass(frozen=True)
class Regridded:
    """The new quad mesh; block, edge and corner order are those of the old one.

    placement  Placement of its vertices
    quads      (Q, 4) int64
    blocks     Blocks
    missed     share of the grid lines from a wall whose first height is not met
    """

    placement: Placement
    quads: np.ndarray
    blocks: Blocks
    missed: float = 0.0


@dataclass
class _Nodes:
    """Nodes of all new edges in a row; edge e is [offset[e]:offset[e + 1]].

    index  (n,) float64, place on the old edge in old divisions
    point, face, position, kept  as in Placement; kept are old fixed vertices
    """

    offset: np.ndarray
    index: np.ndarray
    point: np.ndarray
    face: np.ndarray
    position: np.ndarray
    kept: np.ndarray


def edge_arcs(surface: TriangleSurface, placement: Placement, blocks: Blocks) -> list:
    """List of E: (m + 1,) float64, arc length along each block edge at its vertices.

    Edges on the boundary are measured along the boundary of the surface.
    """
    loops = build_loops(surface)
    sign = edge_directions(blocks)
    result = []
    for edge, inside in enumerate(~blocks.edge_on_boundary):
        chain = edge_chain(blocks, edge)
        if inside:
            step = np.linalg.norm(np.diff(placement.point[chain], axis=0), axis=1)
        else:
            advance = sign[edge] * np.diff(placement.loop_position[chain])
            step = np.mod(advance, loops.length[placement.loop[chain[0]]])
        result.append(np.concatenate([[0.0], np.cumsum(step)]))
    return result


def edge_chain(blocks: Blocks, edge: int) -> np.ndarray:
    """(n + 1,) int64, the vertices of a block edge, both ends included."""
    return blocks.edge_vertex[blocks.edge_offset[edge] : blocks.edge_offset[edge + 1]]


def block_grid(blocks: Blocks, block: int) -> np.ndarray:
    """(n + 1, m + 1) int64, the vertices of a block, rows along its first direction."""
    m, n = blocks.shape[block]
    vertex = blocks.grid_vertex[blocks.grid_offset[block] : blocks.grid_offset[block + 1]]
    return vertex.reshape(n + 1, m + 1)


def regrid(
    surface: TriangleSurface, placement: Placement, blocks: Blocks, arcs: list, division: Division
) -> Regridded:
    """Divide the blocks anew; arcs as from `edge_arcs`.

    Raises LayoutError where opposite edges of a block differ in their divisions.
    """
    side_count = division.count[blocks.block_edge]
    if not np.array_equal(side_count[:, :2], side_count[:, 2:]):
        raise LayoutError("Opposite block edges have different divisions; divide chords alike.")
    nodes = _edge_nodes(surface, placement, blocks, arcs, division)
    fresh = _renumbered(blocks, division.count)
    quads, quad_block = grid_quads(fresh.shape, fresh.grid_offset, fresh.grid_vertex)
    fresh = Blocks(
        quad_block, fresh.shape, fresh.grid_offset, fresh.grid_vertex, fresh.corner,
        fresh.edge_offset, fresh.edge_vertex, fresh.block_edge, fresh.edge_on_boundary,
    )
    return Regridded(_place(surface, placement, blocks, fresh, nodes, division), quads, fresh)


def edge_directions(blocks):
    """(E,) int64: 1 where a boundary edge runs as its loop does, the surface on its left, else -1."""
    sign = np.zeros(len(blocks.edge_on_boundary), np.int64)
    sign[blocks.block_edge] = np.where(forward_sides(blocks), 1, -1)
    return sign


def _edge_nodes(surface, placement, blocks, arcs, division) -> _Nodes:
    """Nodes of all edges; those inside the surface are projected to it."""
    loops, sign = build_loops(surface), edge_directions(blocks)
    offset = np.concatenate([[0], np.cumsum(division.count + 1)])
    total = int(offset[-1])
    nodes = _Nodes(
        offset, np.zeros(total), np.zeros((total, 3)), np.zeros(total, np.int64), np.zeros(total),
        np.zeros(total, bool),
    )
    for edge, arc in enumerate(arcs):
        chain, here = edge_chain(blocks, edge), slice(offset[edge], offset[edge + 1])
        old = np.arange(len(chain))
        fixed = np.flatnonzero(placement.fixed[chain[1:-1]]) + 1
        index = _old_indices(division.index[edge], len(arc) - 1)
        nodes.index[here], nodes.kept[here] = index, np.isin(index, np.concatenate([[-1], fixed]))
        nodes.face[here] = placement.face[chain[np.rint(index).astype(np.int64)]]
        if blocks.edge_on_boundary[edge]:
            loop = np.full(len(index), placement.loop[chain[0]])
            at = np.interp(index, old, arc)
            along = placement.loop_position[chain[0]] + sign[edge] * at
            nodes.position[here] = loops.wrap(loop, along)
            nodes.point[here], nodes.face[here] = loops.point(loop, along)
        elif division.crease is not None and division.crease.edge[edge]:
            on_line = sample_line(placement.point[chain], index)
            nodes.point[here], nodes.face[here] = division.crease.closest(on_line)
        elif len(fixed):
            nodes.point[here] = sample_line(placement.point[chain], index)
        else:
            nodes.point[here] = sample_curve(placement.point[chain], index)
    free = ~blocks.edge_on_boundary
    free = free & ~division.crease.edge if division.crease is not None else free
    inside = np.repeat(free, np.diff(offset))
    inside &= nodes.index != np.rint(nodes.index)
    nodes.point[inside], nodes.face[inside] = _onto(
        surface, nodes.point[inside], nodes.face[inside]
    )
    return nodes


def _old_indices(place, last):
    """(n + 1,) float64, places of 1 in old divisions; those at old vertices become whole numbers."""
    index = place * last
    whole = np.rint(index)
    index = np.where(np.abs(index - whole) < _SAME_INDEX, whole, index)
    index[0], index[-1] = 0, last
    return index


def _renumbered(blocks: Blocks, count) -> Blocks:
    """The same blocks with new divisions: corners come first, then edges, then insides."""
    first, last = blocks.edge_offset[:-1], blocks.edge_offset[1:] - 1
    ends = np.stack([blocks.edge_vertex[first], blocks.edge_vertex[last]])
    corner, number = np.unique(ends, return_inverse=True)
    number = number.reshape(ends.shape)
    edge_offset = np.concatenate([[0], np.cumsum(count + 1)])
    edge_vertex = np.empty(edge_offset[-1], np.int64)
    inner = np.ones(len(edge_vertex), bool)
    inner[edge_offset[:-1]] = inner[edge_offset[1:] - 1] = False
    edge_vertex[edge_offset[:-1]], edge_vertex[edge_offset[1:] - 1] = number
    edge_vertex[inner] = len(corner) + np.arange(int(inner.sum()))
    shape = count[blocks.block_edge[:, :2]]
    grid_offset = np.concatenate([[0], np.cumsum((shape + 1).prod(1))])
    grid_vertex = np.empty(grid_offset[-1], np.int64)
    free = len(corner) + int(inner.sum())
    forward = forward_sides(blocks)
    for block, (m, n) in enumerate(shape.tolist()):
        grid = grid_vertex[grid_offset[block] : grid_offset[block + 1]].reshape(n + 1, m + 1)
        sides = []
        for edge, ahead in zip(blocks.block_edge[block], forward[block]):
            chain = edge_vertex[edge_offset[edge] : edge_offset[edge + 1]]
            sides.append(chain if ahead else chain[::-1])
        grid[0], grid[:, -1], grid[-1, ::-1], grid[::-1, 0] = sides
        grid[1:-1, 1:-1] = free + np.arange((m - 1) * (n - 1)).reshape(n - 1, m - 1)
        free += (m - 1) * (n - 1)
    new_corner = np.searchsorted(corner, blocks.corner)
    return Blocks(
        np.zeros(0, np.int64), shape, grid_offset, grid_vertex, new_corner, edge_offset,
        edge_vertex, blocks.block_edge, blocks.edge_on_boundary,
    )


def _place(surface, old, blocks, fresh, nodes, division) -> Placement:
    """Positions of all new vertices."""
    count = int(fresh.grid_vertex.max()) + 1
    point, face = np.empty((count, 3)), np.zeros(count, np.int64)
    loop, position = np.full(count, -1), np.zeros(count)
    fixed, inner = np.zeros(count, bool), np.ones(count, bool)
    point[fresh.edge_vertex], face[fresh.edge_vertex] = nodes.point, nodes.face
    fixed[fresh.edge_vertex], inner[fresh.edge_vertex] = nodes.kept, False
    lies_on = np.repeat(fresh.edge_on_boundary, np.diff(fresh.edge_offset))
    loop_of_edge = old.loop[blocks.edge_vertex[blocks.edge_offset[:-1]]]
    loop[fresh.edge_vertex[lies_on]] = np.repeat(loop_of_edge, np.diff(fresh.edge_offset))[lies_on]
    position[fresh.edge_vertex[lies_on]] = nodes.position[lies_on]
    for name, value in (("point", point), ("face", face), ("loop", loop), ("fixed", fixed),
                        ("loop_position", position)):
        value[fresh.corner] = getattr(old, name)[blocks.corner]
    forward = forward_sides(blocks)
    for block in range(blocks.count):
        sides = [_side(nodes, e, f) for e, f in zip(blocks.block_edge[block], forward[block])]
        grid = block_grid(blocks, block)
        place, row, column = fill_grid(old.point[grid], sides, _walls(division, block))
        vertex = block_grid(fresh, block)[1:-1, 1:-1]
        point[vertex] = place[1:-1, 1:-1]
        near = grid[np.rint(row).astype(np.int64), np.rint(column).astype(np.int64)]
        face[vertex] = old.face[near][1:-1, 1:-1]
    point[inner], face[inner] = _onto(surface, point[inner], face[inner])
    return Placement(point, face, loop, position, fixed)


def _onto(surface, point, face):
    """Closest points near the given faces, or those of the whole surface where these are far nearer.

    A search from a face can end at a wall: beside a corner that points into the surface, the
    nearest old vertex may lie behind that corner.
    """
    near, near_face = closest_point(surface, point, face)
    away = np.linalg.norm(near - point, axis=1)
    doubtful = np.flatnonzero(away > _ON_SURFACE * surface.diameter)
    other, other_face = closest_point(surface, point[doubtful])
    nearer = np.linalg.norm(other - point[doubtful], axis=1) < away[doubtful] / 2
    near[doubtful[nearer]], near_face[doubtful[nearer]] = other[nearer], other_face[nearer]
    return near, near_face


def _walls(division: Division, block) -> list | None:
    """Four functions of (points on a side, directions from there), counter-clockwise, or None.

    They give the first cells of the lines that leave a wall; None stands for a side that is none.
    """
    if division.wall_side is None or not division.wall_side[block].any():
        return None

    def rule(side, row, leaving):
        # From the second side on, sides run against the direction in which grids are numbered.
        order = 1 if side < 2 else -1
        if division.measured is None:
            height = line_heights(row, leaving, division.grading)
        else:
            known = division.measured[block, side][::order]
            height = np.interp(np.linspace(0, 1, len(row)), np.linspace(0, 1, len(known)), known)
        division.asked[block, side] = height[::order]
        return height

    is_wall = division.wall_side[block]
    return [partial(rule, side) if is_wall[side] else None for side in range(4)]


def _side(nodes: _Nodes, edge, forward):
    """(index, point) of a side of a block, counter-clockwise."""
    here = slice(nodes.offset[edge], nodes.offset[edge + 1])
    index, point = nodes.index[here], nodes.point[here]
    return (index, point) if forward else (index[-1] - index[::-1], point[::-1])
