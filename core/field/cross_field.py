"""The cross-field on a surface: an angle at each vertex, and how the cross turns along each edge.

A cross is an angle modulo pi / 2 in the frame of its vertex. Along an interior edge it turns by the
smallest angle that takes one cross onto the other (section 3.1.1 of the paper, but by the intrinsic
transport of `TriangleSurface`, which keeps index sums exact). Along a boundary edge the branch
that is nearest to the wall at one end is joined to the branch nearest to it at the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..surface.surface import TriangleSurface
from .constraints import Constraints

QUARTER = np.pi / 2
# Radians within which a turn counts as half a quarter.
TIE = 1e-9


def wrap(angle):
    """The representative of an angle modulo pi / 2 in (-pi/4, pi/4]; float or float array."""
    return angle - QUARTER * np.ceil(angle / QUARTER - 0.5)


@dataclass(frozen=True)
class CrossField:
    """A cross at each vertex, with the matching between neighbours.

    angle     (V,) float64, radians against the frame of the vertex, a representative mod pi / 2
    rotation  (3F,) float64, omega: turn of the cross from tail to head of each halfedge against
              parallel transport; exactly opposite on twins
    turn      (3F,) int64, z: the cross against the halfedge at the head,
              angle[head] - reverse_angle - pi, exceeds that at the tail,
              angle[tail] - polar_angle, by rotation + turn * pi / 2
    index     (F,) int64, I: quarter turns of the cross round each triangle, curvature included;
              non-zero in singular triangles, whose valence is 4 - I
    wall      (3F,) int64, on boundary halfedges the branch that follows the wall: it makes the angle
              angle[tail] - polar_angle + wall * pi / 2 with it, on a smooth boundary less than 45
              degrees; 0 inside
    """

    angle: np.ndarray
    rotation: np.ndarray
    turn: np.ndarray
    index: np.ndarray
    wall: np.ndarray

    def direction(self, surface: TriangleSurface) -> np.ndarray:
        """(V, 3) float64, unit tangent vector of the branch `angle` at each vertex."""
        return direction_vectors(surface, self.angle)


def build_cross_field(
    surface: TriangleSurface, angle: np.ndarray, constraints: Constraints
) -> CrossField:
    """Match the crosses of neighbouring vertices and count the turns round each triangle.

    angle  (V,) float64, crosses in the frames of their vertices; on the boundary those of the
           constraints, else the sum of the indices is not what topology asks
    """
    angle = np.array(angle, np.float64)
    rotation = edge_rotations(surface, angle)
    wall = np.zeros(len(rotation), np.int64)
    border = surface.loop_halfedges
    rotation[border], wall[border] = _boundary_rotations(surface, angle, constraints)
    at_tail = angle[surface.tail] - surface.polar_angle
    at_head = angle[surface.head] - surface.reverse_angle - np.pi
    total = rotation.reshape(-1, 3).sum(1) + surface.face_curvature
    index = np.rint(total / QUARTER).astype(np.int64)
    _share_out_sharp_indices(surface, rotation, index)
    turn = np.rint((at_head - at_tail - rotation) / QUARTER).astype(np.int64)
    return CrossField(angle, rotation, turn, index, wall)


def _share_out_sharp_indices(surface: TriangleSurface, rotation, index):
    """Two singularities in place of one round which only two quads or fewer would meet; in place.

    At pointed tips the index is 2 or more, but no quad mesh has inner vertices of fewer than three
    quads. A quarter turn more along one edge of the triangle hands an index of 1 to the triangle
    beside it. The edge is the one along which the cross turns the least then.
    """
    for face in np.flatnonzero(index >= 2).tolist():
        while index[face] >= 2:
            halfedge = 3 * face + np.arange(3)
            twin = surface.twin[halfedge]
            taken = (twin < 0) | (index[twin // 3] > 0)
            if taken.all():
                break
            chosen = np.argmax(np.where(taken, -np.inf, rotation[halfedge]))
            edge, other = halfedge[chosen], twin[chosen]
            rotation[edge] -= QUARTER
            rotation[other] += QUARTER
            index[face] -= 1
            index[other // 3] += 1


def edge_rotations(surface: TriangleSurface, angle: np.ndarray) -> np.ndarray:
    """(3F,) float64, smallest turn of the cross along each halfedge, in [-pi/4, pi/4].

    Exactly opposite on twins, even where the turn is half a quarter and both signs would do. Such a
    tie goes one way, however the angles are rounded.
    """
    edge, twin = surface.edges, surface.twin[surface.edges]
    tail, head = surface.tail[edge], surface.head[edge]
    smallest = wrap(angle[head] - angle[tail] - surface.transport[edge] - TIE) + TIE
    rotation = np.empty(len(surface.twin))
    rotation[edge] = smallest
    rotation[twin[twin >= 0]] = -smallest[twin >= 0]
    return rotation


def _boundary_rotations(surface, angle, constraints):
    """Turn of the branch that follows the wall and its number, for surface.loop_halfedges."""
    halfedge = surface.loop_halfedges
    tail, head = surface.tail[halfedge], surface.head[halfedge]
    # What the corner rule gives the wall's branch on leaving a vertex, and on arriving.
    symmetrical = 0.5 * (surface.angle_sum - constraints.block_count * QUARTER)
    leaving, arriving = constraints.lean + symmetrical, constraints.lean - symmetrical
    plain = angle[tail] - surface.polar_angle[halfedge]
    at_head = angle[head] - surface.reverse_angle[halfedge] - np.pi
    at_tail = leaving[tail] + wrap(plain - leaving[tail])
    at_head = arriving[head] + wrap(at_head - arriving[head])
    return at_head - at_tail, np.rint((at_tail - plain) / QUARTER).astype(np.int64)


def direction_vectors(surface: TriangleSurface, angle: np.ndarray) -> np.ndarray:
    """(V, 3) float64, unit tangent vectors that make the given angles in the vertices' frames.

    angle  (V,) float64, radians

    The direction is laid off in the triangle that it points into, then made perpendicular to the
    vertex normal. Outside the surface, at the boundary, the nearest triangle is continued.
    """
    middle = 0.5 * surface.angle_sum * surface.angle_scale
    angle = middle + (angle - middle + np.pi) % (2 * np.pi) - np.pi
    fan, vertex = surface.fan, np.arange(surface.vertex_count)
    stride = surface.polar_angle.max() + 4 * np.pi
    key = surface.tail[fan] * stride + surface.polar_angle[fan]
    slot = np.searchsorted(key, vertex * stride + angle, side="right") - 1
    slot = np.clip(slot, surface.fan_offset[:-1], surface.fan_offset[1:] - 1)
    halfedge = fan[slot]
    excess = ((angle - surface.polar_angle[halfedge]) / surface.angle_scale)[:, None]
    along = surface.points[surface.head[halfedge]] - surface.points
    across = np.cross(surface.face_normal[halfedge // 3], along)
    vector = np.cos(excess) * along + np.sin(excess) * across
    normal = surface.vertex_normal
    vector -= (vector * normal).sum(1, keepdims=True) * normal
    return vector / np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), 1e-300)
