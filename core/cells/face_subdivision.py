"""Triangles cut by line after line into convex polygons, without a tolerance.

Each triangle that a line crosses keeps the polygons into which its chords have cut it. A new chord
splits the one polygon that it starts in; the side that it leaves by follows from the directions to
that polygon's corners, so that no two chords can cross unnoticed and no point can fall between
sides. Points are numbers: mesh vertices first, points on edges and chords after them.

A side of a polygon carries a tag: 0, 1 or 2 for a piece of that side of the triangle, or
`chord_tag(line, exit)` for a piece of a line. `exit` is the one branch (modulo 4, numbered on side 0
of the triangle) that may leave the polygon there: the branch of the line turned a quarter towards
the far side. Two lines of one family never match, so they never cross; and no line can be crossed
backwards. The same holds for walls, which makes four corners a certainty.
"""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin

from .line_field import QUARTER, LineField

# A new point keeps this share of the side it divides on either hand: polygons stay usable.
MARGIN = 0.02
# A ray that passes a point at less than this share of the polygon's size runs straight at it.
STRAIGHT_AT = 1e-6
# A way out that is a smaller share than this of a side is none.
SMALLEST_GAP = 1e-6


def chord_tag(line: int, exit_branch: int) -> int:
    return 3 + 4 * line + exit_branch % 4


def tag_line(tag: int) -> int:
    return (tag - 3) // 4


class Polygon:
    """A convex piece of a triangle: point numbers counter-clockwise, tag of the side after each."""

    __slots__ = ("points", "tags")

    def __init__(self, points: list, tags: list):
        self.points = points
        self.tags = tags

    def insert(self, side: int, point: int) -> None:
        """Put a point into a side; both parts keep its tag."""
        self.points.insert(side + 1, point)
        self.tags.insert(side + 1, self.tags[side])

    def side_from(self, first: int, second: int, on_line: bool) -> int:
        """Number of the side from one point to another, -1 if there is none.

        on_line  a piece of a line is meant, else one of the triangle: where a line turned back to
                 its side of entry, both join the same points
        """
        count = len(self.points)
        for side, point in enumerate(self.points):
            if (point, self.points[(side + 1) % count]) != (first, second):
                continue
            if (self.tags[side] >= 3) == on_line:
                return side
        return -1


class SplitFace:
    """One triangle: its flat coordinates, its field, its polygons.

    The triangle lies in the plane with corner 0 at the origin and side 0 along x. `edge_angle` is
    the direction of each side there, `branch_shift` what to add to a branch number on side 0 to
    get it on each side.
    """

    __slots__ = (
        "face", "corner", "edge_angle", "relative", "rotation", "branch_shift", "wall_exit",
        "place", "polygons", "origin", "axes",
    )

    def __init__(self, lines: LineField, face: int):
        first = 3 * face
        vertices = lines.triangle[face].tolist()
        self.face = face
        self.corner, self.origin, self.axes = _flatten(lines.point[lines.triangle[face]].tolist())
        self.edge_angle = [
            atan2(self.corner[k - 2][1] - self.corner[k][1], self.corner[k - 2][0] - self.corner[k][0])
            for k in range(3)
        ]
        self.relative = lines.relative_angle[first : first + 3].tolist()
        self.rotation = lines.rotation[first : first + 3].tolist()
        shift = lines.next_branch[first : first + 3].tolist()
        self.branch_shift = [0, shift[0], shift[0] + shift[1]]
        twin = lines.twin[first : first + 3].tolist()
        # The branch that points out through a boundary side, a quarter right of the wall's own.
        wall = lines.wall[first : first + 3].tolist()
        self.wall_exit = [
            wall[k] - 1 - self.branch_shift[k] if twin[k] < 0 else None for k in range(3)
        ]
        self.place = dict(zip(vertices, self.corner))
        self.polygons = [Polygon(vertices, [0, 1, 2])]

    def field_angle(self, side: int, parameter: float, branch: int) -> float:
        """Direction of a branch (numbered on side 0) at a point of a side, in the plane."""
        turn = self.relative[side] + parameter * self.rotation[side]
        return self.edge_angle[side] + turn + (branch + self.branch_shift[side]) * QUARTER

    def side_parameter(self, side: int, place) -> float:
        """Where a flat point lies on a side, 0 at its tail and 1 at its head."""
        (x0, y0), (x1, y1) = self.corner[side], self.corner[side - 2]
        along = (place[0] - x0) * (x1 - x0) + (place[1] - y0) * (y1 - y0)
        return along / ((x1 - x0) ** 2 + (y1 - y0) ** 2)

    def on_side(self, side: int, parameter: float):
        (x0, y0), (x1, y1) = self.corner[side], self.corner[side - 2]
        return (x0 + parameter * (x1 - x0), y0 + parameter * (y1 - y0))

    def lift(self, place):
        """The point in space of a flat point."""
        return [
            o + place[0] * u + place[1] * v for o, u, v in zip(self.origin, *self.axes)
        ]

    def exit_branch(self, tag: int):
        """The branch (modulo 4) that may leave through a side with this tag; None: any."""
        if tag >= 3:
            return (tag - 3) % 4
        return None if self.wall_exit[tag] is None else self.wall_exit[tag] % 4

    def outward(self, side: int, branch: int):
        """The parameters of a side (low, high) at which a branch points out of the triangle.

        For inner sides; branch is numbered on side 0 of the triangle. None where it points inwards
        everywhere.
        """
        turn = self.rotation[side]
        first = self.relative[side] + (branch + self.branch_shift[side]) * QUARTER
        # Outwards is between -pi and 0 against the side; the turn is far less than that.
        first = (first + 0.5 * turn + 1.5 * pi) % (2 * pi) - 1.5 * pi - 0.5 * turn
        if turn == 0.0:
            return (0.0, 1.0) if -pi < first < 0.0 else None
        ends = sorted(((-pi - first) / turn, -first / turn))
        low, high = max(ends[0], 0.0), min(ends[1], 1.0)
        return (low, high) if high > low else None

    def ray_exit(self, start, angle: float, entry: int):
        """Side and parameter where a ray from a point of side `entry` (-1: inside) leaves."""
        dx, dy = cos(angle), sin(angle)
        cross = [dx * (y - start[1]) - dy * (x - start[0]) for x, y in self.corner]
        best = None
        for side in range(3):
            right, left = cross[side], cross[side - 2]
            if side != entry and right <= 0.0 < left:
                best = (side, -right / (left - right))
        return best

    def polygon_with_side(self, first: int, second: int, on_line: bool):
        """The polygon, and its side number, with a side from one point to the other."""
        for polygon in self.polygons:
            side = polygon.side_from(first, second, on_line)
            if side >= 0:
                return polygon, side
        raise KeyError((self.face, first, second))


def _flatten(corner):
    """Planar coordinates of a triangle's corners, lengths kept; origin and axes in space."""
    a, b, c = corner
    ab = [q - p for p, q in zip(a, b)]
    ac = [q - p for p, q in zip(a, c)]
    length = hypot(*ab)
    along = [p / length for p in ab]
    x = sum(p * q for p, q in zip(along, ac))
    rest = [q - x * p for p, q in zip(along, ac)]
    y = max(hypot(*rest), 1e-300)
    return [(0.0, 0.0), (length, 0.0), (x, y)], a, (along, [p / y for p in rest])


def aim(split: SplitFace, polygon: Polygon, start: int, angle: float):
    """Where a ray from corner `start` of a polygon leaves it.

    Returns (side, share, angle): the side number counted from the start corner, 1 to n - 2, where
    along it, and the direction, turned into the polygon if it pointed out of it.
    """
    points = polygon.points[start:] + polygon.points[:start]
    x0, y0 = split.place[points[0]]
    offset = [(split.place[p][0] - x0, split.place[p][1] - y0) for p in points[1:]]
    angle = _turned_inside(offset, angle)
    dx, dy = cos(angle), sin(angle)
    cross = [dx * y - dy * x for x, y in offset]
    # A ray straight at a point passes it on its left, however the angle is rounded.
    near = STRAIGHT_AT * max(abs(x) + abs(y) for x, y in offset)
    for side in range(1, len(cross) - 1):
        if cross[side] > -near:
            break
    else:
        side = len(cross) - 1
    right, left = cross[side - 1], max(cross[side], 0.0)
    share = -right / (left - right) if left > right else 0.5
    return side, min(max(share, MARGIN), 1.0 - MARGIN), angle


def _turned_inside(offset, angle):
    """The nearest direction inside the wedge between the first and the last offset."""
    right = atan2(offset[0][1], offset[0][0])
    wedge = (atan2(offset[-1][1], offset[-1][0]) - right) % (2 * pi)
    turn = (angle - right) % (2 * pi)
    least = 1e-3 * wedge
    if turn > wedge:
        turn = wedge if turn - wedge < 2 * pi - turn else 0.0
    return right + min(max(turn, least), wedge - least)


def split_polygon(split, polygon: Polygon, start: int, side: int, point: int, line: int, branch: int):
    """Cut a polygon by a line's chord from its corner `start` to a new point on side `side`.

    side is counted from the start corner as `aim` does; branch is the line's, numbered on side 0 of
    the triangle. The polygon keeps the part right of the chord, a new one takes the left part.
    """
    points = polygon.points[start:] + polygon.points[:start]
    tags = polygon.tags[start:] + polygon.tags[:start]
    polygon.points = points[: side + 1] + [point]
    polygon.tags = tags[: side + 1] + [chord_tag(line, branch + 1)]
    left_tags = [chord_tag(line, branch - 1)] + tags[side:]
    split.polygons.append(Polygon([points[0], point] + points[side + 1 :], left_tags))


def way_out(split: SplitFace, polygon: Polygon, side: int, line, strict: bool):
    """Shares (low, high) of a polygon's side by which a line may leave; None: it may not.

    line    has `branch`, numbered on side 0 of the triangle, and `barred`, tags it may not leave by
    strict  inner sides count only where the field, too, crosses them outwards
    """
    tag = polygon.tags[side]
    if tag >= 3 or split.wall_exit[tag] is not None or not strict:
        open_to_it = tag not in line.barred and split.exit_branch(tag) in (None, line.branch % 4)
        return (0.0, 1.0) if open_to_it else None
    way = split.outward(tag, line.branch)
    if way is None:
        return None
    first, second = polygon.points[side], polygon.points[(side + 1) % len(polygon.points)]
    begin = split.side_parameter(tag, split.place[first])
    end = split.side_parameter(tag, split.place[second])
    if end <= begin:
        return None
    low, high = (max(min((t - begin) / (end - begin), 1.0), 0.0) for t in way)
    return (low, high) if high - low > SMALLEST_GAP else None


def between(split: SplitFace, polygon: Polygon, side: int, share: float):
    """The flat point that divides a side of a polygon; sides are counted round and round."""
    count = len(polygon.points)
    x0, y0 = split.place[polygon.points[side % count]]
    x1, y1 = split.place[polygon.points[(side + 1) % count]]
    return (x0 + share * (x1 - x0), y0 + share * (y1 - y0))


def misfit(split: SplitFace, polygon: Polygon, corner: int, angle: float) -> float:
    """How far a direction lies outside a corner of a polygon; negative inside."""
    x0, y0 = split.place[polygon.points[corner]]
    x1, y1 = split.place[polygon.points[(corner + 1) % len(polygon.points)]]
    x2, y2 = split.place[polygon.points[corner - 1]]
    right = atan2(y1 - y0, x1 - x0)
    half = 0.5 * ((atan2(y2 - y0, x2 - x0) - right) % (2 * pi))
    return abs((angle - right - half + pi) % (2 * pi) - pi) - half
