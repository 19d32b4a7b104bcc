"""Sentences for the user that name places and lengths, first known in the unit frame only."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .unit_frame import UnitFrame


@dataclass(frozen=True)
class PlacedSentence:
    """A sentence about places in the unit frame.

    text     with {length[0]} and {point[0]} and so on where numbers are to appear
    points   positions (3,) float64
    lengths  float
    """

    text: str
    points: tuple = ()
    lengths: tuple = ()

    def outward(self, frame: UnitFrame) -> str:
        """The sentence in the user's coordinates and lengths."""
        point = [
            "({:.4g}, {:.4g}, {:.4g})".format(*frame.outward(np.asarray(p))) for p in self.points
        ]
        length = [f"{value * frame.size:.3g}" for value in self.lengths]
        return self.text.format(point=point, length=length)


def missed_count(count: int) -> str:
    """How the sentence starts that a mesh has so many quads and not the wanted number."""
    return f"{count:,} quads instead of "
