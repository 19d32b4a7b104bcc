"""Any polygons -> an oriented manifold of triangles, with the way back to the user's elements.

Each kind of fault has its repair in a module of its own; here they follow one another, and each
one that had something to do says so in a sentence.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..surface.surface import match_twins
from ..unit_frame import unit_frame
from .duplicates import (
    find_repeated_corners,
    find_repeated_polygons,
    find_repeated_rows,
    without_spikes,
)
from .flat_triangles import sound_triangles, without_flat_triangles
from .manifold import (
    crowded_halfedges,
    edge_keys,
    find_bow_ties,
    find_touching,
    glue,
    split_fans,
)
from .orientation import cut_one_sided, find_turned, find_twisted, turn
from .polygons import Polygons, as_polygons
from .refusals import (
    as_points,
    refuse_bad_polygons,
    refuse_bow_ties,
    refuse_flat_triangles,
    refuse_unusable,
)
from .triangulation import triangulate
from .welding import find_weld


@dataclass(frozen=True)
class CleanMesh:
    """A consistently oriented manifold of triangles that have area.

    points         (V, 3) float64, in the user's coordinates, every one used by a triangle
    triangles      (F, 3) int64
    vertex_origin  (V,) int64, the user's vertex of each point, in ascending order; twice the same
                   where the surface was cut open
    face_origin    (F,) int64, the user's polygon of each triangle, in ascending order
    weld_target    (U,) int64, for each of the user's vertices the one that it was merged into,
                   itself where it was not
    warnings       sentences for the user: what was repaired
    """

    points: np.ndarray
    triangles: np.ndarray
    vertex_origin: np.ndarray
    face_origin: np.ndarray
    weld_target: np.ndarray
    warnings: list

    def find_edges(self, edge: np.ndarray) -> np.ndarray:
        """(3F,) int64: which of the user's edges (n, 2) each halfedge 3 f + c is, -1 for none.

        A user's edge that was cut open or that was merged with another one is found all the same.
        """
        end = np.sort(self.weld_target[np.asarray(edge, np.int64).reshape(-1, 2)], axis=1)
        here = self.vertex_origin[self.triangles]
        key = edge_keys(here, len(self.weld_target))
        wanted, first = np.unique(
            end[:, 0] * np.int64(len(self.weld_target)) + end[:, 1], return_index=True
        )
        if not len(wanted):
            return np.full(len(key), -1, np.int64)
        place = np.minimum(np.searchsorted(wanted, key), len(wanted) - 1)
        return np.where(wanted[place] == key, first[place], -1)


def clean(points, polygons, weld_distance: float = 0.0, repair: bool = True) -> CleanMesh:
    """Make a surface of a polygon mesh: repair what can be repaired, cut polygons into triangles.

    points         (U, 3) numbers, object-space lengths
    polygons       (N, 3) or (N, 4) vertex numbers, or a list of index lists
    weld_distance  vertices that lie no farther apart become one; object-space lengths
    repair         False refuses faulty meshes instead

    Raises InputError with one sentence that names the cause, the place and the cure: no faces,
    coordinates of faces that are no numbers, vertex numbers out of range, no area anywhere; with
    repair off also repeated faces and corners, edges of more than two faces, neighbours that
    disagree on their orientation, faces without area, vertices where parts only touch.
    """
    points, polygons = as_points(points), as_polygons(polygons)
    refuse_unusable(points, polygons)
    frame = unit_frame(points[np.unique(polygons.corner)])
    shape = np.where(np.abs(points) < 1e100, frame.inward(np.nan_to_num(points)), 0.0)
    weld = find_weld(shape, polygons, weld_distance / frame.size, repair)
    notes = _weld_notes(weld)
    polygons = Polygons(weld.target[polygons.corner], polygons.start)
    if repair:
        polygons, number, vertex = _sound_polygons(polygons, len(points), notes)
    else:
        refuse_bad_polygons(polygons)
        number, vertex = np.arange(polygons.count), np.arange(len(points))
    triangles, polygon = triangulate(shape[vertex], polygons, may_repeat=repair)
    triangles, polygon = vertex[triangles], number[polygon]
    origin = np.arange(len(points))
    if repair:
        triangles, polygon, origin = _manifold(shape, triangles, polygon, notes)
    else:
        refuse_flat_triangles(shape, triangles, polygon)
        refuse_bow_ties(triangles, _twins(triangles, len(points)))
    return _without_unused(points, triangles, polygon, origin, weld.target, notes)


def _weld_notes(weld):
    notes = []
    why = (
        (weld.requested, "within the welding distance"),
        (weld.loose, "in the same place, because their faces shared no vertices"),
        (weld.short, "at the other end of an edge without length"),
    )
    for count, where in why:
        if count:
            notes.append(f"{_count(count, 'vertex', 'vertices')} {_were(count)} merged into one {where}.")
    return notes


def _sound_polygons(polygons, vertex_count, notes):
    """Polygons of three or more corners, all different, none there twice.

    Returns them with their numbers in the user's list (n,), and the user's vertex of each of
    their vertices: a vertex that a polygon passes twice gets a number of its own for each time.
    """
    tidy = without_spikes(polygons)
    number = np.flatnonzero(tidy.size >= 3)
    short = polygons.count - len(number)
    changed = np.count_nonzero(tidy.size[number] != polygons.size[number])
    if short:
        notes.append(
            f"{_count(short, 'face', 'faces')} with fewer than three different corners"
            f" {_were(short)} left out."
        )
    if changed:
        notes.append(
            f"{_count(changed, 'face', 'faces')} lost corners that"
            f" {'it' if changed == 1 else 'they'} passed twice."
        )
    tidy = tidy.chosen(number)
    again = find_repeated_polygons(tidy)[:, 1]
    if len(again):
        notes.append(f"{_count(len(again), 'repeated face', 'repeated faces')} {_were(len(again))} left out.")
        number = np.delete(number, again)
        tidy = tidy.chosen(np.delete(np.arange(tidy.count), again))
    if not tidy.count:
        raise InputError("The mesh has no area: no face has three different corners; check it.")
    repeated = find_repeated_corners(tidy)
    corner = tidy.corner.copy()
    vertex = np.concatenate([np.arange(vertex_count), corner[repeated]])
    corner[repeated] = vertex_count + np.arange(len(repeated))
    return Polygons(corner, tidy.start), number, vertex


def _manifold(shape, triangles, polygon, notes):
    """Oriented triangles that have area, the polygon of each, and the user's vertex of each of
    their vertices."""
    given = len(np.unique(polygon))
    keep = sound_triangles(shape, triangles)
    if len(np.unique(polygon)) < len(polygon):  # of single triangles none is there twice
        keep = np.delete(keep, find_repeated_rows(triangles[keep])[:, 1])
    triangles, polygon = triangles[keep], polygon[keep]
    crowded = crowded_halfedges(triangles, len(shape))
    mate = glue(shape, triangles, polygon)
    faulty = crowded.any() or find_twisted(triangles, mate).any()
    ties = len(find_touching(triangles, len(shape)) if faulty else find_bow_ties(triangles, mate))
    cut = cut_one_sided(shape, triangles, mate)
    _note_cuts(triangles, crowded, len(shape), ties, cut, notes)
    triangles, mate = _oriented(shape, triangles, polygon, mate, notes)
    origin = np.arange(len(shape))
    if crowded.any() or cut or ties:
        triangles, origin = _split(triangles, mate, origin)
    before = triangles
    triangles, polygon = without_flat_triangles(shape[origin], triangles, polygon)
    if not len(triangles):
        raise InputError(
            "The mesh has no area: all its faces are lines or points; give it faces with area."
        )
    if triangles is not before:
        triangles, origin = _split(triangles, _twins(triangles, len(origin)), origin)
    flat = given - len(np.unique(polygon))
    if flat:
        notes.append(f"{_count(flat, 'face', 'faces')} without area {_were(flat)} left out.")
    return triangles, polygon, origin


def _oriented(shape, triangles, polygon, mate, notes):
    turned = find_turned(shape, triangles, mate)
    if turned.any():
        faces = len(np.unique(polygon[turned]))
        notes.append(
            f"{_count(faces, 'face', 'faces')} {_were(faces)} turned over so that neighbours agree"
            " on which side is outside."
        )
    return turn(triangles, mate, turned)


def _note_cuts(triangles, crowded, vertex_count, ties, cut, notes):
    if crowded.any():
        edges = len(np.unique(edge_keys(triangles, vertex_count)[crowded]))
        notes.append(
            f"The surface was cut apart along {_count(edges, 'edge', 'edges')} of more than two"
            " faces."
        )
    if ties:
        notes.append(
            f"{_count(ties, 'vertex', 'vertices')} in which parts of the surface only touched"
            f" {_were(ties)} split."
        )
    if cut:
        notes.append(f"The one-sided surface was cut open along {_count(cut, 'edge', 'edges')}.")


def _split(triangles, mate, origin):
    """Triangles with a vertex for each fan, and the user's vertex of each of these."""
    corner = split_fans(triangles, mate)
    result = np.empty(int(corner.max()) + 1, np.int64)
    result[corner] = origin[triangles.ravel()]
    return corner.reshape(-1, 3), result


def _twins(triangles, vertex_count):
    return match_twins(triangles.ravel(), triangles[:, [1, 2, 0]].ravel(), vertex_count)


def _without_unused(points, triangles, polygon, origin, weld_target, notes):
    order = np.argsort(polygon, kind="stable")
    triangles, polygon = triangles[order], polygon[order]
    used = np.zeros(len(origin), bool)
    used[triangles.ravel()] = True
    number = np.cumsum(used) - 1
    origin = origin[used]
    merged = np.count_nonzero(weld_target != np.arange(len(points)))
    unused = len(points) - merged - len(np.unique(origin))
    notes += _final_notes(unused, points[origin], origin)
    return CleanMesh(points[origin], number[triangles], origin, polygon, weld_target, notes)


def _final_notes(unused, points, origin):
    notes = []
    if unused:
        notes.append(
            f"{_count(unused, 'vertex', 'vertices')} that no face uses {_were(unused)}"
            " left out."
        )
    points = points[np.unique(origin, return_index=True)[1]]
    order = np.lexsort(points.T)
    coincident = int((points[order[1:]] == points[order[:-1]]).all(1).sum())
    if coincident:
        notes.append(
            f"{coincident:,} {'vertex lies' if coincident == 1 else 'vertices lie'} exactly on"
            " another one without being joined to it; merge vertices by distance if the surface"
            " should hold together there."
        )
    return notes


def _count(count, one, many):
    return f"{count:,} {one if count == 1 else many}"


def _were(count):
    return "was" if count == 1 else "were"
