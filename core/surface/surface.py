"""The triangle surface that all stages read: connectivity, angles, intrinsic frames, transport.

Halfedge order: halfedge ``h = 3 * f + c`` runs from corner ``c`` to corner ``(c + 1) % 3`` of
triangle ``f``, which lies on its left. Angles are in radians. The frame of a vertex is intrinsic:
an angle is measured counter-clockwise from the vertex's first halfedge, with corner angles scaled
so that they add up to 2 pi inside; on the boundary they keep their true size.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import InputError
from ..unit_frame import largest_distance


def next_halfedge(halfedge):
    """The following halfedge of the same triangle; int or integer array."""
    return halfedge - 2 * (halfedge % 3 == 2) + (halfedge % 3 != 2)


def previous_halfedge(halfedge):
    """The preceding halfedge of the same triangle; int or integer array."""
    return halfedge + 2 * (halfedge % 3 == 0) - (halfedge % 3 != 0)


@dataclass(frozen=True)
class TriangleSurface:
    """An oriented, vertex- and edge-manifold triangle surface. Build it with `build_surface`.

    points          (V, 3) float64, every one used by a triangle
    triangles       (F, 3) int64, counter-clockwise
    tail, head      (3F,) int64, end vertices of each halfedge
    twin            (3F,) int64, the opposite halfedge, -1 on the boundary
    edge_length     (3F,) float64
    corner_angle    (3F,) float64, angle of the triangle at the tail of each halfedge
    angle_sum       (V,) float64, Theta: sum of the corner angles at a vertex
    angle_scale     (V,) float64, 2 pi / Theta inside, 1 on the boundary
    polar_angle     (3F,) float64, phi: direction of the halfedge in the frame of its tail
    reverse_angle   (3F,) float64, direction of the reversed halfedge in the frame of its head
    fan             (3F,) int64, all halfedges sorted by tail, counter-clockwise; on the boundary
                    the boundary halfedge comes first
    fan_offset      (V + 1,) int64, halfedges leaving v are fan[fan_offset[v]:fan_offset[v + 1]]
    loop_halfedges  (B,) int64, the boundary halfedges, loop after loop, each in walking order
                    (the surface on the left)
    loop_offset     (loops + 1,) int64
    component       (F,) int64, number of the connected component of each triangle
    """

    points: np.ndarray
    triangles: np.ndarray
    tail: np.ndarray
    head: np.ndarray
    twin: np.ndarray
    edge_length: np.ndarray
    corner_angle: np.ndarray
    angle_sum: np.ndarray
    angle_scale: np.ndarray
    polar_angle: np.ndarray
    reverse_angle: np.ndarray
    fan: np.ndarray
    fan_offset: np.ndarray
    loop_halfedges: np.ndarray
    loop_offset: np.ndarray
    component: np.ndarray

    @property
    def vertex_count(self) -> int:
        return len(self.points)

    @property
    def face_count(self) -> int:
        return len(self.triangles)

    @cached_property
    def derived(self) -> dict:
        """What other stages have built from this surface and keep for the next time, by name."""
        return {}

    @cached_property
    def on_boundary(self) -> np.ndarray:
        """(V,) bool."""
        mask = np.zeros(self.vertex_count, bool)
        mask[self.tail[self.loop_halfedges]] = True
        return mask

    @cached_property
    def edges(self) -> np.ndarray:
        """(E,) int64, one halfedge for each undirected edge: the smaller of the two."""
        halfedge = np.arange(len(self.twin))
        return halfedge[(self.twin < 0) | (halfedge < self.twin)]

    @cached_property
    def transport(self) -> np.ndarray:
        """(3F,) float64, r: an angle a at the tail becomes a + r at the head."""
        return self.reverse_angle + np.pi - self.polar_angle

    @cached_property
    def face_curvature(self) -> np.ndarray:
        """(F,) float64, K_f = sum of scaled corner angles - pi."""
        scaled = self.corner_angle * self.angle_scale[self.tail]
        return scaled.reshape(-1, 3).sum(1) - np.pi

    @cached_property
    def face_normal(self) -> np.ndarray:
        """(F, 3) float64, unit normals."""
        vector = self._area_vector
        return vector / np.maximum(np.linalg.norm(vector, axis=1, keepdims=True), 1e-300)

    @cached_property
    def face_area(self) -> np.ndarray:
        """(F,) float64."""
        return 0.5 * np.linalg.norm(self._area_vector, axis=1)

    @cached_property
    def _area_vector(self) -> np.ndarray:
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        return np.cross(b - a, c - a)

    @cached_property
    def vertex_normal(self) -> np.ndarray:
        """(V, 3) float64, unit normals weighted by corner angle."""
        weighted = np.repeat(self.face_normal, 3, axis=0) * self.corner_angle[:, None]
        total = np.stack(
            [np.bincount(self.tail, weighted[:, k], self.vertex_count) for k in range(3)], axis=1
        )
        return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-300)

    @cached_property
    def cotangent(self) -> np.ndarray:
        """(3F,) float64, cotangent of the angle opposite each halfedge."""
        opposite = self.corner_angle[previous_halfedge(np.arange(len(self.tail)))]
        return 1.0 / np.tan(np.clip(opposite, 1e-9, np.pi - 1e-9))

    @cached_property
    def euler_characteristic(self) -> int:
        return self.vertex_count - len(self.edges) + self.face_count

    @property
    def loop_count(self) -> int:
        return len(self.loop_offset) - 1

    @cached_property
    def component_count(self) -> int:
        return int(self.component.max()) + 1 if len(self.component) else 0

    @cached_property
    def diameter(self) -> float:
        """Twice the largest distance of a vertex from the mean of all, in object-space lengths."""
        return 2 * largest_distance(self.points, self.points.mean(0))

    @cached_property
    def mean_edge_length(self) -> float:
        return float(self.edge_length[self.edges].mean())


def build_surface(points, triangles) -> TriangleSurface:
    """Connectivity, angles and frames of a triangle mesh.

    points     (V, 3) float, every vertex used by some triangle
    triangles  (F, 3) int, consistently oriented, each edge in at most two triangles, one fan of
               triangles round each vertex (`cleaning.clean` sees to it)

    Raises InputError naming the first place where the mesh is not such a surface.
    """
    points = np.ascontiguousarray(points, np.float64)
    triangles = np.ascontiguousarray(triangles, np.int64)
    tail = triangles.ravel()
    head = np.roll(triangles, -1, axis=1).ravel()
    twin = match_twins(tail, head, len(points))
    edge_length = np.linalg.norm(points[head] - points[tail], axis=1)
    corner_angle = corner_angles(points, triangles)
    angle_sum = np.bincount(tail, corner_angle, len(points))
    fan, fan_offset, first_is_boundary = _vertex_fans(tail, twin, len(points))
    angle_scale = np.where(first_is_boundary, 1.0, 2 * np.pi / np.maximum(angle_sum, 1e-300))
    polar_angle = _polar_angles(fan, fan_offset, tail, corner_angle, angle_scale)
    reverse_angle = np.where(twin >= 0, polar_angle[twin], angle_sum[head])
    loop_halfedges, loop_offset = _boundary_loops(tail, head, twin)
    inner = np.flatnonzero(twin >= 0)
    component = connected_components(len(triangles), inner // 3, twin[inner] // 3)
    return TriangleSurface(
        points, triangles, tail, head, twin, edge_length, corner_angle, angle_sum, angle_scale,
        polar_angle, reverse_angle, fan, fan_offset, loop_halfedges, loop_offset, component,
    )


def match_twins(tail, head, vertex_count) -> np.ndarray:
    """(H,) int64, the halfedge running from head to tail, -1 where there is none.

    Raises InputError if two halfedges have the same tail and head.
    """
    key = tail * np.int64(vertex_count) + head
    order = np.argsort(key, kind="stable")
    sorted_key = key[order]
    repeated = np.flatnonzero(sorted_key[1:] == sorted_key[:-1])
    if len(repeated):
        h = order[repeated[0]]
        raise InputError(
            f"The edge between vertices {tail[h]} and {head[h]} is used twice in the same "
            "direction: the mesh is not manifold or not consistently oriented there; "
            "recalculate the normals or remove the extra face."
        )
    position = np.searchsorted(sorted_key, head * np.int64(vertex_count) + tail)
    position = np.minimum(position, len(key) - 1)
    found = sorted_key[position] == head * np.int64(vertex_count) + tail
    return np.where(found, order[position], -1)


def connected_components(count, first, second) -> np.ndarray:
    """(count,) int64, component numbers 0, 1, ... of the graph with edges first[i] -- second[i].

    Components are numbered by their smallest member.
    """
    parent = np.arange(count)
    while len(first):
        a, b = parent[first], parent[second]
        apart = a != b
        if not apart.any():
            break
        first, second, a, b = first[apart], second[apart], a[apart], b[apart]
        np.minimum.at(parent, np.maximum(a, b), np.minimum(a, b))
        while True:
            above = parent[parent]
            if np.array_equal(above, parent):
                break
            parent = above
    return np.unique(parent, return_inverse=True)[1].ravel()


def corner_angles(points, triangles) -> np.ndarray:
    """(3F,) float64, angle at the tail of each halfedge, exact to rounding for needles too."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    doubled_area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    dots = [((q - p) * (r - p)).sum(1) for p, q, r in ((a, b, c), (b, c, a), (c, a, b))]
    return np.stack([np.arctan2(doubled_area, d) for d in dots], axis=1).ravel()


def _vertex_fans(tail, twin, vertex_count):
    """Halfedges sorted counter-clockwise round their tails, all vertices at once."""
    halfedges = np.arange(len(tail))
    degree = np.bincount(tail, minlength=vertex_count)
    first = np.full(vertex_count, -1, np.int64)
    first[tail[::-1]] = halfedges[::-1]
    boundary = np.flatnonzero(twin < 0)
    first_is_boundary = np.zeros(vertex_count, bool)
    first[tail[boundary]] = boundary
    first_is_boundary[tail[boundary]] = True
    offset = np.concatenate([[0], np.cumsum(degree)])
    fan = np.empty(len(tail), np.int64)
    vertices, current = np.arange(vertex_count), first
    for step in range(int(degree.max(initial=0))):
        fan[offset[vertices] + step] = current
        more = degree[vertices] > step + 1
        vertices, current = vertices[more], twin[previous_halfedge(current[more])]
        broken = (current < 0) | (current == first[vertices])
        if broken.any():
            raise InputError(
                f"Vertex {vertices[broken][0]} joins parts of the surface that touch only in this "
                "point; split the vertex or delete one of the parts."
            )
    return fan, offset, first_is_boundary


def _polar_angles(fan, offset, tail, corner_angle, angle_scale):
    scaled = (corner_angle * angle_scale[tail])[fan]
    # Differences of one long running sum would lose digits: sum within each fan.
    degree = np.diff(offset)
    angle = np.zeros(len(fan))
    current = np.zeros(len(degree))
    for step in range(int(degree.max(initial=0))):
        vertices = np.flatnonzero(degree > step)
        slot = offset[vertices] + step
        angle[fan[slot]] = current[vertices]
        current[vertices] += scaled[slot]
    return angle


def _boundary_loops(tail, head, twin):
    """Boundary halfedges chained into loops; the smallest halfedge starts its loop.

    By pointer doubling: the smallest member of each loop, then the number of steps to it.
    """
    boundary = np.flatnonzero(twin < 0)
    count = len(boundary)
    leaving = np.zeros(int(tail.max(initial=-1)) + 1, np.int64)
    leaving[tail[boundary]] = np.arange(count)
    following = leaving[head[boundary]]
    doublings = range(count.bit_length())
    first, jump = np.arange(count), following
    for _ in doublings:
        first, jump = np.minimum(first, first[jump]), jump[jump]
    is_first = first == np.arange(count)
    steps, jump = (~is_first).astype(np.int64), np.where(is_first, first, following)
    for _ in doublings:
        steps, jump = steps + steps[jump], jump[jump]
    size = np.bincount(first, minlength=count)[is_first]
    order = np.lexsort([np.where(is_first, -count, -steps), first])
    return boundary[order], np.concatenate([[0], np.cumsum(size)]).astype(np.int64)
