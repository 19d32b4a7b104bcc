"""The midpoint split: every triangle of the surface becomes three quads, whatever happens.

The last resort when no layout of lines can be filled (method section 8). The corners of the quads
are a corner of the triangle, the middles of its two sides and its centroid: convex in every
triangle, conforming across every edge, and feature edges stay chains of edges. Only irregular.
"""

from __future__ import annotations

import numpy as np

from ..errors import Cancelled
from ..patience import Patience
from ..quads.placement import Placement
from ..quads.quad_mesh import QuadMesh
from ..quads.quality import scaled_jacobian
from ..quads.smoothing import smooth
from ..settings import Settings
from ..surface.boundary import build_loops
from ..surface.surface import TriangleSurface, previous_halfedge
from .filling import Filling

# Most times that all quads are cut into four to come near the wanted number.
MOST_CUTS = 4
# CPU seconds, and seconds of the clock, that smoothing may take; the quads are valid without it.
SMOOTHING_SECONDS, SMOOTHING_WAITED = 20.0, 30.0


def split_at_midpoints(
    surface: TriangleSurface, crease, fixed, settings: Settings, cancelled=None
) -> Filling:
    """Quads from the triangles of a surface: a Filling without QuadLayout.

    surface  TriangleSurface, not cut along feature edges
    crease   (3F,) bool, feature halfedges; their edges stay edges of the mesh
    fixed    (V,) bool, vertices that may not move, besides those on feature edges

    All quads are cut into four until their number comes nearest to the wanted one; three for each
    triangle is the least. Raises Cancelled.
    """
    mesh = _three_quads_each(surface, crease, fixed)
    for _ in range(_cuts(surface, settings)):
        mesh = _four_quads_each(surface, mesh)
    placement, quad, face, crease_edge = mesh
    smoothed = _smoothed(surface, placement, quad, cancelled)
    # Quads inside flat triangles are never inverted; smoothed across sharp folds they may be.
    if scaled_jacobian(smoothed.point, quad).min() > 0:
        placement = smoothed
    count = len(placement.point)
    valence, on_boundary = np.bincount(quad.ravel(), minlength=count), placement.loop >= 0
    quads = QuadMesh(
        placement.point, quad, on_boundary, valence, scaled_jacobian(placement.point, quad),
        crease_edge,
    )
    source = valence != np.where(on_boundary, 2, 4)
    source[crease_edge.ravel()] |= np.bincount(crease_edge.ravel(), minlength=count)[
        crease_edge.ravel()
    ] != 2
    face_quad = np.zeros(surface.face_count, np.int64)
    face_quad[face[::-1]] = np.arange(len(face))[::-1]
    return Filling(quads, None, placement, source, face_quad)


def _smoothed(surface, placement, quad, cancelled):
    """The placement smoothed if there is time for it."""
    patience = Patience(SMOOTHING_SECONDS, cancelled, SMOOTHING_WAITED)
    try:
        return smooth(surface, placement, quad, cancelled=patience)
    except Cancelled:
        if not patience.ran_out:
            raise
        return placement


def _cuts(surface, settings):
    wanted = settings.quad_count
    if settings.edge_length is not None:
        wanted = surface.face_area.sum() / settings.edge_length**2
    cuts = np.log(max(wanted / (3 * surface.face_count), 1.0)) / np.log(4.0)
    return int(np.clip(np.rint(cuts), 0, MOST_CUTS))


def _three_quads_each(surface, crease, fixed):
    """(placement, quad (Q, 4), face (Q,), crease edges (n, 2)): vertices, edges, then centroids."""
    count, edge = surface.vertex_count, surface.edges
    number = np.empty(3 * surface.face_count, np.int64)
    number[edge] = np.arange(len(edge))
    twin = surface.twin[edge]
    number[twin[twin >= 0]] = number[edge[twin >= 0]]
    halfedge = np.arange(3 * surface.face_count)
    middle = count + number
    centre = count + len(edge) + halfedge // 3
    quad = np.stack([surface.tail, middle, centre, middle[previous_halfedge(halfedge)]], axis=1)
    points = surface.points
    point = np.concatenate([
        points, 0.5 * (points[surface.tail[edge]] + points[surface.head[edge]]),
        points[surface.triangles].mean(1),
    ])
    face = np.empty(count, np.int64)
    face[surface.tail] = halfedge // 3
    face = np.concatenate([face, edge // 3, np.arange(surface.face_count)])
    loop, position = _on_loops(surface, middle, len(point))
    kept = edge[crease[edge]]
    still = np.zeros(len(point), bool)
    still[:count] = fixed
    crease_edge = np.stack(
        [np.concatenate([surface.tail[kept], middle[kept]]),
         np.concatenate([middle[kept], surface.head[kept]])], axis=1,
    )
    still[crease_edge] = True
    return Placement(point, face, loop, position, still), quad, halfedge // 3, crease_edge


def _on_loops(surface, middle, count):
    """Boundary loop and position along it of all points, -1 and 0 inside."""
    loops = build_loops(surface)
    loop, position = np.full(count, -1), np.zeros(count)
    tail = surface.tail[loops.halfedge]
    loop[tail] = loop[middle[loops.halfedge]] = loops.halfedge_loop
    position[tail] = loops.position
    position[middle[loops.halfedge]] = loops.position + 0.5 * loops.step_length
    return loop, position


def _four_quads_each(surface, mesh):
    """Every quad cut at the middles of its sides; the same kind of tuple."""
    placement, quad, face, crease_edge = mesh
    count = len(placement.point)
    ends = np.sort(np.stack([quad, np.roll(quad, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    key, first, number = np.unique(
        ends[:, 0] * np.int64(count) + ends[:, 1], return_index=True, return_inverse=True
    )
    side = count + number.reshape(-1, 4)
    centre = count + len(key) + np.arange(len(quad))
    finer = np.stack(
        [quad, side, np.repeat(centre[:, None], 4, axis=1), np.roll(side, 1, axis=1)], axis=2
    ).reshape(-1, 4)
    low, high = ends[first].T
    point = np.concatenate([
        placement.point, 0.5 * (placement.point[low] + placement.point[high]),
        placement.point[quad].mean(1),
    ])
    loop, position = _halved_on_loops(surface, placement, low, high, number, len(point))
    kept = np.searchsorted(key, np.sort(crease_edge, axis=1) @ np.array([count, 1]))
    still = np.zeros(len(point), bool)
    still[:count] = placement.fixed
    still[count + kept] = True
    halves = np.concatenate([
        np.stack([crease_edge[:, 0], count + kept], 1), np.stack([count + kept, crease_edge[:, 1]], 1)
    ])
    owner = np.concatenate([placement.face, face[first // 4], face])
    return Placement(point, owner, loop, position, still), finer, np.repeat(face, 4), halves


def _halved_on_loops(surface, placement, low, high, number, count):
    """Loops and positions of `_four_quads_each`: an edge in one quad only lies on its loop."""
    loops = build_loops(surface)
    loop, position = np.full(count, -1), np.zeros(count)
    old = len(placement.point)
    loop[:old], position[:old] = placement.loop, placement.loop_position
    wall = np.flatnonzero(np.bincount(number.ravel()) == 1)
    own = placement.loop[low[wall]]
    start, end = placement.loop_position[low[wall]], placement.loop_position[high[wall]]
    half = 0.5 * loops.length[own]
    step = loops.wrap(own, end - start + half) - half
    loop[old + wall], position[old + wall] = own, loops.wrap(own, start + 0.5 * step)
    return loop, position
