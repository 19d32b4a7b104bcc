"""The stages of one attempt: from the working surface and a way to its field, cells and quads."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .blocks.blocks import Blocks, find_blocks, verify_blocks
from .cells.layout import Layout, trace_layout
from .features.charts import Charts, cut_along, share_nodes
from .features.curvature import guide_by_curvature
from .features.jagged import smooth_jagged
from .field.constraints import Constraints, boundary_constraints
from .field.cross_field import CrossField, build_cross_field
from .field.distance import ArrivalDistance, arrival_distance
from .field.propagation import propagate
from .field.relaxation import relax
from .filling.filling import Filling, fill_cells
from .filling.midpoint import split_at_midpoints
from .run import Run
from .settings import Settings
from .surface.refinement import split_boundary_chords
from .surface.resolution import WorkingSurface, halved
from .surface.surface import TriangleSurface
from .ways import MIDPOINT_SPLIT, Way


@dataclass(frozen=True)
class Stages:
    """What the stages of one attempt found; None from where it was to stop.

    surface      TriangleSurface, cut along feature edges
    charts       Charts, how it was cut; None without feature edges
    face_origin  (F,) int64, the user's polygon of each triangle
    constraints  Constraints
    arrival      ArrivalDistance
    field        CrossField
    layout       Layout
    filling      Filling
    blocks       Blocks
    """

    surface: TriangleSurface
    charts: Charts | None
    face_origin: np.ndarray
    constraints: Constraints
    arrival: ArrivalDistance
    field: CrossField
    layout: Layout | None = None
    filling: Filling | None = None
    blocks: Blocks | None = None


def run_stages(run: Run, working: WorkingSurface, way: Way, cancelled) -> Stages:
    """All stages along a way, as far as its settings go.

    cancelled  function () -> bool, asked within the stages besides that of the run

    Raises LayoutError where the way does not lead to a mesh, Cancelled.
    """
    stages = _build_field(run, working, way, cancelled)
    settings, surface = way.settings, stages.surface
    if settings.stop_after == "field":
        return stages
    limits = None
    if settings.lines == "full":
        limits = (settings.line_distance * surface.diameter, settings.line_turn)
    with run.stage("lines"):
        layout = trace_layout(
            surface, stages.constraints, stages.field, limits, cancelled, stages.charts
        )
    stages = replace(stages, layout=layout)
    if settings.stop_after == "lines":
        return stages
    with run.stage("quads"):
        filling = fill_cells(surface, layout, settings, cancelled)
    return replace(stages, filling=filling, blocks=_find_blocks(run, filling))


def split_triangles(run: Run, working: WorkingSurface, crease, settings: Settings) -> Stages:
    """The last way, which never fails: the field as it is, and quads without it.

    crease  (3F,) bool, feature halfedges of the given surface
    """
    way = Way(MIDPOINT_SPLIT, crease, settings)
    stages = _build_field(run, working, way, run.cancelled)
    whole, feature = stages.surface, np.zeros(len(stages.surface.twin), bool)
    if stages.charts is not None:
        whole, feature = stages.charts.whole, stages.charts.across >= 0
    kept = stages.constraints.corner | stages.constraints.kink
    fixed = np.zeros(whole.vertex_count, bool)
    fixed[whole.tail[kept[stages.surface.tail]]] = True
    with run.stage("quads"):
        filling = split_at_midpoints(whole, feature, fixed, settings, run.cancelled)
    return replace(stages, filling=filling, blocks=_find_blocks(run, filling))


def _build_field(run: Run, working: WorkingSurface, way: Way, cancelled) -> Stages:
    with run.stage("surface"):
        if way.halved:
            working = halved(working)
        crease = working.on_edges(way.crease)
        surface, constraints, face_origin, charts = _prepare(working, crease, way.settings)
    with run.stage("distance"):
        arrival = arrival_distance(surface, constraints.fixed)
    with run.stage("propagation"):
        angle = propagate(surface, constraints, arrival)
    with run.stage("relaxation"):
        angle = way.start(angle, constraints)
        angle = relax(surface, constraints, angle, way.settings.relaxation, cancelled)
        field = build_cross_field(surface, angle, constraints)
    return Stages(surface, charts, face_origin, constraints, arrival, field)


def _prepare(working: WorkingSurface, crease, settings: Settings):
    """The working surface, cut along feature edges: (surface, constraints, face origin, charts).

    No edge may join two boundary vertices through the inside. charts is None without features.
    """
    if crease.any():
        charts, origin = cut_along(working.surface, crease)
        surface = charts.surface
        constraints = boundary_constraints(surface, settings.kink_angle)
        constraints = smooth_jagged(surface, constraints, charts.across >= 0)
        constraints = share_nodes(charts, constraints)
    else:
        charts = None
        surface, origin = split_boundary_chords(working.surface)
        constraints = boundary_constraints(surface, settings.kink_angle)
        constraints = smooth_jagged(surface, constraints)
    constraints = guide_by_curvature(surface, constraints)
    return surface, constraints, working.face_origin[origin], charts


def _find_blocks(run: Run, filling: Filling) -> Blocks:
    with run.stage("blocks"):
        mesh = filling.quads
        blocks = find_blocks(mesh.quads, len(mesh.points), filling.source, mesh.crease)
        verify_blocks(blocks, mesh.quads)
    return blocks
