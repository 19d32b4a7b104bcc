"""Results computed in the unit frame, handed out in the user's coordinates and lengths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .decomposition import Decomposition
from .sentences import PlacedSentence
from .settings import Settings
from .unit_frame import UnitFrame


def settings_in_frame(settings: Settings, frame: UnitFrame) -> Settings:
    """The same settings with lengths measured in the unit frame."""
    if settings.edge_length is None:
        return settings
    return replace(settings, edge_length=settings.edge_length / frame.size)


def in_user_coordinates(result: Decomposition, frame: UnitFrame) -> Decomposition:
    """The same decomposition with all points and lengths of its parts taken out of the frame.

    Vertices of the given mesh get exactly the user's coordinates.
    """
    given = result.clean.points
    surface = _surface(result.surface, frame, given)
    charts = result.charts
    if charts is not None:
        charts = replace(charts, surface=surface, whole=_surface(charts.whole, frame, given))
    return replace(
        result,
        surface=surface,
        charts=charts,
        distance=result.distance * frame.size,
        singularities=_moved(result.singularities, frame, "position"),
        complex=_moved(
            result.complex, frame, "node_position", "arc_point", lengths=("arc_loop_start",)
        ),
        quads=_moved(result.quads, frame, "points"),
        warnings=[w.outward(frame) if isinstance(w, PlacedSentence) else w for w in result.warnings],
        placement=_moved(result.placement, frame, "point", lengths=("loop_position",)),
    )


def _moved(part, frame, *points, lengths=()):
    if part is None:
        return None
    changed = {name: frame.outward(getattr(part, name)) for name in points}
    changed |= {name: getattr(part, name) * frame.size for name in lengths}
    return replace(part, **changed)


def _surface(surface, frame, given):
    points = np.concatenate([given, frame.outward(surface.points[len(given) :])])
    return replace(surface, points=points, edge_length=surface.edge_length * frame.size)
