"""What the blocks of a result are to be divided into: locks, wall spacing, size."""

from __future__ import annotations

import json
from dataclasses import dataclass

from ..core.divisions.divisions import redivide
from ..core.divisions.wall_spacing import Grading


@dataclass(frozen=True)
class WantedDivisions:
    """Divisions that were asked for; without any, those of the decomposition stay.

    locks        pairs (block edge, divisions)
    grading      Grading or None
    quad_count   wanted number of quads, or None for that of the settings
    edge_length  wanted quad edge in object-space lengths, or None
    """

    locks: tuple = ()
    grading: Grading | None = None
    quad_count: int | None = None
    edge_length: float | None = None

    def divide(self, decomposition):
        """The decomposition divided so; raises CrossfieldError where that cannot be."""
        if self == WantedDivisions():
            return decomposition
        return redivide(
            decomposition, self.locks, self.grading, self.edge_length, self.quad_count
        )

    def text(self) -> str:
        """All but the locks as JSON."""
        grading = self.grading
        return json.dumps({
            "first_height": grading and grading.first_height,
            "growth": grading and grading.growth,
            "loops": grading and grading.loops,
            "quad_count": self.quad_count,
            "edge_length": self.edge_length,
        })


def from_text(text: str, locks=()) -> WantedDivisions:
    """The reverse of `WantedDivisions.text`, with locks."""
    kept = json.loads(text)
    grading = None
    if kept["first_height"] is not None:
        loops = kept["loops"]
        loops = None if loops is None else tuple(loops)
        grading = Grading(kept["first_height"], kept["growth"], loops)
    return WantedDivisions(tuple(locks), grading, kept["quad_count"], kept["edge_length"])
