"""What the user can choose, with defaults, and the checks on it."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, radians

from .errors import SettingsError

RELAXATIONS = ("none", "harmonic", "diffused")
LINES = ("motorcycle", "full")
STAGES = ("field", "lines", "quads")
COARSENESSES = ("direct", "balanced", "fewest")


@dataclass(frozen=True)
class Settings:
    """Settings of a decomposition.

    edge_length      wanted quad edge in object-space lengths, or None
    quad_count       wanted number of quads, used when edge_length is None
    relaxation       "none" (the paper), "harmonic" or "diffused"
    lines            "motorcycle" (lines stop at lines) or "full" (the paper: lines cross)
    coarseness       "direct" (blocks as the lines were traced), "balanced" (few and well shaped) or
                     "fewest" (shapes count less)
    t_junctions      True joins blocks to the fewest there can be: a corner of one may then lie inside
                     a side of another. The quads are the same, and conform
    kink_angle       radians; boundary vertices that turn by more stay vertices of the mesh
    feature_angle    radians between triangles from which their edge is a feature edge, None: never
    feature_follow_angle  radians down to which a crease is followed from its ends
    weld_distance    vertices no farther apart become one, object-space lengths; 0 welds only loose
                     faces and the ends of edges without length
    repair           False refuses a faulty mesh instead of repairing it
    line_distance    limit on a full streamline, in diameters of the surface
    line_turn        limit on the total turning of a full streamline, in radians
    stop_after       last stage to run: "field", "lines" or "quads"
    """

    edge_length: float | None = None
    quad_count: int = 2000
    relaxation: str = "diffused"
    lines: str = "motorcycle"
    coarseness: str = "balanced"
    t_junctions: bool = False
    kink_angle: float = radians(20.0)
    feature_angle: float | None = radians(40.0)
    feature_follow_angle: float = radians(20.0)
    weld_distance: float = 0.0
    repair: bool = True
    line_distance: float = 20.0
    line_turn: float = radians(3600.0)
    stop_after: str = "quads"

    def __post_init__(self):
        if self.edge_length is not None and not (
            isfinite(self.edge_length) and self.edge_length > 0
        ):
            raise SettingsError(f"The edge length {self.edge_length} must be a positive number.")
        if self.quad_count < 1:
            raise SettingsError(f"The number of quads {self.quad_count} must be at least 1.")
        if not 0 < self.kink_angle < radians(90):
            raise SettingsError("The kink angle must lie between 0 and 90 degrees.")
        if self.feature_angle is not None and not (
            0 < self.feature_follow_angle <= self.feature_angle < radians(180)
        ):
            raise SettingsError(
                "The feature angles must lie between 0 and 180 degrees, and the one to follow a "
                "crease must not exceed the one to start it."
            )
        if not (isfinite(self.weld_distance) and self.weld_distance >= 0):
            raise SettingsError(f"The weld distance {self.weld_distance} must not be negative.")
        if not (self.line_distance > 0 and self.line_turn > 0):
            raise SettingsError("The limits of streamlines must be positive.")
        for value, allowed, name in (
            (self.relaxation, RELAXATIONS, "relaxation"),
            (self.lines, LINES, "lines"),
            (self.coarseness, COARSENESSES, "coarseness"),
            (self.stop_after, STAGES, "stage to stop after"),
        ):
            if value not in allowed:
                raise SettingsError(
                    f"The {name} {value!r} is unknown; choose one of {', '.join(allowed)}."
                )
