"""From the line graph to four-sided cells, through a rotation system: no geometry decides.

At every node the arcs are known in their counter-clockwise order (at a junction: base onward, stem,
base back). Walking along an arc and turning to the next one clockwise goes round one cell. Each
sector of a node counts as a corner, save the flat side of a junction and a kink; a cell that is a
disc has four corners by the discrete Gauss-Bonnet theorem, and that is checked.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..errors import LayoutError
from ..field.constraints import Constraints
from ..surface.surface import TriangleSurface
from .cells import CellComplex, NodeKind
from .streamlines import BASE, PLAIN, LineGraph


@dataclass
class Arc:
    """Points from node to node; `faces` are triangles of the LineField, one for each segment."""

    points: list
    faces: list
    loop: int = -1
    loop_start: float = 0.0


@dataclass
class ArcGraph:
    """Arcs and, at every node, the outgoing halfarcs counter-clockwise.

    arcs     list of Arc
    outgoing dict node point -> list of halfarcs, on the boundary from the onward boundary arc to
             the backward one
    kind     dict node point -> NodeKind
    flat     dict node point -> the one sector (counter-clockwise of outgoing halfarc number so
             and so) that is no corner of its cell
    """

    arcs: list = field(default_factory=list)
    outgoing: dict = field(default_factory=dict)
    kind: dict = field(default_factory=dict)
    flat: dict = field(default_factory=dict)


def build_arc_graph(surface: TriangleSurface, constraints: Constraints, graph: LineGraph):
    """Split lines and boundary loops at their nodes, with the order of arcs round each node."""
    arc_graph = ArcGraph()
    starts, meetings = {}, {}
    for line in graph.tracks:
        _add_line(arc_graph, line, starts, meetings)
    wall = _add_boundary(arc_graph, surface, constraints, graph)
    for point, meeting in graph.meetings.items():
        arc_graph.kind[point] = meeting.kind
        if point not in wall:
            arc_graph.outgoing[point] = _around_meeting(meeting, meetings[point])
            if meeting.kind == NodeKind.JUNCTION:
                arc_graph.flat[point] = 2 if meeting.from_left else 0
    for vertex, numbers in graph.vertex_lines.items():
        leaving = [starts[n] for n in numbers]
        if vertex not in wall:
            index = int(np.searchsorted(graph.lines.inserted, vertex))
            regular = graph.lines.inserted_index[index] == 0
            arc_graph.kind[vertex] = NodeKind.REGULAR if regular else NodeKind.SINGULARITY
            arc_graph.outgoing[vertex] = leaving
        else:
            wall[vertex][1:1] = leaving
    for point, leaving in wall.items():
        if point in graph.meetings:
            leaving[1:1] = meetings[point].values()
        arc_graph.outgoing[point] = leaving
    return arc_graph


def _add_line(arc_graph, line, starts, meetings):
    """Arcs of one line; records the halfarc that leaves its start and those at its meetings."""
    last = len(line.points) - 1
    cuts = [k for k, role in enumerate(line.roles) if k in (0, last) or role != PLAIN]
    for begin, end in zip(cuts, cuts[1:]):
        number = len(arc_graph.arcs)
        arc_graph.arcs.append(Arc(line.points[begin : end + 1], line.faces[begin:end]))
        for position, halfarc, way in ((begin, 2 * number, "on"), (end, 2 * number + 1, "back")):
            point, role = line.points[position], line.roles[position]
            if position == 0:
                starts[line.number] = halfarc
            name = ("base" if role == BASE else "stem", way)
            meetings.setdefault(point, {})[name] = halfarc


def _around_meeting(meeting, halfarcs):
    """Outgoing halfarcs counter-clockwise where a stem meets a base inside the surface."""
    on, back = halfarcs["base", "on"], halfarcs["base", "back"]
    if meeting.kind == NodeKind.CROSSING:
        stem_on, stem_back = halfarcs["stem", "on"], halfarcs["stem", "back"]
        if meeting.from_left:
            return [on, stem_back, back, stem_on]
        return [on, stem_on, back, stem_back]
    stem = next(h for (role, _), h in halfarcs.items() if role == "stem")
    return [on, stem, back] if meeting.from_left else [on, back, stem]


def _add_boundary(arc_graph, surface, constraints, graph):
    """Arcs of all boundary loops; returns dict node point -> [onward halfarc, backward halfarc]."""
    is_node = (constraints.block_count != 2) | constraints.kink
    wall = {}
    for loop in range(surface.loop_count):
        halfedges = surface.loop_halfedges[surface.loop_offset[loop] : surface.loop_offset[loop + 1]]
        points, faces, reach, nodes = _loop_points(surface, graph, halfedges, is_node)
        if not nodes:
            raise LayoutError(f"Boundary loop {loop} carries no node of the layout.")
        for point in (points[k] for k in nodes):
            if point in graph.meetings:
                continue
            # A point that only the lines across a cut have put there is flat on this side.
            across = point in graph.across
            kink = not across and constraints.block_count[point] == 2
            kind = NodeKind.KINK if kink else NodeKind.CORNER
            arc_graph.kind[point] = NodeKind.WALL if across else kind
            if kink or across:
                arc_graph.flat[point] = 0
        count = len(points)
        for begin, end in zip(nodes, nodes[1:] + [nodes[0] + count]):
            number = len(arc_graph.arcs)
            index = [k % count for k in range(begin, end + 1)]
            arc_graph.arcs.append(
                Arc([points[k] for k in index], [faces[k] for k in index[:-1]], loop, reach[begin])
            )
            wall.setdefault(points[begin], [None, None])[0] = 2 * number
            wall.setdefault(points[end % count], [None, None])[1] = 2 * number + 1
    return wall


def _loop_points(surface, graph, halfedges, is_node):
    """Points of a loop in order, triangle of the segment after each, arc length, node positions."""
    points, faces, reach, nodes = [], [], [], []
    position = 0.0
    for halfedge in halfedges.tolist():
        vertex, length = int(surface.tail[halfedge]), float(surface.edge_length[halfedge])
        number = int(graph.lines.halfedge_number[halfedge])
        if is_node[vertex]:
            nodes.append(len(points))
        points.append(vertex)
        faces.append(number // 3)
        reach.append(position)
        for parameter, point in sorted(graph.walls.get(number, [])):
            nodes.append(len(points))
            points.append(point)
            faces.append(number // 3)
            reach.append(position + parameter * length)
        position += length
    return points, faces, reach, nodes


def trace_cells(arc_graph: ArcGraph) -> list:
    """Walk round all cells.

    Returns a list of orbits, each (list of halfarcs counter-clockwise, list of bool: the halfarc
    starts at a corner of the cell).
    """
    place = {h: (p, k) for p, out in arc_graph.outgoing.items() for k, h in enumerate(out)}
    seen = {2 * n + 1 for n, arc in enumerate(arc_graph.arcs) if arc.loop >= 0}
    orbits = []
    for first in range(2 * len(arc_graph.arcs)):
        if first in seen:
            continue
        walk, flags = [], []
        halfarc = first
        while halfarc not in seen:
            seen.add(halfarc)
            walk.append(halfarc)
            point, slot = place[halfarc ^ 1]
            out = arc_graph.outgoing[point]
            sector = (slot - 1) % len(out)
            flags.append(arc_graph.flat.get(point) != sector)
            halfarc = out[sector]
        orbits.append((walk, flags[-1:] + flags[:-1]))
    return orbits


def orbit_sides(walk, flags) -> list:
    """The four sides of a cell, lists of halfarcs; None unless there are four corners."""
    corners = [k for k, flag in enumerate(flags) if flag]
    if len(corners) != 4:
        return None
    walk = walk[corners[0] :] + walk[: corners[0]]
    cuts = [c - corners[0] for c in corners] + [len(walk)]
    return [walk[begin:end] for begin, end in zip(cuts, cuts[1:])]


def assemble(surface, constraints, graph: LineGraph, arc_graph: ArcGraph, cells) -> CellComplex:
    """Arrays of the complex. cells: for each cell its four sides, lists of halfarcs."""
    positions = graph.positions
    points = sorted(arc_graph.outgoing)
    number = {p: k for k, p in enumerate(points)}
    origin = graph.lines.origin_face
    arcs = arc_graph.arcs
    chain = [p for arc in arcs for p in arc.points]
    faces = [f for arc in arcs for f in arc.faces + arc.faces[-1:]]
    sides = [side for cell in cells for side in cell]
    node_face = np.empty(len(points), np.int64)
    for arc in arcs:
        node_face[number[arc.points[0]]] = origin[arc.faces[0]]
        node_face[number[arc.points[-1]]] = origin[arc.faces[-1]]
    valence, wall = _node_valences(constraints, graph, arc_graph, points)
    return CellComplex(
        node_position=positions[points],
        node_kind=np.array([arc_graph.kind[p] for p in points], np.int64),
        node_valence=valence,
        node_on_boundary=wall,
        node_face=node_face,
        arc_node=np.array([[number[a.points[0]], number[a.points[-1]]] for a in arcs], np.int64),
        arc_loop=np.array([a.loop for a in arcs], np.int64),
        arc_loop_start=np.array([a.loop_start for a in arcs]),
        arc_offset=_offsets(len(a.points) for a in arcs),
        arc_point=positions[chain],
        arc_point_face=origin[np.array(faces, np.int64)],
        side_offset=_offsets(len(s) for s in sides),
        side_halfarc=np.array([h for s in sides for h in s], np.int64),
    )


def _node_valences(constraints, graph, arc_graph, points):
    """Quads that meet at each node, and whether it lies on the boundary."""
    walls = {p for arc in arc_graph.arcs if arc.loop >= 0 for p in arc.points}
    inserted = dict(zip(graph.lines.inserted.tolist(), graph.lines.inserted_index.tolist()))
    valence = []
    for point in points:
        if point not in walls:
            valence.append(4 - inserted.get(point, 0))
        elif point < len(constraints.block_count):
            valence.append(int(constraints.block_count[point]))
        else:
            valence.append(2)
    return np.array(valence, np.int64), np.array([p in walls for p in points], bool)


def _offsets(counts) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(list(counts))]).astype(np.int64)
