"""Critical streamlines: the motorcycle graph, and the full streamlines of the paper.

All lines start together, from the ports of singularities and boundary corners, and advance triangle
by triangle in the order of their lengths. In the motorcycle graph a line ends where it meets a
line of the other family (method of section 3.4 of the paper, made finite); as full streamlines
they cross and run on to the boundary, until a limit of length or of turning, after which they end
at the next line. Lines of one family never cross, and none leaves through a wall that it runs
along: such a line is pushed aside into the nearest gap.

A loop over lines and the triangles that they cross is inherent here: it touches a few thousand of
them, whatever the size of the mesh is otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from heapq import heappop, heappush
from math import atan2, hypot, inf, pi

import numpy as np

from ..errors import Cancelled, LayoutError
from .cells import NodeKind
from .face_subdivision import (
    MARGIN,
    SplitFace,
    aim,
    between,
    misfit,
    split_polygon,
    tag_line,
    way_out,
)
from .line_field import LineField, Port

# A line that has passed through one triangle this often is winding round and round.
MOST_PASSES = 12
# Ends of lines on both sides of a cut that are this near, in edge lengths, are one node.
SAME_PLACE = 1e-6

PLAIN, BASE, STEM = 0, 1, 2


class LineTrapped(LayoutError):
    """Lines wind between their own tracks for ever; `faces` are triangles of the surface there."""

    def __init__(self, faces):
        super().__init__(
            "A line of the layout spirals without end; add a guide or use another relaxation."
        )
        self.faces = tuple(faces)


class _NoWayOn(Exception):
    """The line that is being advanced is trapped."""


@dataclass
class Line:
    """One streamline while it is traced.

    points   point numbers, start to end
    roles    for each of them PLAIN, BASE (another line ends or crosses here) or STEM (this line
             ends, crosses or starts here at another one)
    faces    triangle of the LineField that holds each segment
    """

    number: int
    points: list
    roles: list
    face: int
    branch: int
    angle: float | None
    barred: tuple
    entry: tuple | None = None
    faces: list = field(default_factory=list)
    length: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True)
class Meeting:
    """A node where lines meet: its kind, and whether the stem comes from the base's left."""

    kind: NodeKind
    from_left: bool


class LineGraph:
    """The lines laid so far and the triangles that they have cut.

    lines       LineField
    tracks      list of Line, in order of their start
    splits      dict triangle -> SplitFace, the triangles that some line crosses
    meetings    dict point -> Meeting
    walls       dict boundary halfedge -> list of (parameter, point), points that divide it
    vertex_lines dict vertex -> numbers of the lines that start there, counter-clockwise
    across      dict point on a wall -> the point at the same place on the other side of a cut
    """

    def __init__(self, lines: LineField, crossing_limits=None, cancelled=None):
        self.lines = lines
        self.tracks: list[Line] = []
        self.splits: dict[int, SplitFace] = {}
        self.meetings: dict[int, Meeting] = {}
        self.walls: dict[int, list] = {}
        self.vertex_lines: dict[int, list] = {}
        self.across: dict[int, int] = {}
        self._new_points: list = []
        self._queue: list = []
        self._passes: dict = {}
        self._limits = crossing_limits
        self._cancelled = cancelled or (lambda: False)
        self._grain = 1e-7 * float(np.linalg.norm(np.ptp(lines.point, axis=0)))

    # ---------------------------------------------------------------- points and triangles

    def point(self, number: int) -> list:
        """Position of a point, a list of three."""
        first_new = len(self.lines.point)
        if number < first_new:
            return self.lines.point[number].tolist()
        return self._new_points[number - first_new]

    @property
    def positions(self) -> np.ndarray:
        """(n, 3) float64, mesh vertices and then the points of lines."""
        return np.concatenate([self.lines.point, np.array(self._new_points).reshape(-1, 3)])

    def split(self, face: int) -> SplitFace:
        if face not in self.splits:
            self.splits[face] = SplitFace(self.lines, face)
        return self.splits[face]

    def _add_point(self, position) -> int:
        self._new_points.append(position)
        return len(self.lines.point) + len(self._new_points) - 1

    # ---------------------------------------------------------------- starting lines

    def start_at_port(self, port: Port) -> None:
        """Queue the line of one port; ports of a vertex must come counter-clockwise."""
        face, side = divmod(port.halfedge, 3)
        split = self.split(face)
        line = Line(
            len(self.tracks), [port.vertex], [PLAIN], face,
            port.branch - split.branch_shift[side], split.edge_angle[side] + port.angle,
            barred=(side, (side + 2) % 3),
        )
        self.vertex_lines.setdefault(port.vertex, []).append(line.number)
        self._enqueue(line)

    def start_at_wall(self, halfedge: int, parameter: float) -> None:
        """Queue a line that leaves a boundary halfedge at right angles, at a plain point."""
        face, side = divmod(halfedge, 3)
        split = self.split(face)
        point = self._mark_wall(halfedge, parameter)
        self.meetings[point] = Meeting(NodeKind.REGULAR, True)
        inward = split.wall_exit[side] + 2
        self._enqueue(
            Line(len(self.tracks), [point], [PLAIN], face, inward, None, (side,), (side, parameter))
        )

    def _mark_wall(self, halfedge, parameter, position=None) -> int:
        """Divide a boundary halfedge by a new point."""
        face, side = divmod(halfedge, 3)
        split = self.split(face)
        first, second = self._wall_interval(halfedge, parameter)
        polygon, number = split.polygon_with_side(first, second, on_line=False)
        place = split.on_side(side, parameter)
        point = self._add_point(position or split.lift(place))
        split.place[point] = place
        polygon.insert(number, point)
        self.walls.setdefault(halfedge, []).append((parameter, point))
        return point

    def mark_across(self, other_side) -> None:
        """Give every point on a wall of a cut its like on the other side, where none is yet.

        other_side  (3F',) int64, for each halfedge of the LineField the one across the cut, or -1
        """
        for halfedge in list(self.walls):
            beyond = int(other_side[halfedge])
            if beyond < 0:
                continue
            for parameter, point in list(self.walls[halfedge]):
                if point in self.across:
                    continue
                there = self._point_at(beyond, 1.0 - parameter)
                if there is None:
                    there = self._mark_wall(beyond, 1.0 - parameter, self.point(point))
                self.across[point], self.across[there] = there, point

    def _point_at(self, halfedge, parameter):
        """A point of a line at this place on a wall that has none like it across yet, or None."""
        for other, point in self.walls.get(halfedge, []):
            if abs(other - parameter) < SAME_PLACE and point not in self.across:
                return point
        return None

    def start_between(self, face: int, first: int, second: int) -> None:
        """Queue a line that leaves a wall or a track to its left, half-way between two points."""
        split = self.split(face)
        try:
            polygon, number = split.polygon_with_side(first, second, on_line=True)
        except KeyError:
            polygon, number = split.polygon_with_side(first, second, on_line=False)
            tag, middle = polygon.tags[number], between(split, polygon, number, 0.5)
            self.start_at_wall(3 * face + tag, split.side_parameter(tag, middle))
        else:
            self._start_at_chord(split, polygon, number)

    def _start_at_chord(self, split: SplitFace, polygon, number: int) -> None:
        """Queue a line that leaves a chord, a side of the polygon, to its left at half its length."""
        face, tag = split.face, polygon.tags[number]
        first, second = polygon.points[number], polygon.points[(number + 1) % len(polygon.points)]
        (x0, y0), (x1, y1) = split.place[first], split.place[second]
        place = ((x0 + x1) / 2, (y0 + y1) / 2)
        point = self._divide_chord(split, polygon, number, place, NodeKind.JUNCTION)
        left = atan2(y1 - y0, x1 - x0) + pi / 2
        inward = split.exit_branch(tag) + 2
        self._enqueue(Line(len(self.tracks), [point], [STEM], face, inward, left, (tag,)))

    def _enqueue(self, line):
        self.tracks.append(line)
        self._wait(line)

    def _wait(self, line):
        # Lengths that differ by rounding only count as equal: the same graph at any scale.
        heappush(self._queue, (round(line.length / self._grain), line.number))

    # ---------------------------------------------------------------- running

    def run(self) -> None:
        """Advance all queued lines to their ends, always the shortest one first.

        Raises LineTrapped with all the places where lines are trapped, Cancelled.
        """
        count, trapped = 0, {}
        while self._queue:
            _, number = heappop(self._queue)
            line = self.tracks[number]
            try:
                if self._advance(line):
                    self._wait(line)
            except _NoWayOn:
                # Lines that wind side by side need one barrier only.
                if not any((other, line.face) in self._passes for other in trapped):
                    trapped[number] = int(self.lines.origin_face[line.face])
            count += 1
            if count % 256 == 0 and self._cancelled():
                raise Cancelled("The decomposition was cancelled.")
        if trapped:
            raise LineTrapped(sorted(set(trapped.values())))

    def _advance(self, line: Line) -> bool:
        """Take a line through one triangle; False when it has ended."""
        split = self.split(line.face)
        self._count_pass(line)
        angle = self._heading(line, split)
        polygon, start = self._starting_polygon(line, split, angle)
        while True:
            side, share, angle = aim(split, polygon, start, angle)
            side, share = self._admissible(line, split, polygon, start, side, share)
            tag = polygon.tags[(start + side) % len(polygon.tags)]
            place = between(split, polygon, start + side, share)
            self._measure(line, split, place)
            if tag < 3:
                return self._leave(line, split, polygon, start, side, tag, place)
            polygon = self._meet(line, split, polygon, start, side, tag, place)
            if polygon is None:
                return False
            start = polygon.points.index(line.points[-1])
            line.barred = (tag,)

    def _count_pass(self, line):
        key = (line.number, line.face)
        passes = self._passes[key] = self._passes.get(key, 0) + 1
        if passes > MOST_PASSES and self._limits is not None:
            # A full streamline may wind; from here on it ends at the next line.
            line.turn = inf
        if passes > MOST_PASSES * (1 if self._limits is None else 2):
            raise _NoWayOn

    def _heading(self, line, split) -> float:
        """Direction of the next chord in the plane of the triangle, by Heun's method."""
        if line.entry is None:
            return line.angle
        side, parameter = line.entry
        start = split.on_side(side, parameter)
        first = heading = split.field_angle(side, parameter, line.branch)
        left_by = split.ray_exit(start, first, side)
        for _ in range(2):
            if left_by is None:
                return first
            turn = split.field_angle(*left_by, line.branch) - first
            turn = (turn + pi) % (2 * pi) - pi
            heading = first + 0.5 * min(max(turn, -1.0), 1.0)
            again = split.ray_exit(start, heading, side)
            if again is not None and again[0] == left_by[0]:
                line.turn += abs(turn)
                return heading
            left_by = again
        # Two sides take turns: a mean with the field far away would lead round their vertex.
        return first

    def _starting_polygon(self, line, split, angle):
        """The polygon that the next chord cuts, and which of its corners the line stands on."""
        point = line.points[-1]
        found = [(p, p.points.index(point)) for p in split.polygons if point in p.points]
        if len(found) == 1:
            return found[0]
        if line.entry is None and point < len(self.lines.point):
            # Ports of a vertex start counter-clockwise: the wedge left of all earlier ones.
            return next(f for f in found if f[0].tags[f[1] - 1] == line.barred[1])
        return min(found, key=lambda f: misfit(split, *f, angle))

    def _admissible(self, line, split, polygon, start, side, share):
        """The side to leave by and where: as aimed at, or the nearest way out for the line.

        Ways out are lines of the other family that it may cross, the wall that it runs against, and
        the pieces of inner sides where the field crosses outwards as the line does. As the field has
        no singularity in a triangle, every polygon has one, and no line winds round a vertex. Two
        lines that meet head-on may leave only the side of entry itself: there the line turns back.
        """
        count = len(polygon.points)
        left_first = share > 0.5
        order = [side]
        for distance in range(1, count):
            order += [side + distance, side - distance][:: 1 if left_first else -1]
        for strict in (True, False):
            for number in order:
                if not 0 <= number < count:
                    continue
                gap = way_out(split, polygon, (start + number) % count, line, strict)
                if gap is not None:
                    wish = share if number == side else float(number < side)
                    room = MARGIN * (gap[1] - gap[0])
                    return number, min(max(wish, gap[0] + room), gap[1] - room)
        raise _NoWayOn

    def _measure(self, line, split, place):
        x, y = split.place[line.points[-1]]
        line.length += hypot(place[0] - x, place[1] - y)

    # ---------------------------------------------------------------- events

    def _leave(self, line, split, polygon, start, side, tag, place) -> bool:
        """Leave the triangle through its side `tag`; False when that is the boundary."""
        halfedge = 3 * split.face + tag
        number = (start + side) % len(polygon.points)
        ends = polygon.points[number], polygon.points[(number + 1) % len(polygon.points)]
        parameter = split.side_parameter(tag, place)
        point = self._add_point(split.lift(place))
        split.place[point] = place
        self._lay_chord(line, split, polygon, start, side, point)
        twin = int(self.lines.twin[halfedge])
        if twin < 0:
            self.walls.setdefault(halfedge, []).append((parameter, point))
            self.meetings[point] = Meeting(NodeKind.WALL, True)
            return False
        face, entry = divmod(twin, 3)
        neighbour = self.split(face)
        neighbour.place[point] = neighbour.on_side(entry, 1.0 - parameter)
        across, opposite = neighbour.polygon_with_side(ends[1], ends[0], on_line=False)
        across.insert(opposite, point)
        line.branch += split.branch_shift[tag] + int(self.lines.twin_branch[halfedge])
        line.branch -= neighbour.branch_shift[entry]
        line.face, line.entry, line.angle = face, (entry, 1.0 - parameter), None
        line.barred = (entry,)
        return True

    def _meet(self, line, split, polygon, start, side, tag, place):
        """End on a line of the other family, or cross it: then the polygon beyond is returned."""
        number = (start + side) % len(polygon.points)
        runs_on = self._limits is not None and (
            line.length < self._limits[0] and line.turn < self._limits[1]
        )
        kind = NodeKind.CROSSING if runs_on else NodeKind.JUNCTION
        ends = polygon.points[number], polygon.points[(number + 1) % len(polygon.points)]
        beyond, opposite = split.polygon_with_side(ends[1], ends[0], on_line=True)
        point = self._mark_base(split, ends, place, tag, kind)
        beyond.insert(opposite, point)
        self._lay_chord(line, split, polygon, start, side, point)
        line.roles[-1] = STEM
        return beyond if runs_on else None

    def _lay_chord(self, line, split, polygon, start, side, point):
        split_polygon(split, polygon, start, side, point, line.number, line.branch)
        line.points.append(point)
        line.roles.append(PLAIN)
        line.faces.append(split.face)

    def _mark_base(self, split, ends, place, tag, kind) -> int:
        """A new point on the track between two of its points, where another line meets it."""
        point = self._add_point(split.lift(place))
        split.place[point] = place
        base = self.tracks[tag_line(tag)]
        at, forward = _segment(base.points, *ends)
        base.points.insert(at + 1, point)
        base.roles.insert(at + 1, BASE)
        base.faces.insert(at, split.face)
        self.meetings[point] = Meeting(kind, forward)
        return point

    def _divide_chord(self, split, polygon, number, place, kind) -> int:
        ends = polygon.points[number], polygon.points[(number + 1) % len(polygon.points)]
        beyond, opposite = split.polygon_with_side(ends[1], ends[0], on_line=True)
        point = self._mark_base(split, ends, place, polygon.tags[number], kind)
        beyond.insert(opposite, point)
        polygon.insert(number, point)
        return point

    def _wall_interval(self, halfedge, parameter):
        """The points on a boundary halfedge next to a parameter, before and after it."""
        face, side = divmod(halfedge, 3)
        vertices = self.lines.triangle[face]
        marks = [(0.0, int(vertices[side])), *sorted(self.walls.get(halfedge, []))]
        marks.append((1.0, int(vertices[side - 2])))
        for (low, first), (high, second) in zip(marks, marks[1:]):
            if low < parameter < high:
                return first, second
        raise LayoutError("Two lines start at one point of the boundary; move one of them.")


def _segment(points, first, second):
    """Where two points follow each other in a track: (position of the earlier, first is it)."""
    for at in range(len(points) - 1):
        if points[at] == first and points[at + 1] == second:
            return at, True
        if points[at] == second and points[at + 1] == first:
            return at, False
    raise KeyError((first, second))
