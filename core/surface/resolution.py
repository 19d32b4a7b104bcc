"""The working surface: fine enough for the cross-field to live on, in the same place.

Coarse meshes are refined inside: edges that are too long are cut at their middles, and diagonals
of flat polygons are flipped until no vertex lies inside the circle of a neighbouring triangle; so
are other edges of needles where the surface is flat. Edges that are to be kept stay edges, or
chains of them. Fine meshes are left as they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .edge_splitting import cut_triangles
from .flips import flip, flip_values, independent_flips
from .surface import TriangleSurface, build_surface, match_twins, next_halfedge, previous_halfedge

# A component with at least ENOUGH triangles is refined only where its edges are longer than those
# of LOCALLY_ENOUGH equilateral ones; one with fewer triangles is brought to about WANTED.
WANTED, ENOUGH, LOCALLY_ENOUGH = 2000, 500, 300
LEAST_WANTED = 200  # of a component that is small beside the others
MOST = 200_000  # triangles at which refinement stops, however long edges still are

_ROUNDS = 40
# Least angles of triangles whose edges may be flipped over polygons, and are cut only when the
# edges round them are short enough.
_NEEDLE, _NARROW = np.radians(10.0), np.radians(20.0)
# What a flip may move the surface by: a share of the shorter diagonal, and a length, where the mesh
# has the size 1. Coordinates kept in 32 bits or written with seven digits are as far from flat.
_COPLANAR, _ROUNDED = 1e-3, 2e-7
_LARGER = 1e-6  # radians by which opposite angles must exceed pi for a flip


@dataclass(frozen=True)
class WorkingSurface:
    """A refined surface and what each of its elements is a piece of.

    surface          TriangleSurface, its first vertices are those of the given one
    face_origin      (F',) int64, polygon of each triangle
    halfedge_origin  (3F',) int64, given halfedge that each halfedge lies on, in the same
                     direction; -1 inside the given triangles and where diagonals were flipped
    """

    surface: TriangleSurface
    face_origin: np.ndarray
    halfedge_origin: np.ndarray

    def on_edges(self, marked: np.ndarray) -> np.ndarray:
        """(3F',) bool, halfedges that lie on marked (3F,) bool halfedges of the given surface."""
        return (self.halfedge_origin >= 0) & marked[self.halfedge_origin]


def refine(surface: TriangleSurface, polygon: np.ndarray, kept=None) -> WorkingSurface:
    """Refine a surface until the cross-field can live on it.

    polygon  (F,) int64; between triangles of one polygon edges may be flipped, where it is flat
    kept     (3F,) bool or None, edges that are never flipped, true on both halfedges
    """
    limit = _longest_allowed(surface)[surface.component]
    too_long = surface.edge_length > np.repeat(limit, 3)
    if too_long.any() or (surface.corner_angle < _NEEDLE).any():
        mesh = _Refinement(surface, polygon, limit, kept)
        changed = mesh.flip_edges()
        while mesh.cut_long_edges():
            changed = True
            mesh.flip_edges()
        if changed:
            return mesh.result()
    return WorkingSurface(surface, polygon, np.arange(len(surface.twin)))


def halved(working: WorkingSurface) -> WorkingSurface:
    """The same working surface with every edge cut at its middle, every triangle into four."""
    surface, edge = working.surface, working.surface.edges
    middle = np.empty(len(surface.twin), np.int64)
    middle[edge] = surface.vertex_count + np.arange(len(edge))
    inner = edge[surface.twin[edge] >= 0]
    middle[surface.twin[inner]] = middle[inner]
    added = 0.5 * (surface.points[surface.tail[edge]] + surface.points[surface.head[edge]])
    points = np.concatenate([surface.points, added])
    pieces = cut_triangles(points, surface.triangles, middle)
    source = pieces.halfedge_origin
    return WorkingSurface(
        build_surface(points, pieces.triangles),
        working.face_origin[pieces.face_origin],
        np.where(source >= 0, working.halfedge_origin[source], -1),
    )


def _longest_allowed(surface):
    """(components,) float64, length from which edges are cut."""
    count = surface.component_count
    area = np.bincount(surface.component, surface.face_area, count)
    faces = np.bincount(surface.component, minlength=count)
    wanted = np.clip(WANTED * np.sqrt(area / area.max()), LEAST_WANTED, WANTED)
    wanted *= min(1.0, 0.5 * MOST / wanted.sum())
    # Cutting leaves edges between half the limit and the limit: sqrt(2) brings about the number.
    wanted = np.where(faces < wanted * (ENOUGH / WANTED), wanted / 2, wanted * (LOCALLY_ENOUGH / WANTED))
    return np.sqrt(4 / np.sqrt(3) * area / wanted)


class _Refinement:
    """A triangle mesh on its way; see WorkingSurface for what is kept of it."""

    def __init__(self, surface, polygon, limit, kept):
        self.points, self.triangles = surface.points, surface.triangles.copy()
        self.polygon, self.limit = polygon.copy(), limit
        self.halfedge_origin = np.arange(len(surface.twin))
        self.kept = np.zeros(len(surface.twin), bool) if kept is None else kept.copy()

    def result(self):
        surface = build_surface(self.points, self.triangles)
        return WorkingSurface(surface, self.polygon, self.halfedge_origin)

    def _twin(self):
        head = self.triangles[:, [1, 2, 0]].ravel()
        return match_twins(self.triangles.ravel(), head, len(self.points))

    def cut_long_edges(self):
        """Cut edges longer than allowed, the longest first; True while it may go on."""
        twin, tail = self._twin(), self.triangles.ravel()
        head = self.triangles[:, [1, 2, 0]].ravel()
        length = np.linalg.norm(self.points[head] - self.points[tail], axis=1)
        excess = length / np.repeat(self.limit, 3)
        edge = self._to_cut(excess > 1, twin)
        room = max(0, MOST - len(self.triangles)) // 2
        edge = np.sort(edge[np.argsort(-excess[edge], kind="stable")[:room]])
        if not len(edge):
            return False
        middle = np.full(len(twin), -1, np.int64)
        middle[edge] = len(self.points) + np.arange(len(edge))
        inner = edge[twin[edge] >= 0]
        middle[twin[inner]] = middle[inner]
        added = 0.5 * (self.points[tail[edge]] + self.points[head[edge]])
        self.points = np.concatenate([self.points, added])
        self._take(cut_triangles(self.points, self.triangles, middle))
        return True

    def _to_cut(self, too_long, twin):
        """Edges (n,) among those that are too long, one halfedge of each.

        Those of narrow triangles that may be flipped wait until the others of these are short
        enough: most are then flipped instead, and narrow strips are not filled with vertices.
        """
        edge = np.flatnonzero(too_long & ((twin < 0) | (np.arange(len(twin)) < twin)))
        soft = np.zeros(len(twin), bool)
        inner = edge[(twin[edge] >= 0) & ~self.kept[edge]]
        one, two, narrow = inner // 3, twin[inner] // 3, self._thinner_than(_NARROW)
        inner = inner[(narrow[one] | narrow[two]) & self._may_flip(one, two)]
        inner = inner[self._wedge(inner, twin[inner])[0]]
        soft[inner] = soft[twin[inner]] = True
        busy = (too_long & ~soft).reshape(-1, 3).any(1)
        there = np.where(twin[edge] >= 0, twin[edge], edge)
        return edge[~soft[edge] | ~(busy[edge // 3] | busy[there // 3])]

    def _take(self, pieces):
        """Put the pieces of all triangles in their place."""
        self.triangles = pieces.triangles
        self.polygon, self.limit = self.polygon[pieces.face_origin], self.limit[pieces.face_origin]
        source = pieces.halfedge_origin
        self.halfedge_origin = np.where(source >= 0, self.halfedge_origin[source], -1)
        self.kept = (source >= 0) & self.kept[source]

    def flip_edges(self):
        """Flip edges inside flat polygons, and at needles, towards a Delaunay triangulation.

        True when there was one to flip.
        """
        changed = False
        for _ in range(_ROUNDS):
            twin = self._twin()
            edge = np.flatnonzero((np.arange(len(twin)) < twin) & ~self.kept)
            edge = edge[self._may_flip(edge // 3, twin[edge] // 3)]
            coplanar, angle = self._wedge(edge, twin[edge])
            edge = edge[coplanar & (angle > np.pi + _LARGER)]
            edge = independent_flips(self.triangles, edge, twin)
            if not len(edge):
                break
            flip(self.triangles, edge, twin[edge])
            flip_values(self.halfedge_origin, edge, twin[edge], -1)
            flip_values(self.kept, edge, twin[edge], False)
            changed = True
        return changed

    def _may_flip(self, one, two):
        """(n,) bool for pairs of neighbours: of one polygon, or one of them a needle."""
        needle = self._thinner_than(_NEEDLE)
        return needle[one] | needle[two] | (self.polygon[one] == self.polygon[two])

    def _thinner_than(self, angle):
        """(F,) bool, triangles with an angle below the given one."""
        corner = self.points[self.triangles]
        side = np.sort(np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2), axis=1)
        area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        # The least angle lies between the two longer sides.
        return np.linalg.norm(area, axis=1) < np.sin(angle) * side[:, 1] * side[:, 2]

    def _wedge(self, halfedge, twin):
        """Of the two triangles at each edge: (n,) bool, whether they are coplanar, and the sum (n,)
        of the angles opposite the edge; above pi each holds the other's vertex in its circle."""
        vertex = self.triangles.ravel()
        a, b = self.points[vertex[halfedge]], self.points[vertex[next_halfedge(halfedge)]]
        c = self.points[vertex[previous_halfedge(halfedge)]]
        d = self.points[vertex[previous_halfedge(twin)]]
        one, two = np.cross(a - c, b - c), np.cross(b - d, a - d)
        size = np.linalg.norm(one, axis=1), np.linalg.norm(two, axis=1)
        angle = np.arctan2(size[0], ((a - c) * (b - c)).sum(1))
        angle += np.arctan2(size[1], ((a - d) * (b - d)).sum(1))
        # Distance between both diagonals of the four corners, one above the other.
        between = np.linalg.norm(np.cross(b - a, d - c), axis=1)
        off = np.abs(((d - a) * one).sum(1)) / np.maximum(between, 1e-300)
        shorter = np.minimum(np.linalg.norm(b - a, axis=1), np.linalg.norm(d - c, axis=1))
        coplanar = off <= np.minimum(_COPLANAR * shorter, _ROUNDED)
        return coplanar & ((one * two).sum(1) > 0), angle
