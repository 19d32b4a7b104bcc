"""The elements that carry a front from two vertices to a third: triangles and unfolded ones.

A front that enters a triangle through its corner of more than 90 degrees may come from a vertex
that the triangle does not have. Such a corner is split: the triangles across its opposite edge are
unfolded into the plane until a vertex falls into the wedge whose directions lie within 90 degrees
of both sides, and two virtual elements, one on each side of the straight line to that vertex, take
the triangle's place (Kimmel and Sethian). They are found once and stored as data.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..surface.surface import TriangleSurface, next_halfedge, previous_halfedge

# Splitting a corner that is hardly obtuse gains nothing, and its narrow wedge leads far away.
_OBTUSE = np.radians(90.1)
_UNFOLDING_LIMIT = 64


@dataclass(frozen=True)
class FrontElements:
    """Plane triangles, each with a target and two parents, the target on the left of their edge.

    target     (E,) int64
    parent     (2, E) int64
    transport  (2, E) float64, radians: an angle a in the frame of the parent becomes
               a + transport in the frame of the target, along the straight line between them
    base       (E,) float64, distance between the parents
    apex       (2, E) float64, the target's place: along the edge from the first parent towards
               the second, and away from the edge (positive)
    """

    target: np.ndarray
    parent: np.ndarray
    transport: np.ndarray
    base: np.ndarray
    apex: np.ndarray


def front_elements(surface: TriangleSurface) -> FrontElements:
    """Every corner of the surface as a target, obtuse ones unfolded where that succeeds."""
    halfedge = np.arange(3 * surface.face_count)
    following, preceding = next_halfedge(halfedge), previous_halfedge(halfedge)
    obtuse = halfedge[surface.corner_angle[preceding] > _OBTUSE]
    split, virtual = _unfolded(surface, obtuse)
    plain = np.ones(len(halfedge), bool)
    plain[split] = False
    side = surface.edge_length[preceding]
    angle = surface.corner_angle
    ordinary = FrontElements(
        surface.tail[preceding],
        np.stack([surface.tail, surface.head]),
        np.stack([-surface.transport[preceding], surface.transport[following]]),
        surface.edge_length,
        np.stack([side * np.cos(angle), side * np.sin(angle)]),
    )
    return _joined(ordinary, plain, virtual)


def _joined(ordinary, plain, virtual):
    fields = FrontElements.__dataclass_fields__
    if not len(virtual.target) and plain.all():
        return ordinary
    return FrontElements(
        *(
            np.concatenate([getattr(ordinary, f)[..., plain], getattr(virtual, f)], axis=-1)
            for f in fields
        )
    )


@dataclass
class _Unfolding:
    """Obtuse corners whose strip of triangles is being unfolded; the plane as complex numbers.

    The corner's triangle is j, k, i with j at 0 and k on the positive real axis. The strip has
    arrived at the halfedge `gate`, running from `right` to `left` as seen along the strip.
    """

    corner: np.ndarray  # the halfedge j -> k
    apex: np.ndarray  # i
    far: np.ndarray  # k
    gate: np.ndarray
    start: np.ndarray
    end: np.ndarray

    def only(self, chosen):
        return _Unfolding(*(value[chosen] for value in self.__dict__.values()))


def _unfolded(surface, obtuse):
    """The corners (halfedges opposite to them) that could be split, and their virtual elements."""
    reach = surface.edge_length[previous_halfedge(obtuse)]
    apex = reach * np.exp(1j * surface.corner_angle[obtuse])
    far = surface.edge_length[obtuse].astype(complex)
    state = _Unfolding(obtuse, apex, far, obtuse, np.zeros_like(apex), far)
    corners, pieces = [], []
    for _ in range(_UNFOLDING_LIMIT):
        state = state.only(surface.twin[state.gate] >= 0)
        if not len(state.gate):
            break
        across = surface.twin[state.gate]
        point = _third_vertex(surface, state, across)
        seen, along_j = point - state.apex, -state.apex
        along_k = state.far - state.apex
        in_wedge = (_dot(seen, along_j) > 0) & (_dot(seen, along_k) > 0)
        corners.append(state.corner[in_wedge])
        pieces.append(
            _virtual_elements(surface, state.only(in_wedge), across[in_wedge], point[in_wedge])
        )
        # The wedge leaves the new triangle through the edge on the other side of its new vertex.
        middle = along_j / np.abs(along_j) + along_k / np.abs(along_k)
        beyond = (np.conj(middle) * seen).imag > 0
        state.gate = np.where(beyond, next_halfedge(across), previous_halfedge(across))
        state.end = np.where(beyond, point, state.end)
        state.start = np.where(beyond, state.start, point)
        state = state.only(~in_wedge)
    return _gathered(corners, pieces)


def _gathered(corners, pieces):
    corners = np.concatenate([*corners, np.zeros(0, np.int64)])
    fields = FrontElements.__dataclass_fields__
    if not pieces:
        none = np.zeros(0, np.int64)
        return corners, FrontElements(
            none, np.zeros((2, 0), np.int64), np.zeros((2, 0)), np.zeros(0), np.zeros((2, 0))
        )
    return corners, FrontElements(
        *(np.concatenate([getattr(piece, f) for piece in pieces], axis=-1) for f in fields)
    )


def _third_vertex(surface, state, across):
    """Place of the vertex opposite to the gate in the triangle behind it."""
    direction = (state.start - state.end) / np.abs(state.start - state.end)
    reach = surface.edge_length[previous_halfedge(across)]
    return state.end + reach * direction * np.exp(1j * surface.corner_angle[across])


def _virtual_elements(surface, state, across, point):
    """The two elements beside the straight line from the corner to the unfolded vertex."""
    near, leaving = state.corner, previous_halfedge(across)
    to_near = previous_halfedge(near)
    i, j, k = surface.tail[to_near], surface.tail[near], surface.head[near]
    m = surface.tail[leaving]
    line = point - state.apex
    at_target = surface.polar_angle[to_near] + surface.angle_scale[i] * _turn(-state.apex, line)
    at_parent = surface.polar_angle[leaving] + surface.angle_scale[m] * _turn(
        state.end - point, -line
    )
    along_line = at_target + np.pi - at_parent
    along_j, along_k = -surface.transport[to_near], surface.transport[next_halfedge(near)]
    first, first_apex = _local(np.zeros_like(point), point, state.apex)
    second, second_apex = _local(point, state.far, state.apex)
    return FrontElements(
        np.concatenate([i, i]),
        np.stack([np.concatenate([j, m]), np.concatenate([m, k])]),
        np.stack([np.concatenate([along_j, along_line]), np.concatenate([along_line, along_k])]),
        np.concatenate([first, second]),
        np.concatenate([first_apex, second_apex], axis=1),
    )


def _local(origin, end, apex):
    """Length of the edge origin -> end, and (2, n) the apex along it and to the left of it."""
    base = np.abs(end - origin)
    place = (apex - origin) * np.conj(end - origin) / base
    return base, np.stack([place.real, place.imag])


def _dot(a, b):
    return (np.conj(a) * b).real


def _turn(start, end):
    """Counter-clockwise angle between plane directions, in (-pi, pi]."""
    return np.angle(np.conj(start) * end)
