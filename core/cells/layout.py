"""The layout: all lines traced, every cell checked to be a four-sided disc, rings and traps mended.

A boundary loop that no line reaches is given three lines; a ring between two closed walls is cut by
three lines across it; lines that wind for ever are stopped by the four lines of a regular point
put into the way of each, and everything is traced again. Full streamlines that wind themselves into
a corner are traced again with half the limits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import LayoutError
from ..features.charts import Charts
from ..field.constraints import Constraints
from ..field.cross_field import CrossField
from ..surface.surface import TriangleSurface
from .cell_complex import ArcGraph, assemble, build_arc_graph, orbit_sides, trace_cells
from .cell_mesh import Pieces, build_cell_mesh, cut_pieces
from .cells import CellComplex, CellMesh
from .gluing import Gluing, glue_cells
from .line_field import build_line_field, corner_ports, inserted_ports
from .streamlines import LineGraph, LineTrapped

# Rounds of mending before the layout is given up.
MOST_ROUNDS = 12
# Rounds of barriers that must have made the trapped lines fewer.
FUTILE_ROUNDS = 3


@dataclass(frozen=True)
class Layout:
    """Four-sided cells of a surface, and what it took to get them.

    complex       CellComplex
    cell_mesh     CellMesh
    regular_faces triangles into which a regular point was put to stop a winding line
    ring_cuts     number of rings that had to be cut
    topology      Euler characteristic, boundary loops and components of the whole surface
    gluing        Gluing, how cells of charts make up the complex; None without feature edges
    """

    complex: CellComplex
    cell_mesh: CellMesh
    regular_faces: tuple
    ring_cuts: int
    topology: tuple
    gluing: Gluing | None = None


def trace_layout(
    surface: TriangleSurface,
    constraints: Constraints,
    field: CrossField,
    crossing_limits=None,
    cancelled=None,
    charts: Charts | None = None,
) -> Layout:
    """Trace the lines of a cross-field and build the cells.

    crossing_limits  None for the motorcycle graph; (length, turn) for full streamlines, object-space
                     length and radians after which a line ends at the next line it meets
    charts           Charts, where the surface was cut along feature edges: cells are glued there

    Raises LayoutError when no four-sided cells come out, Cancelled.
    """
    singular = np.flatnonzero(field.index)
    regular, trapped = [], []
    for _ in range(MOST_ROUNDS):
        faces = np.concatenate([singular, np.array(regular, np.int64)])
        try:
            graph = _trace_all(surface, constraints, field, faces, crossing_limits, cancelled)
            return _cut_into_cells(surface, constraints, graph, tuple(regular), charts)
        except LineTrapped as trap:
            trapped.append(len(trap.faces))
            if len(trapped) > FUTILE_ROUNDS and trapped[-1] >= trapped[-1 - FUTILE_ROUNDS]:
                break
            for face in trap.faces:
                regular.append(_free_face(surface, face, np.concatenate([singular, regular])))
            if crossing_limits is not None:
                crossing_limits = tuple(0.5 * limit for limit in crossing_limits)
        except _NothingToStartFrom as closed:
            regular.append(_free_face(surface, closed.face, faces))
    raise LayoutError(
        f"Lines still spiral without end after {len(regular)} barriers; use another relaxation or "
        "a finer mesh."
    )


class _NothingToStartFrom(Exception):
    """A closed part without any singularity: no line enters it. `face` lies in it."""

    def __init__(self, face):
        super().__init__()
        self.face = face


def _trace_all(surface, constraints, field, faces, crossing_limits, cancelled):
    lines = build_line_field(surface, field, faces)
    graph = LineGraph(lines, crossing_limits, cancelled)
    for number in range(len(faces)):
        for port in inserted_ports(lines, number):
            graph.start_at_port(port)
    for vertex in np.flatnonzero(constraints.block_count > 2).tolist():
        angle, blocks = float(field.angle[vertex]), int(constraints.block_count[vertex])
        for port in corner_ports(surface, lines, angle, vertex, blocks):
            graph.start_at_port(port)
    graph.run()
    _reach_bare_loops(surface, constraints, graph)
    return graph


def _reach_bare_loops(surface, constraints, graph):
    """Three lines from every boundary loop that has no node yet."""
    is_node = (constraints.block_count != 2) | constraints.kink
    for loop in range(surface.loop_count):
        halfedges = surface.loop_halfedges[surface.loop_offset[loop] : surface.loop_offset[loop + 1]]
        number = graph.lines.halfedge_number[halfedges]
        if is_node[surface.tail[halfedges]].any() or any(n in graph.walls for n in number.tolist()):
            continue
        end = np.cumsum(surface.edge_length[halfedges])
        for share in (1 / 6, 3 / 6, 5 / 6):
            position = share * end[-1]
            at = int(np.searchsorted(end, position))
            parameter = 1.0 - (end[at] - position) / surface.edge_length[halfedges[at]]
            graph.start_at_wall(int(number[at]), float(np.clip(parameter, 0.05, 0.95)))
        graph.run()


def _free_face(surface, face, taken):
    """The given triangle, or one near it, that holds no inserted point yet."""
    taken = set(np.asarray(taken).tolist())
    front, seen = [face], {face}
    while front:
        for candidate in front:
            if candidate not in taken:
                return candidate
        beside = surface.twin.reshape(-1, 3)[front].ravel()
        front = sorted({int(t) // 3 for t in beside if t >= 0} - seen)
        seen.update(front)
    raise LayoutError("The mesh is too coarse for its singularities; subdivide it.")


def _cut_into_cells(surface, constraints, graph, regular, charts) -> Layout:
    cuts = 0
    for _ in range(MOST_ROUNDS):
        if charts is not None:
            graph.mark_across(_across_lines(graph.lines, charts))
        arc_graph = build_arc_graph(surface, constraints, graph)
        orbits = trace_cells(arc_graph)
        pieces = cut_pieces(graph)
        rings = _rings(graph, pieces, arc_graph, orbits)
        if not rings:
            break
        for walk in rings:
            _cut_ring(graph, arc_graph, walk)
        cuts += len(rings)
    else:
        raise LayoutError(f"Rings without corners remain after {MOST_ROUNDS} rounds of cutting.")
    cells = [orbit_sides(walk, flags) for walk, flags in orbits]
    broken = [walk for (walk, _), sides in zip(orbits, cells, strict=True) if sides is None]
    if broken:
        points = [_walk_points(arc_graph, halfarc)[0] for walk in broken for halfarc in walk]
        raise LayoutError(
            f"{len(broken)} of {len(cells)} regions of the layout do not have four corners; refine "
            "the mesh or use another relaxation.",
            np.array([graph.point(point) for point in points]),
        )
    complex_ = assemble(surface, constraints, graph, arc_graph, cells)
    cell_mesh = build_cell_mesh(graph, pieces, arc_graph.arcs, complex_)
    whole, gluing = surface, None
    if charts is not None:
        same = dict(enumerate(charts.first_copy.tolist()))
        same.update((point, min(point, other)) for point, other in graph.across.items())
        points = [arc.points for arc in arc_graph.arcs]
        whole = charts.whole
        complex_, gluing = glue_cells(charts, complex_, points, sorted(arc_graph.outgoing), same)
    topology = whole.euler_characteristic, whole.loop_count, whole.component_count
    return Layout(complex_, cell_mesh, regular, cuts, topology, gluing)


def _across_lines(lines, charts):
    """(3F',) int64, for each halfedge of the LineField the one across the cut, or -1."""
    across = np.full(len(lines.twin), -1)
    cut = np.flatnonzero(charts.across >= 0)
    across[lines.halfedge_number[cut]] = lines.halfedge_number[charts.across[cut]]
    return across


def _rings(graph, pieces: Pieces, arc_graph: ArcGraph, orbits):
    """One closed wall of every region that is a ring; raises where a region is neither."""
    walls = [[] for _ in range(int(pieces.component.max()) + 1)]
    for number, (walk, _) in enumerate(orbits):
        points = _walk_points(arc_graph, walk[0])
        corner = pieces.wall_corner[points[0], points[1]]
        owner = int(np.searchsorted(pieces.corner_offset, corner, side="right")) - 1
        walls[pieces.component[owner]].append(number)
    rings = []
    for component, numbers in enumerate(walls):
        if not numbers:
            first = int(np.flatnonzero(pieces.component == component)[0])
            face = graph.lines.origin_face[pieces.polygon_face[first]]
            raise _NothingToStartFrom(int(face))
        if len(numbers) == 1:
            continue
        if len(numbers) > 2 or any(any(orbits[n][1]) for n in numbers):
            raise LayoutError(
                "A region of the layout is neither a disc nor a ring; refine the mesh or use "
                "another relaxation."
            )
        rings.append(orbits[numbers[0]][0])
    return rings


def _walk_points(arc_graph, halfarc):
    points = arc_graph.arcs[halfarc // 2].points
    return points[::-1] if halfarc % 2 else points


def _cut_ring(graph: LineGraph, arc_graph: ArcGraph, walk):
    """Start three lines across a ring, evenly along one of its walls."""
    segments = []
    for halfarc in walk:
        arc = arc_graph.arcs[halfarc // 2]
        points = _walk_points(arc_graph, halfarc)
        faces = arc.faces[::-1] if halfarc % 2 else arc.faces
        segments += list(zip(faces, points, points[1:]))
    lengths = [np.linalg.norm(np.subtract(graph.point(p), graph.point(q))) for _, p, q in segments]
    end = np.cumsum(lengths)
    chosen = np.unique(np.searchsorted(end, np.array([1 / 6, 3 / 6, 5 / 6]) * end[-1]))
    for face, first, second in (segments[k] for k in chosen):
        graph.start_between(face, first, second)
    graph.run()
