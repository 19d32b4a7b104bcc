"""The ways to a valid mesh, in the order in which they are tried. (method section 8)

direct              the chosen relaxation and all feature edges
finer field         the field on triangles cut into four: for details that are a few of them wide
other field         another relaxation, then the chosen one from a disturbed start
finer quads         twice as many quads along every line of the whole mesh
fewer feature edges without those beside inverted quads of the direct way, if there are such; without
                    those that end inside the surface; without those that are not marked; without any
midpoint split      three quads in every triangle: always valid, only more irregular
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .field.constraints import Constraints
from .settings import RELAXATIONS, Settings

DIRECT, FEWER_CREASES, MIDPOINT_SPLIT = "direct", "fewer feature edges", "midpoint split"
# Radians by which the crosses are disturbed at random where nothing fixes them.
DISTURBANCE = 0.4


@dataclass(frozen=True)
class Way:
    """One attempt.

    name      see above
    crease    (3F,) bool, feature halfedges to keep
    settings  Settings of this attempt
    seed      of the disturbance of the crosses before they are relaxed; None without
    halved    the field lives on the triangles of the working surface cut into four
    """

    name: str
    crease: np.ndarray
    settings: Settings
    seed: int | None = None
    halved: bool = False

    def start(self, angle, constraints: Constraints) -> np.ndarray:
        """(V,) float64, the propagated crosses, disturbed where they are free and it is wanted."""
        if self.seed is None:
            return angle
        noise = np.random.default_rng(self.seed).uniform(-DISTURBANCE, DISTURBANCE, len(angle))
        return np.where(constraints.fixed, angle, angle + noise)


def ways(creases, settings: Settings, may_halve: bool = True) -> list[Way]:
    """All attempts before the midpoint split.

    creases    list of (3F,) bool, feature halfedges, from all to none
    may_halve  False on surfaces of so many triangles that four times as many would take too long
    """
    first, second = (
        Way("other field", creases[0], replace(settings, relaxation=mode))
        for mode in reversed(RELAXATIONS) if mode != settings.relaxation
    )
    finer = replace(settings, quad_count=4 * settings.quad_count)
    if settings.edge_length is not None:
        finer = replace(settings, edge_length=0.5 * settings.edge_length)
    return [
        Way(DIRECT, creases[0], settings),
        *([Way("finer field", creases[0], settings, halved=True)] if may_halve else []),
        first,
        *(Way(FEWER_CREASES, crease, settings) for crease in creases[1:]),
        second,
        Way("other field", creases[0], settings, seed=1),
        Way("finer quads", creases[0], finer),
    ]
