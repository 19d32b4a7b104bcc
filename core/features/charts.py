"""The surface cut along its feature edges into charts, so that these are boundary for all stages.

Cutting duplicates vertices and leaves triangles and halfedges as they are: a feature line that ends
inside the surface is a slit, whose end vertex stays single. (method sections 2 and 8)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..field.constraints import Constraints, cross_angle
from ..surface.refinement import split_boundary_chords, split_edges
from ..surface.surface import TriangleSurface, build_surface, connected_components, next_halfedge

# How far a corner's angle must exceed the least that another block takes.
_MARGIN = np.radians(5)


@dataclass(frozen=True)
class Charts:
    """A surface before and after it was cut; both have the same triangles and halfedges.

    surface     TriangleSurface, cut along the feature edges
    whole       TriangleSurface, not cut
    first_copy  (V,) int64, smallest vertex of `surface` at the same place: the one that has kept
                its number
    across      (3F,) int64, the halfedge on the other side of the cut, -1 elsewhere
    """

    surface: TriangleSurface
    whole: TriangleSurface
    first_copy: np.ndarray
    across: np.ndarray

    @property
    def outer(self) -> np.ndarray:
        """(V,) bool, first copies of vertices on the boundary of the whole surface."""
        mask = np.zeros(len(self.first_copy), bool)
        mask[self.first_copy[self.surface.tail[(self.whole.twin < 0)]]] = True
        return mask


def cut_along(whole: TriangleSurface, crease) -> tuple[Charts, np.ndarray]:
    """Cut a surface along feature edges and refine the charts as the cross-field needs it.

    crease  (3F,) bool, true on both halfedges of each feature edge, never on the boundary

    Returns the charts, whose first vertices are those of the given surface, and (F',) int64, the
    given triangle that each triangle is a piece of, in ascending order.
    """
    whole, crease, outer = _split_lone_edges(whole, crease)
    origin = _copies(whole, crease)
    cut = build_surface(whole.points[origin[0]], origin[1].reshape(-1, 3))
    surface, inner = split_boundary_chords(cut)
    added = surface.vertex_count - cut.vertex_count
    first_copy = np.concatenate([origin[0], cut.vertex_count + np.arange(added)])
    # In the whole surface the added vertices follow its own ones at once.
    number = np.concatenate([origin[0], whole.vertex_count + np.arange(added)])
    points = np.concatenate([whole.points, surface.points[cut.vertex_count :]])
    whole = build_surface(points, number[surface.triangles])
    across = np.where(surface.twin < 0, whole.twin, -1)
    return Charts(surface, whole, first_copy, across), outer[inner]


def _split_lone_edges(whole, crease):
    """Feature lines of one edge inside the surface in two: a cut needs a vertex that opens."""
    degree = np.bincount(whole.tail[crease], minlength=whole.vertex_count)
    opens = (degree > 1) | whole.on_boundary
    edge = whole.edges[crease[whole.edges]]
    lone = edge[~opens[whole.tail[edge]] & ~opens[whole.head[edge]]]
    if not len(lone):
        return whole, crease, np.arange(whole.face_count)
    middle = whole.vertex_count + np.arange(len(lone))
    kept = np.setdiff1d(edge, lone)
    tail = np.concatenate([whole.tail[kept], whole.tail[lone], middle])
    head = np.concatenate([whole.head[kept], middle, whole.head[lone]])
    finer, origin = split_edges(whole, lone)
    span = np.int64(finer.vertex_count)
    key = np.minimum(finer.tail, finer.head) * span + np.maximum(finer.tail, finer.head)
    return finer, np.isin(key, np.minimum(tail, head) * span + np.maximum(tail, head)), origin


def _copies(whole, crease):
    """Vertex of the whole surface of each vertex of the cut one, and its vertex at each corner."""
    touched = np.zeros(whole.vertex_count, bool)
    touched[whole.tail[crease]] = True
    corner = np.flatnonzero(touched[whole.tail])
    number = np.full(len(whole.tail), -1)
    number[corner] = np.arange(len(corner))
    # The corner at the tail of a halfedge and that at the head of its twin share the edge.
    joined = corner[(whole.twin[corner] >= 0) & ~crease[corner]]
    other = next_halfedge(whole.twin[joined])
    copy = connected_components(len(corner), number[joined], number[other])
    copy_vertex = np.empty(int(copy.max(initial=-1)) + 1, np.int64)
    copy_vertex[copy] = whole.tail[corner]
    order = np.argsort(copy_vertex, kind="stable")
    extra = order[1:][np.diff(copy_vertex[order]) == 0]
    vertex = copy_vertex.copy()
    vertex[extra] = whole.vertex_count + np.arange(len(extra))
    at_corner = whole.tail.copy()
    at_corner[corner] = vertex[copy]
    origin = np.concatenate([np.arange(whole.vertex_count), copy_vertex[extra]])
    return origin, at_corner


def share_nodes(charts: Charts, constraints: Constraints) -> Constraints:
    """The corner rule on all copies of a vertex together.

    A vertex that is a node on one copy is one on all of them, and so is a vertex where other than
    two feature and boundary edges meet: copies with n_b = 2 become kinks. Inside the whole surface
    at least three blocks meet round a vertex: the copy with the largest angle is given more.
    """
    copy = charts.first_copy
    constraints = _at_least_three(charts, constraints)
    count = len(copy)
    leaving = charts.surface.tail[charts.surface.twin < 0]
    # Each feature edge leaves both its ends, a boundary edge one; boundary vertices have two.
    degree = np.bincount(copy[leaving], minlength=count) + charts.outer
    own = (constraints.block_count > 0) & (constraints.block_count != 2) | constraints.kink
    node = (np.bincount(copy, own, count) > 0) | (degree > 0) & (degree != 2)
    return replace(constraints, kink=(constraints.block_count == 2) & node[copy])


def _at_least_three(charts, constraints):
    """One block more for the widest copy of inner vertices round which only two would meet."""
    surface, copy = charts.surface, charts.first_copy
    total = np.bincount(copy, constraints.block_count, len(copy))
    few = surface.on_boundary & ((total == 2) & ~charts.outer)[copy]
    vertex = np.flatnonzero(few)
    if not len(vertex):
        return constraints
    order = vertex[np.lexsort((-surface.angle_sum[vertex], copy[vertex]))]
    widest = order[np.diff(copy[order], prepend=-1) != 0]
    block_count, angle = constraints.block_count.copy(), constraints.angle.copy()
    # A cross may deviate from the wall by less than 45 degrees.
    widest = widest[surface.angle_sum[widest] > 0.5 * np.pi * block_count[widest] + _MARGIN]
    block_count[widest] += 1
    angle[widest] = cross_angle(surface.angle_sum[widest], block_count[widest])
    lean = np.zeros(len(copy)) + constraints.lean
    lean[widest] = 0.0
    return replace(constraints, block_count=block_count, angle=angle, lean=lean)
