"""Local search where a smooth mesh still has bad quads: their vertices try several places each.

Minimising an energy moves the mesh as a whole and stops where sharp folds that are no creases bend
single quads. There the vertices of the worst quads are walked to places round about them, and take
the best one if their quads become better; no two vertices of one quad move at once. (method
section 10)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..errors import Cancelled
from ..surface.projection import surface_normal, walk
from ..surface.surface import TriangleSurface
from .placement import Placement
from .quality import scaled_jacobian

# Quads worse than this are searched, and the best they are asked for is this much better.
GOOD_ENOUGH, MARGIN = 0.6, 0.1
# Most quads searched in a round, most rounds, and rounds that may pass without the worst scaled
# Jacobian or the number of inverted quads getting better by the least progress.
_MOST_QUADS, _ROUNDS, _PATIENCE, _LEAST_PROGRESS = 200, 100, 8, 0.01
# Directions and distances, in mean lengths of the edges at the vertex, of the places tried.
_DIRECTIONS, _DISTANCES = 12, (0.5, 0.25, 0.1, 0.04)
# A quad costs exp(-steepness * scaled Jacobian) + _UNEVENNESS * log(ratio of opposite edges)^2; one
# steepness after the other, each from the best that there is.
STEEPNESSES, _UNEVENNESS = (5.0, 8.0, 3.0), 0.02
_LEAST_GAIN = 1e-4


def mend_worst_quads(
    surface: TriangleSurface, placement: Placement, quad, cancelled=None,
    along_edges=False, good_enough=GOOD_ENOUGH, steepnesses=STEEPNESSES,
) -> Placement:
    """Move inner vertices near the worst quads of a mesh, so that these become better.

    quad         (Q, 4) int64, counter-clockwise
    along_edges  whether vertices move along their edges only, as suits long and thin quads, instead
                 of in all directions
    good_enough  scaled Jacobian, quads worse than this are searched
    steepnesses  how much more the worst quads count than others, one search for each

    Fixed vertices and those on the boundary stay. Returns the placement whose worst quads are the best; never worse
    than the given one. Raises Cancelled.
    """
    search = _Search(surface, np.asarray(quad, np.int64), along_edges, good_enough, cancelled)
    for steepness in steepnesses:
        placement, score = _best_of_rounds(search, placement, steepness)
        if score >= good_enough:
            break
    return placement


@dataclass(frozen=True)
class _Search:
    """What stays the same in all rounds, as in `mend_worst_quads`."""

    surface: TriangleSurface
    quad: np.ndarray
    along_edges: bool
    good_enough: float
    cancelled: object


def _best_of_rounds(search: _Search, placement, steepness):
    """(Placement, score): the best of all rounds with one steepness, the given one included."""
    surface, quad, cancelled = search.surface, search.quad, search.cancelled
    best, best_score, waited = placement, -np.inf, 0
    for _ in range(_ROUNDS):
        if cancelled is not None and cancelled():
            raise Cancelled("The computation was cancelled.")
        normal = surface_normal(surface, placement.face, placement.point)
        shape = scaled_jacobian(placement.point, quad, normal)
        score = -float((shape <= 0).sum()) if (shape <= 0).any() else float(shape.min())
        if score > best_score + _LEAST_PROGRESS:
            best, best_score, waited = placement, score, 0
        waited += 1
        if score >= search.good_enough or waited > _PATIENCE:
            break
        placement = _one_round(search, placement, normal, shape, steepness)
        if placement is None:
            break
    return best, best_score


def _one_round(search: _Search, placement, normal, shape, steepness) -> Placement | None:
    """The best moves of one round, None where there are none."""
    surface, quad = search.surface, search.quad
    worst = np.argsort(shape, kind="stable")[:_MOST_QUADS]
    vertex = np.unique(quad[worst[shape[worst] < search.good_enough]])
    vertex = vertex[~placement.fixed[vertex] & (placement.loop[vertex] < 0)]
    if not len(vertex):
        return None
    owner, place, around = _incidences(quad, vertex, len(placement.point))
    if search.along_edges:
        move = _moves_along_edges(placement, quad, vertex, owner, place, around)
    else:
        move = _moves_round_about(surface, placement, quad, vertex, owner, around)
    start = np.repeat(placement.point[vertex], move.shape[1], axis=0)
    start_face = np.repeat(placement.face[vertex], move.shape[1])
    point, face = walk(surface, start, start_face, move.reshape(-1, 3))
    point, face = point.reshape(move.shape), face.reshape(move.shape[:2])
    tried = surface_normal(surface, face.ravel(), point.reshape(-1, 3)).reshape(point.shape)
    cost = _costs(
        placement.point, normal, quad[around], place, point[owner], tried[owner], steepness
    )
    total = np.stack([np.bincount(owner, column, len(vertex)) for column in cost.T], axis=1)
    gain = total[:, 0] - total.min(1)
    chosen = _alone_in_their_quads(gain, owner, around, len(quad))
    if not len(chosen):
        return None
    best = total[chosen].argmin(1)
    new_point, new_face = placement.point.copy(), placement.face.copy()
    new_point[vertex[chosen]] = point[chosen, best]
    new_face[vertex[chosen]] = face[chosen, best]
    return replace(placement, point=new_point, face=new_face)


def _incidences(quad, vertex, count):
    """For every quad round each vertex: number of the vertex, its corner there, and the quad."""
    number = np.full(count, -1)
    number[vertex] = np.arange(len(vertex))
    around, place = np.nonzero(number[quad] >= 0)
    return number[quad[around, place]], place, around


def _moves_round_about(surface, placement, quad, vertex, owner, around):
    """Moves (n, K, 3) to try in all directions, the first one none."""
    corner = placement.point[quad[around]]
    size = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).mean(1)
    size = np.bincount(owner, size, len(vertex)) / np.bincount(owner, minlength=len(vertex))
    across = surface.face_normal[placement.face[vertex]]
    first = np.cross(np.eye(3)[np.abs(across).argmin(1)], across)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(across, first)
    turn = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    step = np.multiply.outer(_DISTANCES, np.stack([np.cos(turn), np.sin(turn)], 1)).reshape(-1, 2)
    step = np.concatenate([np.zeros((1, 2)), step])
    move = step[:, :1] * first[:, None] + step[:, 1:] * second[:, None]
    return move * size[:, None, None]


def _moves_along_edges(placement, quad, vertex, owner, place, around):
    """Moves (n, K, 3) to try along the edges at each vertex, the first one none."""
    order = np.argsort(owner, kind="stable")
    number = np.empty(len(owner), np.int64)
    number[order] = np.arange(len(owner)) - np.searchsorted(owner[order], owner[order])
    edge = np.zeros((len(vertex), number.max() + 1, 3))
    neighbour = quad[around, (place + 1) % 4]
    edge[owner, number] = placement.point[neighbour] - placement.point[vertex[owner]]
    step = np.array(_DISTANCES)[:, None, None] * edge[:, None]
    return np.concatenate([np.zeros((len(vertex), 1, 3)), step.reshape(len(vertex), -1, 3)], 1)


def _costs(points, normal, quad, place, point, tried, steepness):
    """(n, K) float64, cost of each quad with one corner at each of K places.

    quad (n, 4), place (n,) the corner that moves; point, tried (n, K, 3) its places and normals
    """
    count, places = point.shape[:2]
    row = np.arange(count)
    corner = np.repeat(points[quad][:, None], places, axis=1)
    corner[row, :, place] = point
    side = np.repeat(normal[quad][:, None], places, axis=1)
    side[row, :, place] = tried
    corner, side = corner.reshape(-1, 3), side.reshape(-1, 3)
    number = np.arange(len(corner)).reshape(-1, 4)
    shape = np.minimum(scaled_jacobian(corner, number, side), GOOD_ENOUGH + MARGIN)
    corner = corner.reshape(-1, 4, 3)
    length = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
    ratio = np.log(np.maximum(length, 1e-300))
    uneven = (ratio[:, 0] - ratio[:, 2]) ** 2 + (ratio[:, 1] - ratio[:, 3]) ** 2
    cost = np.exp(-steepness * shape) + _UNEVENNESS * uneven
    return cost.reshape(count, places)


def _alone_in_their_quads(gain, owner, around, quad_count):
    """Numbers of the vertices that gain more than all others in their quads."""
    order = np.lexsort((np.arange(len(gain)), gain))
    rank = np.empty(len(gain), np.int64)
    rank[order] = np.arange(len(gain))
    top = np.full(quad_count, -1)
    np.maximum.at(top, around, rank[owner])
    beaten = np.zeros(len(gain), bool)
    beaten[owner[top[around] > rank[owner]]] = True
    return np.flatnonzero(~beaten & (gain > _LEAST_GAIN))
