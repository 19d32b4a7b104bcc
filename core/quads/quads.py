"""Connectivity of the quad mesh that fills the cells, tested before any geometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..cells.cells import CellComplex, NodeKind
from ..errors import CoarseLayoutError, LayoutError
from ..surface.surface import connected_components
from .lengths import side_lengths
from .quad_connectivity import QuadConnectivity, connect_quads, vertex_fans

# Every arc is divided by so many to see a layout's topology apart from its coarseness: round the
# narrowest ring there are then three quads.
TOPOLOGY_FACTOR = 3


@dataclass(frozen=True)
class QuadLayout:
    """Vertices and quads without positions.

    quad             (Q, 4) int64 vertex numbers, counter-clockwise
    quad_cell        (Q,) int64, cell of the line graph that the quad lies in
    vertex_count     P
    node_vertex      (N,) int64, vertex at every node of the CellComplex (several nodes may share
                     one where arcs have length zero)
    arc_vertex_offset (A + 1,) int64; arc a holds the length[a] + 1 vertices
    arc_vertex       arc_vertex[arc_vertex_offset[a]:arc_vertex_offset[a + 1]], first to second node
    cell_shape       (C, 2) int64, m quads along side 0 and n along side 1; a zero = cell vanished
    grid_offset      (C + 1,) int64; cell c holds the (m + 1) * (n + 1) vertices
    grid_vertex      grid_vertex[grid_offset[c]:...].reshape(n + 1, m + 1): row 0 follows side 0
                     from corner 0 to corner 1, the last column follows side 1
    vertex_fixed     (P,) bool: corners and kinks, which may not move
    vertex_loop      (P,) int64, boundary loop, -1 inside
    """

    quad: np.ndarray
    quad_cell: np.ndarray
    vertex_count: int
    node_vertex: np.ndarray
    arc_vertex_offset: np.ndarray
    arc_vertex: np.ndarray
    cell_shape: np.ndarray
    grid_offset: np.ndarray
    grid_vertex: np.ndarray
    vertex_fixed: np.ndarray
    vertex_loop: np.ndarray


def build_quads(complex: CellComplex, length) -> QuadLayout:
    """Fill every cell with its grid of quads.

    length  (A,) int64, balanced: opposite sides of every cell agree (`lengths.solve_lengths`)

    Arcs of length zero join their ends, a cell without width joins its opposite sides. Raises
    LayoutError if the lengths are not balanced; `verify_topology` tests the rest.
    """
    raw = raw_vertices(complex, length)
    grid_offset, grid_raw, count = _grid_vertices(raw)
    vertex = connected_components(count, *joined_vertices(complex, raw)[:2])
    length, shape, arc_raw = raw.length, raw.sides[:, :2], raw.arc_vertex
    quad, quad_cell = grid_quads(shape, grid_offset, vertex[grid_raw])
    vertex_count = int(vertex.max(initial=-1)) + 1
    fixed = np.isin(complex.node_kind, (NodeKind.CORNER, NodeKind.KINK))
    vertex_fixed = np.zeros(vertex_count, bool)
    vertex_fixed[vertex[: complex.node_count][fixed]] = True
    loop = np.repeat(complex.arc_loop, length + 1)
    vertex_loop = np.full(vertex_count, -1, np.int64)
    vertex_loop[vertex[arc_raw[loop >= 0]]] = loop[loop >= 0]
    return QuadLayout(
        quad, quad_cell, vertex_count, vertex[: complex.node_count], raw.arc_offset,
        vertex[arc_raw], shape, grid_offset, vertex[grid_raw], vertex_fixed, vertex_loop,
    )


@dataclass(frozen=True)
class RawVertices:
    """The vertices along arcs and sides before those that fall together are joined.

    length       (A,) int64, lengths of the arcs
    sides        (C, 4) int64, lengths of the sides
    count        number of vertices: the nodes, then those inside the arcs
    arc_offset   (A + 1,) int64; arc a holds arc_vertex[arc_offset[a]:arc_offset[a + 1]]
    side_offset  (4 C + 1,) int64; side k of cell c holds, counter-clockwise, from corner to corner,
                 side_vertex[side_offset[4 * c + k]:side_offset[4 * c + k + 1]]
    """

    length: np.ndarray
    sides: np.ndarray
    count: int
    arc_offset: np.ndarray
    arc_vertex: np.ndarray
    side_offset: np.ndarray
    side_vertex: np.ndarray


def raw_vertices(complex: CellComplex, length) -> RawVertices:
    """Vertices of a layout for balanced lengths (A,); raises LayoutError if they are not balanced."""
    length = np.asarray(length, np.int64)
    sides = side_lengths(complex, length)
    if (length < 0).any() or (sides[:, :2] != sides[:, 2:]).any():
        raise LayoutError("The arc lengths do not make opposite sides of all cells equal.")
    arc_offset, arc_vertex = _arc_vertices(complex, length)
    count = complex.node_count + int(np.maximum(length - 1, 0).sum())
    side_offset, side_vertex = _side_vertices(complex, length, sides, arc_offset, arc_vertex)
    return RawVertices(length, sides, count, arc_offset, arc_vertex, side_offset, side_vertex)


def joined_vertices(complex: CellComplex, raw: RawVertices):
    """Pairs of vertices made one by arcs of length zero and by cells without width.

    Returns (first (n,) int64, second (n,) int64, flat (n,) int64): the ends of all arcs of length
    zero, in their order, flat -1; then those that face each other across a cell c without width,
    flat 2 c where its sides 0 and 2 have no length, 2 c + 1 where sides 1 and 3 have none.
    """
    ends = complex.arc_node[raw.length == 0]
    first, second, flat = [ends[:, 0]], [ends[:, 1]], [np.full(len(ends), -1)]
    start, end = raw.side_offset[:-1].reshape(-1, 4), raw.side_offset[1:].reshape(-1, 4) - 1
    for direction in (0, 1):
        thin = np.flatnonzero(raw.sides[:, direction] == 0)
        cell, step = _ranges(raw.sides[thin, 1 - direction] + 1)
        cell = thin[cell]
        first.append(raw.side_vertex[start[cell, 1 - direction] + step])
        second.append(raw.side_vertex[end[cell, 3 - direction] - step])
        flat.append(2 * cell + direction)
    return np.concatenate(first), np.concatenate(second), np.concatenate(flat)


def verify_topology(
    layout: QuadLayout,
    complex: CellComplex,
    euler_characteristic: int,
    loop_count: int,
    component_count: int,
    valences: bool = True,
):
    """Test that the quads make the surface that they are meant to make.

    Raises LayoutError with the cause where nodes that must stay apart share a vertex, boundary
    loops touch, the mesh is not a manifold of the given Euler characteristic, number of boundary
    loops and components, or (with `valences`) a vertex has another number of quads than the line
    graph says. CoarseLayoutError where quads are too large to keep parts of the surface apart.
    """
    if not len(layout.quad):
        raise LayoutError("The layout has room for no quad at all; ask for more quads.")
    _refuse_sharp_singularities(complex)
    _refuse_merged(layout, complex)
    mesh = connect_quads(layout.quad, layout.vertex_count)
    _refuse_pinched(mesh)
    found = (
        layout.vertex_count - mesh.edge_count + len(mesh.quad),
        _loop_count(mesh),
        _part_count(mesh),
    )
    wanted = (euler_characteristic, loop_count, component_count)
    if found != wanted:
        raise LayoutError(
            "The quads have Euler characteristic {}, {} boundary loops and {} parts".format(*found)
            + " instead of {}, {} and {}; ask for more quads.".format(*wanted)
        )
    if valences:
        _verify_valences(mesh, layout, complex)


def verify_lengths(
    complex: CellComplex,
    length,
    euler_characteristic: int,
    loop_count: int,
    component_count: int,
    valences: bool = True,
):
    """Fill the cells and verify, telling bad layouts from those that are only too coarse.

    Returns (QuadLayout, (A,) bool: arcs to lengthen; none when the layout is good as it is).
    Raises LayoutError if not even much longer arcs, with the same arcs zero, make the surface.
    (method section 8)
    """
    expected = euler_characteristic, loop_count, component_count, valences
    layout = build_quads(complex, length)
    try:
        verify_topology(layout, complex, *expected)
    except LayoutError as error:
        finer = build_quads(complex, TOPOLOGY_FACTOR * np.asarray(length, np.int64))
        verify_topology(finer, complex, *expected)
        if isinstance(error, CoarseLayoutError):
            return layout, arcs_to_lengthen(complex, layout, error.edge)
        return layout, (length > 0) & (length == length[length > 0].min())
    return layout, np.zeros(complex.arc_count, bool)


def arcs_to_lengthen(complex: CellComplex, layout: QuadLayout, edge) -> np.ndarray:
    """(A,) bool, arcs whose lengthening splits the given mesh edges; one for each cell beside them.

    edge  (n, 2) int64, end vertices of mesh edges
    """
    low, high = np.sort(np.asarray(edge).reshape(-1, 2), axis=1).T
    ends = np.stack([layout.quad, np.roll(layout.quad, -1, axis=1)])
    key = ends.min(0) * np.int64(layout.vertex_count) + ends.max(0)
    quad, corner = np.nonzero(np.isin(key, low * np.int64(layout.vertex_count) + high))
    # Corner 0 of every quad is the one nearest to corner 0 of its cell: even sides follow side 0.
    side = np.unique(4 * layout.quad_cell[quad] + corner % 2)
    slot = np.flatnonzero(np.isin(complex.slot_side, side))
    arc = complex.side_halfarc[slot] // 2
    order = np.lexsort([-np.diff(layout.arc_vertex_offset)[arc], complex.slot_side[slot]])
    first = np.flatnonzero(np.diff(complex.slot_side[slot][order], prepend=-1))
    chosen = np.zeros(complex.arc_count, bool)
    chosen[arc[order[first]]] = True
    return chosen


def grid_quads(shape, grid_offset, grid_vertex):
    """Quads of many grids, row by row, corner 0 nearest to the start of the grid.

    shape        (C, 2) int64, quads along and across the rows
    grid_offset  (C + 1,) int64
    grid_vertex  int64, grid c is grid_vertex[grid_offset[c]:grid_offset[c + 1]], row by row

    Returns ((Q, 4) int64, (Q,) int64 number of the grid).
    """
    m = shape[:, 0]
    cell, place = _ranges(shape.prod(1))
    width = np.maximum(m, 1)[cell]
    corner = grid_offset[cell] + place % width + (place // width) * (m[cell] + 1)
    above = corner + m[cell] + 1
    return grid_vertex[np.stack([corner, corner + 1, above + 1, above], 1)], cell


def _arc_vertices(complex, length):
    """Offsets and vertices of the arcs: nodes are 0 .. N - 1, then inner vertices arc after arc."""
    offset = np.concatenate([[0], np.cumsum(length + 1)])
    vertex = np.empty(offset[-1], np.int64)
    inner = np.ones(offset[-1], bool)
    inner[offset[:-1]] = inner[offset[1:] - 1] = False
    vertex[inner] = complex.node_count + np.arange(int(inner.sum()))
    # An arc of length zero keeps its second node; both are joined later.
    vertex[offset[:-1]] = complex.arc_node[:, 0]
    vertex[offset[1:] - 1] = complex.arc_node[:, 1]
    return offset, vertex


def _side_vertices(complex, length, sides, arc_offset, arc_vertex):
    """Offsets (4 C + 1) and vertices of all cell sides, counter-clockwise, corner to corner."""
    halfarc = complex.side_halfarc
    arc, backwards = halfarc // 2, halfarc % 2
    offset = np.concatenate([[0], np.cumsum(sides.ravel() + 1)])
    vertex = np.empty(offset[-1], np.int64)
    count = length[arc]
    slot, step = _ranges(count)
    start = np.where(backwards, arc_offset[arc + 1] - 1, arc_offset[arc])
    before = np.cumsum(count) - count + complex.slot_side
    vertex[before[slot] + step] = arc_vertex[start[slot] + np.where(backwards[slot], -step, step)]
    last = complex.side_offset[1:] - 1
    vertex[offset[1:] - 1] = complex.arc_node[arc[last], 1 - backwards[last]]
    return offset, vertex


def _grid_vertices(raw: RawVertices):
    """Offsets and vertices of the grids, and the number of all vertices, inner ones included."""
    m, n = raw.sides[:, :2].T
    offset = np.concatenate([[0], np.cumsum((m + 1) * (n + 1))])
    cell, place = _ranges(np.diff(offset))
    column, row = place % (m[cell] + 1), place // (m[cell] + 1)
    start = raw.side_offset[:-1].reshape(-1, 4)
    vertex = np.full(len(place), -1, np.int64)
    walls = (
        (row == 0, column),
        (column == m[cell], row),
        (row == n[cell], m[cell] - column),
        (column == 0, n[cell] - row),
    )
    for side, (mask, position) in reversed(list(enumerate(walls))):
        vertex[mask] = raw.side_vertex[start[cell[mask], side] + position[mask]]
    inner = np.flatnonzero(vertex < 0)
    vertex[inner] = raw.count + np.arange(len(inner))
    return offset, vertex, raw.count + len(inner)


def _ranges(counts):
    """Owner and position 0, 1, ... of each entry of consecutive ranges of the given lengths."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)


def _refuse_sharp_singularities(complex):
    """Two quads round an inner vertex would share two edges, however small they are."""
    sharp = np.flatnonzero(~complex.node_on_boundary & (complex.node_valence < 3))
    if len(sharp):
        raise LayoutError(
            f"Only {complex.node_valence[sharp[0]]} quads would meet at {len(sharp)} singularities "
            "(the surface is too pointed there); use another relaxation or a finer mesh."
        )


def _refuse_merged(layout, complex):
    """Nodes that must stay apart have vertices of their own; no vertex lies on two loops."""
    kinds = (NodeKind.SINGULARITY, NodeKind.CORNER, NodeKind.KINK)
    fixed = np.flatnonzero(np.isin(complex.node_kind, kinds))
    fixed = fixed[np.argsort(layout.node_vertex[fixed], kind="stable")]
    shared = np.flatnonzero(np.diff(layout.node_vertex[fixed]) == 0)
    if len(shared):
        a, b = fixed[shared[0]], fixed[shared[0] + 1]
        raise LayoutError(
            f"Nodes {a} and {b} of the layout, which must stay apart, fall on one vertex; "
            "use another relaxation or a finer mesh.",
            complex.node_position[[a, b]],
        )
    loop = np.repeat(complex.arc_loop, np.diff(layout.arc_vertex_offset))
    vertex = layout.arc_vertex[loop >= 0]
    differs = layout.vertex_loop[vertex] != loop[loop >= 0]
    if differs.any():
        a, b = layout.vertex_loop[vertex[differs][0]], loop[loop >= 0][differs][0]
        raise LayoutError(
            f"Boundary loops {a} and {b} would touch: there is no quad between them; use another "
            "relaxation or a finer mesh."
        )


def _refuse_pinched(mesh: QuadConnectivity):
    """One fan of quads round every vertex; no two quads share two edges."""
    fans = vertex_fans(mesh)
    if (fans == 0).any():
        raise LayoutError(
            f"{int((fans == 0).sum())} vertices of the layout have lost all their quads; ask for "
            "more quads."
        )
    pinched = np.flatnonzero(fans > 1)
    if len(pinched):
        raise CoarseLayoutError(
            f"{len(pinched)} vertices would join parts of the mesh that touch only there; "
            "ask for more quads.",
            mesh.edges_at(pinched),
        )
    inner = np.flatnonzero(mesh.twin >= 0)
    pair = inner // 4 * np.int64(len(mesh.quad)) + mesh.twin[inner] // 4
    order = np.argsort(pair, kind="stable")
    twice = inner[order[1:][np.diff(pair[order]) == 0]]
    if len(twice):
        sides = mesh.edge.reshape(-1, 4)[twice // 4]
        raise CoarseLayoutError(
            f"{len(np.unique(twice // 4))} quads would share two edges with one neighbour; "
            "ask for more quads.",
            mesh.edge_vertex[np.unique(sides)],
        )


def _loop_count(mesh: QuadConnectivity) -> int:
    used, number = np.unique(mesh.tail[mesh.boundary], return_inverse=True)
    onward = np.searchsorted(used, mesh.head[mesh.boundary])
    return int(connected_components(len(used), number.ravel(), onward).max(initial=-1)) + 1


def _part_count(mesh: QuadConnectivity) -> int:
    inner = np.flatnonzero(mesh.twin >= 0)
    return int(connected_components(len(mesh.quad), inner // 4, mesh.twin[inner] // 4).max()) + 1


def _verify_valences(mesh: QuadConnectivity, layout, complex):
    """Every irregular node is a vertex with as many quads as it says; all others are regular."""
    wall = complex.node_on_boundary
    node = np.flatnonzero(complex.node_valence != np.where(wall, 2, 4))
    expected = np.where(mesh.on_boundary, 2, 4)
    expected[layout.node_vertex[node]] = complex.node_valence[node]
    wrong = mesh.face_count != expected
    wrong[layout.node_vertex[node]] |= mesh.on_boundary[layout.node_vertex[node]] != wall[node]
    if wrong.any():
        raise LayoutError(
            f"{int(wrong.sum())} vertices would have another number of quads than the cross-field "
            f"says, the first {mesh.face_count[wrong][0]} instead of {expected[wrong][0]}; use "
            "another relaxation or a finer mesh."
        )
