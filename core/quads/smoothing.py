"""Smoothing of a quad mesh on its surface: no inverted quads, right angles, even sizes.

The mesh moves as a whole: a distortion energy that untangles inverted corners is minimised over
all vertices at once, vertices inside the surface in their tangent planes, those on the boundary
along their loops. After each round the vertices are walked over the surface to their new places.
The first rounds even out the mesh, the later ones care for its worst corners. (method section 10)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..algebra.descent import minimise
from ..algebra.linear import SparseMatrix
from ..algebra.multigrid import Multigrid
from ..errors import Cancelled
from ..surface.boundary import build_loops
from ..surface.projection import closest_point, plane_normal, surface_normal, walk
from ..surface.surface import TriangleSurface
from .placement import Placement
from .quad_energy import QuadEnergy, wanted_lengths
from .quality import quad_normal, scaled_jacobian

# Stages: power of the energy, share of the wanted edge length in its targets, most rounds, and the
# change of the score that makes another round pointless.
STAGES = ((2, 0.5, 6, 2e-2), (6, 0.2, 3, 5e-3), (12, 0.1, 4, 2e-3))
_UNTANGLING_ROUNDS = 8  # more of a stage while quads are still inverted
_ITERATIONS = 16
_MOST_DENSE = 400  # inner vertices up to which diffusion is a dense matrix: quicker than cycles
_SPACING_WEIGHT = 1.5  # of even spacing along the boundary, per corner energy and power
_MEAN_WEIGHT = 4.0  # of the mean against the worst scaled Jacobian when rounds are compared


def smooth(
    surface: TriangleSurface,
    placement: Placement,
    quad,
    edge_length: float | None = None,
    cancelled=None,
    across=None,
    stages=STAGES,
) -> Placement:
    """Move the vertices of a quad mesh to better places on the surface.

    quad         (Q, 4) int64, counter-clockwise
    edge_length  wanted edge length in object-space lengths; the mean length if None
    cancelled    callable, asked between steps
    across       (P,) int64 or None: on a surface cut along feature edges, the copy of each vertex
                 on the other side of the cut, -1 where it has none; both copies slide as one
    stages       sequence of (power of the energy, even; share of the wanted edge length in the
                 targets; most rounds; change of the score that makes another round pointless)

    Fixed vertices stay, boundary vertices slide along their loop in unchanged order, the others
    stay on the surface. The result is the best of all rounds: without inverted quads if one of
    them was, then by worst and mean scaled Jacobian; never worse than the input.
    Raises Cancelled.
    """
    if not len(quad):
        return placement
    quad = np.asarray(quad, np.int64)
    smoother = _Smoother(surface, quad, placement, edge_length, cancelled, across)
    best, best_score = placement, smoother.score(placement)
    score = best_score
    for power, share, rounds, settled in stages:
        for number in range(rounds + _UNTANGLING_ROUNDS):
            if number >= rounds and score > 0:
                break
            before, placement = score, smoother.round(placement, power, share)
            score = smoother.score(placement)
            if score > best_score:
                best, best_score = placement, score
            if score > 0 and abs(score - before) <= settled:
                break
        if score <= 0:
            break
    return best


class _Smoother:
    """What stays the same in all rounds."""

    def __init__(self, surface, quad, placement, edge_length, cancelled, across):
        self.surface, self.quad, self.cancelled = surface, quad, cancelled
        self.loops = build_loops(surface)
        self.plane = plane_normal(surface)
        corner = placement.point[quad]
        length = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
        self.vertex_count = len(placement.point)
        self.edge_length = float(edge_length or length.mean())
        movable = ~placement.fixed & (np.bincount(quad.ravel(), minlength=self.vertex_count) > 0)
        self.wall = np.flatnonzero(movable & (placement.loop >= 0))
        self.inner = np.flatnonzero(movable & (placement.loop < 0))
        self.slider, self.way = _sliders(self.wall, across)
        self.neighbours = _wall_edges(quad, placement.loop)
        self.even_out = _diffusion(quad, self.inner, self.vertex_count)

    def normals(self, placement):
        """(P, 3) float64, surface normals at the vertices."""
        if self.plane is not None:
            return np.tile(self.plane, (len(placement.point), 1))
        return surface_normal(self.surface, placement.face, placement.point)

    def gaps(self, placement):
        """Arc length of every mesh edge along the boundary loops."""
        tail, head = self.neighbours
        loop = placement.loop[tail]
        between = placement.loop_position[head] - placement.loop_position[tail]
        gap = self.loops.wrap(loop, between)
        gap = np.where(gap > 0, gap, self.loops.length[loop])
        return gap

    def room(self, gap):
        """(2, P) float64: how far a boundary vertex may slide back and forth along its loop."""
        tail, head = self.neighbours
        room = np.full((2, self.vertex_count), 1e-12 * self.edge_length)
        room[0, head] = 0.45 * gap
        room[1, tail] = 0.45 * gap
        return room

    def score(self, placement) -> float:
        """Minus the number of inverted quads, or a positive measure of quality."""
        jacobian = scaled_jacobian(placement.point, self.quad, self.normals(placement))
        inverted = int((jacobian <= 0).sum())
        return -float(inverted) if inverted else jacobian.min() + _MEAN_WEIGHT * jacobian.mean()

    def round(self, placement, power, share) -> Placement:
        normal = self.normals(placement)
        wanted = wanted_lengths(placement.point, self.quad, self.edge_length, share)
        normal_of_quad = _quad_normals(placement.point, self.quad, normal)
        energy = QuadEnergy(self.quad, normal_of_quad, wanted, power)
        worst = energy.worst_corner(placement.point)
        epsilon = float(np.sqrt(1e-6 + 0.04 * min(worst, 0.0) ** 2))
        motion = _Motion(self, placement, normal)

        def function(freedom):
            if self.cancelled is not None and self.cancelled():
                raise Cancelled("The computation was cancelled.")
            moved = motion.moved(freedom)
            value, gradient = energy(moved.point, epsilon)
            spread, along = motion.spacing(moved)
            weight = _SPACING_WEIGHT * power
            return value + weight * spread, motion.pull_back(moved, gradient, weight * along)

        freedom = minimise(
            function,
            np.zeros(motion.size),
            _ITERATIONS,
            0.1 * self.edge_length,
            0.5 * self.edge_length,
            motion.precondition,
        )
        return motion.apply(freedom)


@dataclass(frozen=True)
class _Moved:
    """Vertices on their way: places of all (P, 3); of those on the boundary the arc length along
    their loops, its derivative by the degree of freedom, and the unit vectors along the loops."""

    point: np.ndarray
    along: np.ndarray
    rate: np.ndarray
    tangent: np.ndarray


class _Motion:
    """Degrees of freedom of one round: two in the tangent plane of each inner vertex, one along
    the loop for each boundary vertex; the two copies of a vertex on a cut share theirs."""

    def __init__(self, smoother: _Smoother, placement, normal):
        self.smoother, self.placement = smoother, placement
        self.inner, self.wall = smoother.inner, smoother.wall
        self.loop = placement.loop[self.wall]
        self.position = placement.loop_position[self.wall]
        self.first, self.second = _tangents(normal[self.inner])
        self.slider, self.way = smoother.slider, smoother.way
        self.sliders = int(self.slider.max(initial=-1)) + 1
        self.size = 2 * len(self.inner) + self.sliders
        self.gap = smoother.gaps(placement)
        self.room = smoother.room(self.gap)[:, self.wall]

    def split(self, freedom):
        count = len(self.inner)
        return freedom[:count, None], freedom[count : 2 * count, None], freedom[2 * count :]

    def slide(self, freedom):
        """(positions along the loops, derivatives) of the boundary vertices.

        A smooth step towards the neighbours that never covers half the way: order is kept.
        """
        free = self.split(freedom)[2][self.slider] * self.way
        room = np.where(free < 0, self.room[0], self.room[1])
        part = np.tanh(free / room)
        return self.position + room * part, 1.0 - part * part

    def displacement(self, freedom):
        x, y, _ = self.split(freedom)
        return x * self.first + y * self.second

    def moved(self, freedom) -> _Moved:
        """Where the vertices are; inner ones in their tangent planes."""
        along, rate = self.slide(freedom)
        point = self.placement.point.copy()
        point[self.inner] += self.displacement(freedom)
        on_loop, _, tangent = self.smoother.loops.point_and_tangent(self.loop, along)
        point[self.wall] = on_loop
        return _Moved(point, along, rate, tangent)

    def spacing(self, moved: _Moved):
        """(energy, gradient (P,)) that keep boundary edges near the wanted length: log squared."""
        shift = np.zeros(self.smoother.vertex_count)
        shift[self.wall] = moved.along - self.position
        tail, head = self.smoother.neighbours
        gap = self.gap + shift[head] - shift[tail]
        stretch = np.log(gap / self.smoother.edge_length)
        pull = 2 * stretch / gap
        gradient = np.bincount(head, pull, len(shift)) - np.bincount(tail, pull, len(shift))
        return float((stretch**2).sum()), gradient

    def pull_back(self, moved: _Moved, gradient, along_gradient):
        """Gradient by the degrees of freedom from one by positions and one along the loops."""
        inner = gradient[self.inner]
        by_loop = (gradient[self.wall] * moved.tangent).sum(1)
        pull = (by_loop + along_gradient[self.wall]) * moved.rate
        return np.concatenate(
            [
                (inner * self.first).sum(1),
                (inner * self.second).sum(1),
                np.bincount(self.slider, pull * self.way, self.sliders),
            ]
        )

    def precondition(self, gradient):
        """Gradient spread over the mesh as by diffusion, so that the mesh moves as a whole."""
        x, y, along = self.split(gradient)
        if self.smoother.plane is not None:  # the tangents are the same everywhere
            x, y = self.smoother.even_out(np.concatenate([x, y], axis=1)).T
        else:
            spread = self.smoother.even_out(x * self.first + y * self.second)
            x, y = (spread * self.first).sum(1), (spread * self.second).sum(1)
        return np.concatenate([x, y, along / 3])

    def apply(self, freedom) -> Placement:
        """The vertices walked over the surface to their new places."""
        old, smoother = self.placement, self.smoother
        point, face, position = old.point.copy(), old.face.copy(), old.loop_position.copy()
        move = self.displacement(freedom)
        inner, wall = self.inner, self.wall
        point[inner], face[inner] = walk(smoother.surface, old.point[inner], old.face[inner], move)
        if smoother.plane is not None:
            self._reach_goals(old.point[inner] + move, point, face)
        position[wall] = smoother.loops.wrap(self.loop, self.slide(freedom)[0])
        point[wall], face[wall] = smoother.loops.point(self.loop, position[wall])
        return replace(old, point=point, face=face, loop_position=position)

    def _reach_goals(self, goal, point, face):
        """Walks that the boundary stopped: in a plane the goal may still be on the surface."""
        gap = np.linalg.norm(goal - point[self.inner], axis=1)
        short = np.flatnonzero(gap > 1e-9 * self.smoother.surface.diameter)
        if len(short):
            vertex = self.inner[short]
            point[vertex], face[vertex] = closest_point(self.smoother.surface, goal[short])


def _tangents(normal):
    """Two unit vectors (n, 3) that make a right-handed frame with each normal."""
    axis = np.eye(3)[np.abs(normal).argmin(1)]
    first = np.cross(axis, normal)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-300)
    return first, np.cross(normal, first)


def _quad_normals(points, quad, vertex_normal):
    """(Q, 3): normals of the quads themselves where these face outwards, else of the surface."""
    surface_side = vertex_normal[quad].sum(1)
    surface_side /= np.maximum(np.linalg.norm(surface_side, axis=1, keepdims=True), 1e-300)
    own = quad_normal(points, quad)
    agrees = (own * surface_side).sum(1) > 0.5
    return np.where(agrees[:, None], own, surface_side)


def _wall_edges(quad, loop):
    """(tail, head) of the mesh edges along the boundary loops, the surface on the left."""
    tail, head = quad.ravel(), np.roll(quad, -1, axis=1).ravel()
    count = np.int64(len(loop))
    alone = ~np.isin(tail * count + head, head * count + tail)
    along = alone & (loop[tail] >= 0) & (loop[tail] == loop[head])
    return tail[along], head[along]


def _sliders(wall, across):
    """For each sliding vertex the number of its degree of freedom, and its way along it, 1 or -1.

    Loops have the surface on their left: copies on both sides of a cut slide in opposite ways.
    """
    first = wall
    if across is not None:
        first = np.where(across[wall] < 0, wall, np.minimum(wall, across[wall]))
    slider = np.unique(first, return_inverse=True)[1].ravel()
    return slider, np.where(wall == first, 1.0, -1.0)


def _diffusion(quad, inner, count):
    """Approximate inverse of the graph Laplacian of the inner vertices: (n, k) -> (n, k)."""
    number = np.full(count, -1)
    number[inner] = np.arange(len(inner))
    tail, head = quad.ravel(), np.roll(quad, -1, axis=1).ravel()
    pair = np.unique(np.concatenate([tail * count + head, head * count + tail]))
    row, column = number[pair // count], number[pair % count]
    degree = np.bincount(row[row >= 0], minlength=len(inner))
    linked = (row >= 0) & (column >= 0)
    if not linked.any():
        return lambda vectors: vectors / np.maximum(degree, 1)[:, None]
    each = np.arange(len(inner))
    laplacian = SparseMatrix.from_triplets(
        np.concatenate([row[linked], each]),
        np.concatenate([column[linked], each]),
        np.concatenate([-np.ones(linked.sum()), degree * (1 + 1e-3)]),
        len(inner),
    )
    if len(inner) <= _MOST_DENSE:
        inverse = np.linalg.inv(laplacian.dense())
        return lambda vectors: inverse @ vectors
    return partial(_spread, Multigrid(laplacian))


def _spread(cycle, vectors):
    """A multigrid cycle for each column of vectors (n, k); for two at a time as complex numbers."""
    result = np.empty_like(vectors)
    for first in range(0, vectors.shape[1] - 1, 2):
        pair = cycle(vectors[:, first] + 1j * vectors[:, first + 1])
        result[:, first], result[:, first + 1] = pair.real, pair.imag
    if vectors.shape[1] % 2:
        result[:, -1] = cycle(np.ascontiguousarray(vectors[:, -1]))
    return result
