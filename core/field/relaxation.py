"""Relaxation: a smoother field than the propagated one, with the same crosses on the boundary.

Propagation alone leaves a kink along the medial axis. Three modes:

none      the propagated field, as in the paper
harmonic  the matching of the propagated field is kept, and with it the singularities (each may move
          to a neighbouring triangle); within it the energy of `energy` is minimised, one
          linear system
diffused  the representation vectors u = exp(4 i angle) diffuse over the surface and are scaled
          back to unit length, over distances from a sixth of its size down to one edge
          length: singularities move to where they cost least and spurious pairs annihilate.
          Then harmonic.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..algebra.linear import SparseMatrix, solve
from ..algebra.multigrid import Multigrid
from ..errors import Cancelled
from ..surface.surface import TriangleSurface
from .constraints import Constraints
from .cross_field import CrossField, build_cross_field, wrap

# Diffusion: square of the longest distance over the area, number of distances, steps for each, and
# the share of the last change that is added to the next start. Five distances with momentum
# reach the energy of eight with five times as many plain steps.
LONGEST, DISTANCES, STEPS, MOMENTUM = 0.03, 5, 12, 0.8
SMALLEST_WEIGHT = 1e-6
CURE_ROUNDS = 3
POWER_STEPS = 15


def relax(
    surface: TriangleSurface,
    constraints: Constraints,
    angle: np.ndarray,
    mode: str,
    cancelled=None,
) -> np.ndarray:
    """(V,) float64, the relaxed crosses; those that the constraints fix stay.

    angle      (V,) float64, the propagated crosses
    mode       one of settings.RELAXATIONS
    cancelled  callable, asked now and then

    Components without any fixed cross get the smoothest field. A singularity in a triangle along
    the boundary would send two lines into one wall: where one comes out it is pushed away, see
    `_cured`. Raises Cancelled.
    """
    fixed, guide = constraints.fixed, constraints.guide
    given = np.where(fixed, constraints.angle, angle)
    if mode == "none":
        return given
    relaxed = given
    if mode == "diffused":
        relaxed = _diffused(surface, fixed, given, _diffusion_times(surface), cancelled, guide)
    field = build_cross_field(surface, relaxed, constraints)
    relaxed = _harmonic(surface, fixed, field, cancelled, guide)
    return _cured(surface, constraints, given, relaxed, mode, cancelled)


def _cured(surface, constraints, given, relaxed, mode, cancelled):
    """The relaxed crosses with as few singularities as possible in triangles along the boundary.

    The inner vertices of such triangles are held at their propagated crosses, which follow the
    wall, and the field is relaxed again over a short distance. Each round also holds the
    vertices along the wall in a wider neighbourhood of the singularities that are left.
    """
    held, best, fewest = constraints.fixed.copy(), relaxed, np.inf
    lining = _lining_vertices(surface)
    for ring in range(CURE_ROUNDS + 1):
        field = build_cross_field(surface, relaxed, constraints)
        trapped = _lining_faces(surface) & (field.index != 0)
        if np.count_nonzero(trapped) < fewest:
            best, fewest = relaxed, np.count_nonzero(trapped)
        near = lining & _neighbourhood(surface, trapped, ring)
        if ring == CURE_ROUNDS or held[near].all():
            return best
        held |= near
        relaxed = np.where(held, given, relaxed)
        if mode == "diffused":
            shortest = _diffusion_times(surface)[-1:]
            relaxed = _diffused(surface, held, relaxed, shortest, cancelled)
        field = build_cross_field(surface, relaxed, constraints)
        relaxed = _harmonic(surface, held, field, cancelled)


def _lining_faces(surface: TriangleSurface) -> np.ndarray:
    """(F,) bool, triangles with an edge on the boundary."""
    result = np.zeros(surface.face_count, bool)
    result[surface.loop_halfedges // 3] = True
    return result


def _lining_vertices(surface):
    """(V,) bool, inner vertices of the triangles along the boundary."""
    result = np.zeros(surface.vertex_count, bool)
    result[surface.triangles[_lining_faces(surface)]] = True
    return result & ~surface.on_boundary


def _neighbourhood(surface, faces, rings):
    """(V,) bool, the vertices of the faces and of so many rings round them."""
    inside = np.zeros(surface.vertex_count, bool)
    inside[surface.triangles[faces]] = True
    for _ in range(rings):
        inside[surface.triangles[inside[surface.triangles].any(1)]] = True
    return inside


def energy(surface: TriangleSurface, field: CrossField) -> float:
    """Smoothness energy of a field: the integral of the squared rate of turn (eq. 6 of the paper).

    The sum over edges of cotangent weight times squared rotation; dimensionless, the same at
    any scale. Negative weights count as none.
    """
    edge = surface.edges
    return float((edge_weights(surface) * field.rotation[edge] ** 2).sum())


def edge_weights(surface: TriangleSurface) -> np.ndarray:
    """(E,) float64, for each of surface.edges half the sum of the cotangents opposite it.

    Clamped from below to a tiny positive number: so all systems are positive definite.
    """
    edge = surface.edges
    twin = surface.twin[edge]
    other = np.where(twin >= 0, surface.cotangent[twin], 0.0)
    return np.maximum(0.5 * (surface.cotangent[edge] + other), SMALLEST_WEIGHT)


@dataclass(frozen=True)
class _Unknowns:
    """The Laplacian of the surface with the held vertices eliminated.

    held  (V,) bool
    """

    surface: TriangleSurface
    held: np.ndarray

    @cached_property
    def ends(self):
        """(2, E) int64, tails and heads of surface.edges."""
        edge = self.surface.edges
        return np.stack([self.surface.tail[edge], self.surface.head[edge]])

    @cached_property
    def weight(self):
        return edge_weights(self.surface)

    @cached_property
    def area(self):
        """(n,) float64, a third of the area of the triangles round each unknown vertex."""
        share = np.repeat(self.surface.face_area / 3, 3)
        return np.bincount(self.surface.tail, share, self.surface.vertex_count)[~self.held]

    def laplacian(self, parallel, values):
        """(matrix, right-hand side) of sum over edges of weight |x_head - parallel x_tail|^2.

        parallel  (E,) complex numbers of modulus 1, or 1
        values    (V,) x of the held vertices
        """
        tail, head = self.ends
        count = self.surface.vertex_count
        across = -self.weight * np.conj(parallel)
        row, column = np.concatenate([tail, head]), np.concatenate([head, tail])
        value = np.concatenate([across, across.conj()])
        degree = np.bincount(row, np.concatenate([self.weight, self.weight]), count)
        free = ~self.held
        number = np.cumsum(free) - 1
        known = free[row] & self.held[column]
        right = np.zeros(count, value.dtype)
        np.subtract.at(right, row[known], value[known] * values[column[known]])
        inner = free[row] & free[column]
        own = np.arange(np.count_nonzero(free))
        matrix = SparseMatrix.from_triplets(
            np.concatenate([number[row[inner]], own]), np.concatenate([number[column[inner]], own]),
            np.concatenate([value[inner], degree[free]]), len(own),
        )
        return matrix, right[free]


def _harmonic(surface, held, field, cancelled, guide=None):
    """Angles that minimise the energy, and the distance to the guide, with the matching kept."""
    unknowns = _Unknowns(surface, held)
    matrix, _ = unknowns.laplacian(1.0, np.zeros(surface.vertex_count))
    tail, head = unknowns.ends
    flow = unknowns.weight * field.rotation[surface.edges]
    count = surface.vertex_count
    divergence = np.bincount(tail, flow, count) - np.bincount(head, flow, count)
    angle = field.angle.copy()
    right = divergence[~held]
    if guide is not None:
        pull = unknowns.area * np.abs(guide[~held])
        matrix = matrix.plus_diagonal(pull)
        right = right + pull * wrap(np.angle(guide[~held]) / 4 - angle[~held])
    angle[~held] += solve(matrix, right, tolerance=1e-6, cancelled=cancelled)
    return angle


def _diffusion_times(surface):
    """(DISTANCES,) float64, squares of lengths, from long to short."""
    longest = LONGEST * surface.face_area.sum() / surface.component_count
    shortest = surface.mean_edge_length**2
    return np.geomspace(max(longest, shortest), shortest, DISTANCES)


def _diffused(surface, held, angle, times, cancelled, guide=None):
    """Angles after diffusion of the representation vectors over each of the times in turn.

    A step of implicit diffusion over time t, u + (C + M / t)^-1 (b - C u), is taken with one cycle
    of multigrid in place of the inverse, and with momentum.
    """
    unknowns = _Unknowns(surface, held)
    free = ~held
    if not free.any():
        return angle
    parallel = np.exp(4j * surface.transport[surface.edges])
    matrix, right = unknowns.laplacian(parallel, np.exp(4j * angle))
    u = np.exp(4j * angle[free])
    loose = _loose_vertices(surface, held)[free]
    if loose.any():
        u = _smoothest(unknowns, matrix, u, loose, cancelled)
    if guide is not None:
        matrix = matrix.plus_diagonal(unknowns.area * np.abs(guide[free]))
        right = right + unknowns.area * guide[free]
        u = _guided(surface, matrix, right, u, guide, free, cancelled)
    multigrid = Multigrid(matrix)
    for time in times:
        cycle = multigrid.plus_diagonal(unknowns.area / time)
        before = u
        for _ in range(STEPS):
            if cancelled is not None and cancelled():
                raise Cancelled("The decomposition was cancelled.")
            start = u + MOMENTUM * (u - before)
            before, u = u, _unit(start + cycle(right - matrix.dot(start)))
    result = angle.copy()
    result[free] = np.angle(u) / 4
    return result


def _unit(u):
    size = np.abs(u)
    return np.where(size > 1e-300, u / np.maximum(size, 1e-300), 1.0)


def _loose_vertices(surface, held):
    """(V,) bool, the vertices of components where no cross is held."""
    tied = np.zeros(surface.component_count, bool)
    tied[np.repeat(surface.component, 3)[held[surface.tail]]] = True
    loose = np.zeros(surface.vertex_count, bool)
    loose[surface.tail] = np.repeat(~tied[surface.component], 3)
    return loose


def _guided(surface, matrix, right, u, guide, free, cancelled):
    """Unit vectors u with those of components that have a guide replaced by the nearest to it."""
    led = np.zeros(surface.component_count, bool)
    led[np.repeat(surface.component, 3)[guide[surface.tail] != 0]] = True
    of_led = np.zeros(surface.vertex_count, bool)
    of_led[surface.tail] = np.repeat(led[surface.component], 3)
    if not led.any():
        return u
    shifted = matrix.plus_diagonal(np.full(len(u), 1e-9))
    found = solve(
        shifted, right, tolerance=1e-3, cancelled=cancelled, preconditioner=Multigrid(shifted)
    )
    return np.where(of_led[free] & (np.abs(found) > 1e-6), _unit(found), u)


def _smoothest(unknowns, matrix, u, loose, cancelled):
    """Unit vectors u with those of loose components replaced by the smoothest field.

    Inverse power iteration for the smallest eigenvector of the connection Laplacian, from the u
    given. A slight shift keeps the matrix regular where parallel transport has no holonomy.
    """
    shift = 0.01 * unknowns.area / unknowns.area.sum()
    shifted = matrix.plus_diagonal(shift)
    preconditioner = Multigrid(shifted)
    x = np.where(loose, u, 0.0)
    for _ in range(POWER_STEPS):
        x = solve(
            shifted, unknowns.area * x, start=x, tolerance=1e-2, cancelled=cancelled,
            preconditioner=preconditioner,
        )
        x /= max(np.abs(x).max(), 1e-300)
    return np.where(loose, _unit(x), u)
