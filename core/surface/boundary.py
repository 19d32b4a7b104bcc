"""Boundary loops as curves: arc length along a loop and back to points of the surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .projection import expand_ranges
from .surface import TriangleSurface


@dataclass(frozen=True)
class BoundaryLoops:
    """Arc length along the boundary loops of a surface. Build it with `build_loops`.

    halfedge    (B,) int64, the boundary halfedges, loop after loop (TriangleSurface.loop_halfedges)
    halfedge_loop (B,) int64
    position    (B,) float64, arc length from the tail of the loop's first halfedge to each tail
    length      (L,) float64, total length of each loop
    tail, step  (B, 3) float64, start of each halfedge and the vector to its end
    step_length (B,) float64
    key         (B,) float64, position in one row of all loops, for searching
    key_start   (L,) float64, where each loop begins in that row
    first       (L + 1,) int64, loop l is halfedge[first[l]:first[l + 1]]
    """

    halfedge: np.ndarray
    halfedge_loop: np.ndarray
    position: np.ndarray
    length: np.ndarray
    tail: np.ndarray
    step: np.ndarray
    step_length: np.ndarray
    key: np.ndarray
    key_start: np.ndarray
    first: np.ndarray

    def wrap(self, loop, position) -> np.ndarray:
        """(n,) float64, position moved by whole turns into [0, loop length)."""
        length = self.length[loop]
        wrapped = np.mod(position, length)
        return np.where(wrapped >= length, 0.0, wrapped)

    def locate(self, loop, position):
        """Index into halfedge (n,) int64 and the fraction (n,) along it, in [0, 1]."""
        position = self.wrap(loop, position)
        index = np.searchsorted(self.key, self.key_start[loop] + position, side="right") - 1
        index = np.clip(index, self.first[loop], self.first[loop + 1] - 1)
        fraction = (position - self.position[index]) / np.maximum(self.step_length[index], 1e-300)
        return index, np.clip(fraction, 0.0, 1.0)

    def point(self, loop, position):
        """Points on the boundary polyline.

        loop (n,) int, position (n,) float: arc length, any number of turns.
        Returns (point (n, 3) float64, face (n,) int64: the triangle that holds it).
        """
        return self.point_and_tangent(loop, position)[:2]

    def point_and_tangent(self, loop, position):
        """(point, face, tangent): as `point`, and unit vectors (n, 3) along the loop there.

        The surface is on their left.
        """
        index, fraction = self.locate(loop, position)
        step = self.step[index]
        tangent = step / np.maximum(self.step_length[index], 1e-300)[:, None]
        return self.tail[index] + fraction[:, None] * step, self.halfedge[index] // 3, tangent

    def closest(self, loop, points, points_at_once=256):
        """Arc length (n,) float64 of the place on loop (n,) int that is closest to each point."""
        result = np.zeros(len(points))
        for number in np.unique(loop):
            member = np.flatnonzero(loop == number)
            for first in range(0, len(member), points_at_once):
                some = member[first : first + points_at_once]
                result[some] = self._closest_on_one(number, points[some])
        return self.wrap(np.asarray(loop, np.int64), result)

    def chord_deviation(self, loop, position, advance) -> np.ndarray:
        """(n,) float64: how far the boundary strays from straight chords.

        A chord joins the points at position and at position + advance of its loop; the deviation
        is the largest distance of the boundary vertices between them from the segment. For
        advance up to one turn.
        """
        start, _ = self.point(loop, position)
        end, _ = self.point(loop, position + advance)
        index, _ = self.locate(loop, position)
        last, _ = self.locate(loop, position + advance)
        count = self.first[loop + 1] - self.first[loop]
        inside = np.mod(last - index, count)
        inside = np.where((inside == 0) & (advance > 0.5 * self.length[loop]), count, inside)
        chord, number = expand_ranges(np.ones_like(inside), inside + 1)
        vertex = self.first[loop[chord]] + np.mod(
            index[chord] - self.first[loop[chord]] + number, count[chord]
        )
        relative = self.tail[vertex] - start[chord]
        step = (end - start)[chord]
        along = (relative * step).sum(1) / np.maximum((step**2).sum(1), 1e-300)
        distance = np.linalg.norm(relative - np.clip(along, 0, 1)[:, None] * step, axis=1)
        result = np.zeros(len(start))
        np.maximum.at(result, chord, distance)
        return result

    def _closest_on_one(self, number, points):
        piece = slice(self.first[number], self.first[number + 1])
        tail, step, length = self.tail[piece], self.step[piece], self.step_length[piece]
        relative = points[:, None] - tail
        fraction = (relative * step).sum(2) / np.maximum(length**2, 1e-300)
        fraction = np.clip(fraction, 0.0, 1.0)
        distance = ((relative - fraction[:, :, None] * step) ** 2).sum(2)
        row, best = np.arange(len(points)), distance.argmin(1)
        return self.position[piece][best] + fraction[row, best] * length[best]


def build_loops(surface: TriangleSurface) -> BoundaryLoops:
    """The boundary loops of a surface, measured by arc length in object-space lengths."""
    if "boundary loops" not in surface.derived:
        surface.derived["boundary loops"] = _measure_loops(surface)
    return surface.derived["boundary loops"]


def _measure_loops(surface: TriangleSurface) -> BoundaryLoops:
    halfedge, first = surface.loop_halfedges, surface.loop_offset
    halfedge_loop = np.repeat(np.arange(surface.loop_count), np.diff(first))
    tail = surface.points[surface.tail[halfedge]]
    step = surface.points[surface.head[halfedge]] - tail
    step_length = np.linalg.norm(step, axis=1)
    total = np.concatenate([[0.0], np.cumsum(step_length)])
    key_start, length = total[first[:-1]], np.diff(total[first])
    position = total[:-1] - key_start[halfedge_loop]
    return BoundaryLoops(
        halfedge, halfedge_loop, position, length, tail, step, step_length,
        total[:-1], key_start, first,
    )
