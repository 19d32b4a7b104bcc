"""Several places proposed for one vertex of a quad mesh, and the choice between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..surface.projection import closest_point

# Ranks of candidates: the smallest wins.
FIXED, BOUNDARY, SINGULAR, PLAIN = range(4)


@dataclass(frozen=True)
class Candidates:
    """Places proposed for vertices; a vertex may have several.

    vertex (n,) int64; point (n, 3) float64; face (n,) int64; loop (n,) int64 or -1;
    loop_position (n,) float64; rank (n,) int64: the smallest rank of a vertex wins
    """

    vertex: np.ndarray
    point: np.ndarray
    face: np.ndarray
    loop: np.ndarray
    loop_position: np.ndarray
    rank: np.ndarray

    def select(self, index) -> Candidates:
        """The candidates of the given indices."""
        return Candidates(*(getattr(self, name)[index] for name in self.__dataclass_fields__))

    @staticmethod
    def join(*sources) -> Candidates:
        """The candidates of several sources, one source after the other."""
        names = Candidates.__dataclass_fields__
        return Candidates(*(np.concatenate([getattr(s, n) for s in sources]) for n in names))


def choose(surface, loops, candidates: Candidates) -> Candidates:
    """One place for each vertex, in the order of the vertices: Candidates with one for each.

    Of the candidates of smallest rank, those on a boundary loop are averaged by arc length, those
    inside are averaged and projected to the surface; a fixed one is taken as it is.
    """
    order = np.lexsort((candidates.rank, candidates.vertex))
    candidates = candidates.select(order)
    _, start, group = np.unique(candidates.vertex, return_index=True, return_inverse=True)
    group = group.ravel()
    best = candidates.rank == candidates.rank[start][group]
    count = np.bincount(group, best)
    result = candidates.select(start)
    several = count[group] > 1
    _merge_on_loops(loops, candidates, result, group, best & several)
    inside = best & several & (candidates.rank >= SINGULAR)
    if inside.any():
        merged = np.unique(group[inside])
        total = np.stack(
            [np.bincount(group[inside], candidates.point[inside, k], len(start)) for k in range(3)],
            axis=1,
        )
        mean = total[merged] / count[merged, None]
        result.point[merged], result.face[merged] = closest_point(surface, mean)
    return result


def _merge_on_loops(loops, candidates, result, group, chosen):
    """Several places on one boundary loop become their mean by arc length, in place."""
    chosen = np.flatnonzero(chosen & (candidates.rank == BOUNDARY))
    if not len(chosen):
        return
    owner = group[chosen]
    loop = result.loop[owner]
    half = 0.5 * loops.length[loop]
    offset = candidates.loop_position[chosen] - result.loop_position[owner]
    offset = loops.wrap(loop, offset + half) - half
    merged = np.unique(owner)
    mean = np.bincount(owner, offset, len(result.vertex)) / np.maximum(
        np.bincount(owner, minlength=len(result.vertex)), 1
    )
    position = loops.wrap(result.loop[merged], result.loop_position[merged] + mean[merged])
    result.loop_position[merged] = position
    result.point[merged], result.face[merged] = loops.point(result.loop[merged], position)
