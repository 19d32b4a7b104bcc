"""The feature edges of a run, and which of them to give up where no valid mesh keeps them all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..surface.surface import TriangleSurface
from .features import without_chains_near, without_open_ends

# Creases nearer to an inverted quad than so many of its mean edge lengths are to blame for it.
_NEAR = 1.5


@dataclass(frozen=True)
class Creases:
    """Feature edges of a surface; masks are (3F,) bool, true on both halfedges of an edge.

    surface  TriangleSurface, as it was given
    all      those found by angle and those that the user marked
    marked   those that the user marked
    """

    surface: TriangleSurface
    all: np.ndarray
    marked: np.ndarray

    def masks(self) -> list:
        """Fewer and fewer: all, those without open ends or marked, marked ones, none."""
        result = [self.all]
        for simpler in (
            without_open_ends(self.surface, self.all) | self.marked,
            self.marked,
            np.zeros_like(self.all),
        ):
            if simpler.sum() < result[-1].sum():
                result.append(simpler)
        return result

    def without_near(self, crease, points, reach) -> np.ndarray:
        """A mask without the pieces that come near places where it went wrong; marked ones stay.

        crease  (3F,) bool; points (n, 3) float64; reach (n,) float64 or one for all
        """
        reach = np.broadcast_to(reach, len(points))
        return without_chains_near(self.surface, crease, np.asarray(points), reach, self.marked)

    def without_beside(self, crease, corners) -> np.ndarray:
        """The same for inverted quads with corners (n, 4, 3) float64."""
        size = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).mean(1)
        return self.without_near(crease, corners.mean(1), _NEAR * size)
