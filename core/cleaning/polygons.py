"""Polygons of any size as two flat arrays."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain, pairwise

import numpy as np

from ..errors import InputError


@dataclass(frozen=True)
class Polygons:
    """The corners of all polygons in one row.

    corner  (L,) int64, vertex of each corner, polygon after polygon, each in walking order
    start   (N + 1,) int64, polygon n is corner[start[n]:start[n + 1]]
    """

    corner: np.ndarray
    start: np.ndarray

    @property
    def count(self) -> int:
        return len(self.start) - 1

    @property
    def size(self) -> np.ndarray:
        """(N,) int64, corners of each polygon."""
        return np.diff(self.start)

    @property
    def corner_polygon(self) -> np.ndarray:
        """(L,) int64, the polygon of each corner."""
        return np.repeat(np.arange(self.count), self.size)

    @property
    def next_corner(self) -> np.ndarray:
        """(L,) int64, number of the corner after each corner in its polygon."""
        place = np.arange(1, len(self.corner) + 1)
        filled = self.size > 0
        place[self.start[1:][filled] - 1] = self.start[:-1][filled]
        return place

    @property
    def following(self) -> np.ndarray:
        """(L,) int64, the vertex after each corner in its polygon."""
        return self.corner[self.next_corner]

    def of_size(self, size: int) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (n,) of the polygons with so many corners, and their vertices (n, size)."""
        number = np.flatnonzero(self.size == size)
        return number, self.corner[self.start[number, None] + np.arange(size)]

    def kept(self, corner: np.ndarray) -> Polygons:
        """The same polygons with only those corners where corner (L,) bool is true."""
        total = np.concatenate([[0], np.cumsum(corner)])
        return Polygons(self.corner[corner], total[self.start])

    def chosen(self, number: np.ndarray) -> Polygons:
        """The polygons of these numbers (n,), ascending, alone and numbered anew."""
        keep = np.zeros(self.count, bool)
        keep[number] = True
        start = np.concatenate([[0], np.cumsum(self.size[keep])])
        return Polygons(self.corner[keep[self.corner_polygon]], start)

    def as_lists(self):
        """(N, 3) or (N, 4) int64 where all polygons are alike, else a list of index lists."""
        size = self.size
        if len(size) and size[0] in (3, 4) and (size == size[0]).all():
            return self.corner.reshape(-1, size[0])
        corner, start = self.corner.tolist(), self.start.tolist()
        return [corner[a:b] for a, b in pairwise(start)]


def as_polygons(polygons) -> Polygons:
    """Polygons from an (N, n) array of vertex numbers or from a sequence of index lists.

    Raises InputError where a vertex number is not a whole number.
    """
    if isinstance(polygons, Polygons):
        return polygons
    if isinstance(polygons, np.ndarray) and polygons.ndim == 2:
        corner = polygons.ravel()
        start = np.arange(len(polygons) + 1) * polygons.shape[1]
    else:
        polygons = list(polygons)
        try:
            size = np.fromiter(map(len, polygons), np.int64, len(polygons))
            corner = np.array(list(chain.from_iterable(polygons)))
        except (TypeError, ValueError):
            raise InputError(
                "The polygons are neither an array of vertex numbers nor lists of them; give"
                " one list of whole numbers for each polygon."
            ) from None
        start = np.concatenate([[0], np.cumsum(size)])
    return Polygons(_whole_numbers(corner, start), start.astype(np.int64))


def _whole_numbers(corner, start):
    """(L,) int64."""
    if corner.size == 0:
        return np.zeros(0, np.int64)
    if corner.dtype.kind in "iu":
        return corner.astype(np.int64)
    wrong = np.ones(len(corner), bool)
    if corner.dtype.kind == "f":
        # Beyond 2^53 not every whole number is a floating point number.
        wrong = ~(np.abs(corner) < 2.0**53) | (corner != np.floor(corner))
    if wrong.any():
        place = int(np.argmax(wrong))
        polygon = int(np.searchsorted(start, place, side="right")) - 1
        raise InputError(
            f"Polygon {polygon} refers to vertex {corner[place]}, which is not a whole number;"
            " vertices are numbered 0, 1, 2 and so on."
        )
    return corner.astype(np.int64)
