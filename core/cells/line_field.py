"""The cross-field as streamlines read it: angles and branch numbers on halfedges, and the ports.

The field lives on edges. At parameter t of halfedge h, branch b of the cross makes the angle

    relative_angle[h] + t * rotation[h] + b * pi / 2

with the halfedge, counter-clockwise. Both triangles of an edge read the same numbers, so the field
is continuous across edges by construction. Branch numbers change from halfedge to halfedge by
integers known beforehand: nothing is ever matched by the size of an angle while tracing.

Singular points, and regular points where lines are to start, become vertices: their triangle is
split into three, and round the new vertex the cross turns at a constant rate in each of the three
sectors (section 3.4 of the paper), with no rotation along the spokes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..field.cross_field import CrossField
from ..field.singularities import incenters
from ..surface.surface import (
    TriangleSurface,
    corner_angles,
    match_twins,
    next_halfedge,
    previous_halfedge,
)

QUARTER = np.pi / 2
# A port this near to a spoke, in radians, counts as on it whatever way it is rounded.
ON_SPOKE = 1e-7


@dataclass(frozen=True)
class LineField:
    """The surface with the start points inserted, and the field on its halfedges.

    point           (V', 3) float64; the inserted points come last
    triangle        (F', 3) int64
    origin_face     (F',) int64, triangle of the surface that each triangle is a piece of
    twin            (3F',) int64, -1 on the boundary
    corner_angle    (3F',) float64, unscaled angle at the tail of each halfedge
    relative_angle  (3F',) float64, cross at the tail against the halfedge, branch 0
    rotation        (3F',) float64, change of that angle from tail to head
    next_branch     (3F',) int64, add it to a branch number on h to get that on the next halfedge
    twin_branch     (3F',) int64, add it to a branch number on h to get that on its twin
    inserted        (S,) int64, the inserted vertices
    inserted_index  (S,) int64, field index I of each
    halfedge_number (3F,) int64, number here of each halfedge of the surface
    wall            (3F',) int64, branch that follows the wall on boundary halfedges, 0 inside
    """

    point: np.ndarray
    triangle: np.ndarray
    origin_face: np.ndarray
    twin: np.ndarray
    corner_angle: np.ndarray
    relative_angle: np.ndarray
    rotation: np.ndarray
    next_branch: np.ndarray
    twin_branch: np.ndarray
    inserted: np.ndarray
    inserted_index: np.ndarray
    halfedge_number: np.ndarray
    wall: np.ndarray

    @cached_property
    def _by_tail(self):
        """Halfedges sorted by tail, and where those of each vertex begin."""
        tail = self.triangle.ravel()
        count = np.bincount(tail, minlength=len(self.point))
        return np.argsort(tail, kind="stable"), np.concatenate([[0], np.cumsum(count)])

    def leaving(self, vertex: int) -> np.ndarray:
        """(n,) int64, the halfedges that leave a vertex, in no particular order."""
        order, offset = self._by_tail
        return order[offset[vertex] : offset[vertex + 1]]


@dataclass(frozen=True)
class Port:
    """The start of one line at a vertex.

    vertex     vertex of the LineField
    halfedge   leaves the vertex; the line starts in the triangle on its left
    angle      radians from that halfedge, counter-clockwise, within the triangle's corner
    branch     branch number of the line on that halfedge
    """

    vertex: int
    halfedge: int
    angle: float
    branch: int


def build_line_field(surface: TriangleSurface, field: CrossField, faces) -> LineField:
    """Insert a point into each of the given triangles and set up the field on halfedges.

    faces  (S,) int64, distinct; must contain every triangle of non-zero index
    """
    faces = np.asarray(faces, np.int64)
    split = _split_faces(surface, faces)
    triangle, origin_face, spoke_angle = split
    count = surface.face_count
    center = np.arange(surface.vertex_count, surface.vertex_count + len(faces))
    # The incentre sees every side under more than a right angle: ports never crowd together.
    point = np.concatenate([surface.points, incenters(surface, faces)])
    tail, head = triangle.ravel(), np.roll(triangle, -1, axis=1).ravel()
    twin = match_twins(tail, head, len(point))
    relative = np.empty(len(tail))
    rotation = np.zeros(len(tail))
    keep = np.ones(count, bool)
    keep[faces] = False
    plain = field.angle[surface.tail] - surface.polar_angle
    old = (3 * np.flatnonzero(keep)[:, None] + np.arange(3)).ravel()
    relative[: len(old)], rotation[: len(old)] = plain[old], field.rotation[old]
    # Piece (face, side): corners (tail, head, centre); halfedges outer, inward, outward.
    outer = (3 * faces[:, None] + np.arange(3)).ravel()
    outer_new = len(old) + 3 * np.arange(len(outer))
    relative[outer_new], rotation[outer_new] = plain[outer], field.rotation[outer]
    outward = outer_new + 2
    inward_at_tail = plain[outer] - spoke_angle * surface.angle_scale[surface.tail[outer]]
    relative[outward] = inward_at_tail - np.pi
    relative[twin[outward]] = inward_at_tail
    corner_angle = corner_angles(point, triangle)
    scale = np.ones(len(point))
    scale[: surface.vertex_count] = surface.angle_scale
    scaled_angle = corner_angle * scale[tail]
    next_branch = _next_branches(relative, rotation, scaled_angle)
    twin_branch = _twin_branches(relative, rotation, twin)
    # At the centre the cross turns within the sector, so the integer comes from the other two.
    next_branch[outer_new + 1] = -4 - next_branch[outer_new] - next_branch[outward]
    number = np.empty(3 * count, np.int64)
    number[old], number[outer] = np.arange(len(old)), outer_new
    wall = np.zeros(len(tail), np.int64)
    wall[number] = field.wall
    return LineField(
        point, triangle, origin_face, twin, corner_angle, relative, rotation,
        next_branch, twin_branch, center, field.index[faces], number, wall,
    )


def _split_faces(surface, faces):
    """Triangles with the given faces replaced by three; angle from each side to its spoke."""
    keep = np.ones(surface.face_count, bool)
    keep[faces] = False
    center = surface.vertex_count + np.arange(len(faces))
    corner = surface.triangles[faces]
    pieces = np.stack(
        [corner, np.roll(corner, -1, axis=1), np.repeat(center[:, None], 3, axis=1)], axis=2
    ).reshape(-1, 3)
    triangle = np.concatenate([surface.triangles[keep], pieces])
    origin = np.concatenate([np.flatnonzero(keep), np.repeat(faces, 3)])
    # The spoke to the incentre halves the corner.
    spoke_angle = 0.5 * surface.corner_angle[(3 * faces[:, None] + np.arange(3)).ravel()]
    return triangle, origin, spoke_angle


def _next_branches(relative, rotation, scaled_angle):
    following = next_halfedge(np.arange(len(relative)))
    turn = relative + rotation - np.pi + scaled_angle[following] - relative[following]
    return np.rint(turn / QUARTER).astype(np.int64)


def _twin_branches(relative, rotation, twin):
    turn = relative + rotation - np.pi - relative[twin]
    return np.where(twin >= 0, np.rint(turn / QUARTER), 0).astype(np.int64)


def inserted_ports(lines: LineField, number: int) -> list[Port]:
    """The 4 - I ports round inserted point `number`, counter-clockwise.

    Round the point the angle of the cross against the outward ray falls by (4 - I) pi/2 in all; a
    line leaves wherever it passes a multiple of pi/2.
    """
    spokes = _outward_spokes(lines, lines.inserted[number])
    count = 4 - int(lines.inserted_index[number])
    value, branch, start = [], [], 0
    position = 0.0
    for spoke in spokes:
        value.append(position)
        branch.append(start)
        drop, start = _sector_drop(lines, spoke, start)
        position -= drop
    first = float(lines.relative_angle[spokes[0]])
    value = first + np.array(value + [position])
    if np.any(np.diff(value) >= 0):
        # Only a point of extreme curvature does this: share the sectors out by angle.
        angle = np.cumsum([0.0] + [float(lines.corner_angle[s]) for s in spokes])
        value = first - count * QUARTER * angle / angle[-1]
    highest = np.floor(first / QUARTER + ON_SPOKE)
    ports = [
        _port_at(lines, spokes, value, branch, (highest - k) * QUARTER) for k in range(count)
    ]
    return _beside_walls(lines, spokes, ports)


def _beside_walls(lines, spokes, ports):
    """The ports with those that run along a wall moved out of its sector, counter-clockwise.

    Where a sector ends in the boundary only a line that runs against it may start there.
    """
    placed = []
    for port in ports:
        sector, outer = spokes.index(port.halfedge), next_halfedge(port.halfedge)
        on_wall = port.branch + lines.next_branch[port.halfedge]
        quarter = int(on_wall - lines.wall[outer]) % 4
        if lines.twin[outer] < 0 and quarter != 3:
            late = port.angle > 0.5 * lines.corner_angle[port.halfedge]
            step = 1 if quarter == 0 or (quarter == 1 and late) else -1
            sector = (sector + step) % 3
            port = _across_spoke(lines, port, spokes[sector], step)
        placed.append((sector, port.angle, port))
    return [port for _, _, port in sorted(placed, key=lambda entry: entry[:2])]


def _across_spoke(lines, port, spoke, step):
    """A port moved just across the next spoke (step 1) or the one before (-1) to another sector."""
    if step == 1:
        branch, angle = _on_next_spoke(lines, port.halfedge, port.branch), 1e-3
    else:
        branch, angle = port.branch - _on_next_spoke(lines, spoke, 0), 1.0 - 1e-3
    return Port(port.vertex, int(spoke), float(angle * lines.corner_angle[spoke]), int(branch))


def _on_next_spoke(lines, spoke, branch):
    """The number on the next spoke of a branch of this one, passed on round the sector's outside."""
    outer = next_halfedge(spoke)
    inward = next_halfedge(outer)
    shift = lines.next_branch[spoke] + lines.next_branch[outer] + lines.twin_branch[inward]
    return branch + shift


def _outward_spokes(lines, vertex):
    """The three halfedges that leave an inserted vertex, counter-clockwise."""
    first = int(lines.leaving(vertex)[0])
    spokes = [first]
    for _ in range(2):
        spokes.append(int(lines.twin[previous_halfedge(spokes[-1])]))
    return spokes


def _sector_drop(lines, spoke, branch):
    """How far the angle against the outward ray falls over the sector on the left of a spoke.

    Also the number, on the next spoke, of the branch that has this number here.
    """
    outer = next_halfedge(spoke)
    inward = next_halfedge(outer)
    on_next = _on_next_spoke(lines, spoke, branch)
    here = lines.relative_angle[spoke] + branch * QUARTER
    there = lines.relative_angle[lines.twin[inward]] + on_next * QUARTER
    expected = lines.corner_angle[spoke] - lines.rotation[outer]
    turns = np.rint((here - there - expected) / (2 * np.pi))
    return float(here - there - turns * 2 * np.pi), int(on_next + 4 * turns)


def _port_at(lines, spokes, value, branch, target):
    sector = int(np.searchsorted(-value, ON_SPOKE - target, side="right")) - 1
    sector = min(max(sector, 0), 2)
    fraction = (value[sector] - target) / (value[sector] - value[sector + 1])
    spoke = spokes[sector]
    # Branch b has angle value[sector] + (b - branch[sector]) * pi/2: the line's branch is outward.
    number = branch[sector] - int(round(target / QUARTER))
    angle = float(np.clip(fraction, 0.0, 1.0) * lines.corner_angle[spoke])
    return Port(int(lines.triangle.ravel()[spoke]), int(spoke), angle, number)


def corner_ports(surface, lines: LineField, cross_angle, vertex: int, blocks: int) -> list[Port]:
    """The blocks - 1 ports of a boundary vertex, counter-clockwise, at multiples of Theta/blocks.

    A port stays in the triangle that its branch of the cross points into.

    cross_angle  angle of branch 0 in the frame of the vertex, radians
    """
    fan = _line_fan(lines, vertex)
    total = float(surface.angle_sum[vertex])
    reach = np.concatenate([[0.0], np.cumsum(lines.corner_angle[fan])])
    ports = []
    for number in range(1, blocks):
        direction = total / 2 + (number - blocks / 2) * QUARTER
        branch = int(np.rint((direction - cross_angle) / QUARTER))
        # The triangle must be the one that the field points into; within it the fan is even.
        sector = int(np.searchsorted(reach, direction + ON_SPOKE, side="right")) - 1
        sector = min(sector, len(fan) - 1)
        even = np.clip(total * number / blocks, reach[sector], reach[sector + 1])
        ports.append(Port(vertex, int(fan[sector]), float(even - reach[sector]), branch))
    return ports


def _line_fan(lines, vertex):
    """Halfedges leaving a boundary vertex, counter-clockwise from the boundary halfedge."""
    leaving = lines.leaving(vertex)
    halfedge = int(leaving[lines.twin[leaving] < 0][0])
    fan = [halfedge]
    while True:
        halfedge = int(lines.twin[previous_halfedge(fan[-1])])
        if halfedge < 0:
            return np.array(fan)
        fan.append(halfedge)
