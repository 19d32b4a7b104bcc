"""decompose(): the stages in order, from any polygons to blocks and quads, with progress and cancel.

Arrays in, arrays out: nothing here knows Blender, and nothing is written anywhere.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from time import process_time

import numpy as np

from .blocks import find_blocks, verify_blocks
from .charts import cut_along, share_nodes
from .cleaning import CleanMesh, clean
from .constraints import boundary_constraints
from .creases import Creases
from .cross_field import CrossField, build_cross_field
from .curvature import guide_by_curvature
from .decomposition import Decomposition
from .distance import arrival_distance
from .errors import Cancelled, LayoutError
from .features import detect_features, marked_features
from .filling import fill_cells
from .jagged import smooth_jagged
from .layout import trace_layout
from .midpoint import split_at_midpoints
from .numbering import numbered
from .patience import Patience
from .propagation import propagate
from .refinement import split_boundary_chords
from .relaxation import relax
from .resolution import WorkingSurface, halved, refine
from .settings import Settings
from .singularities import find_singularities
from .surface import build_surface
from .t_layout import build_t_layout, find_t_edges, verify_t_layout
from .unit_frame import unit_frame
from .user_coordinates import in_user_coordinates, settings_in_frame
from .ways import DIRECT, FEWER_CREASES, MIDPOINT_SPLIT, Way, ways

# Share of the whole work after which each stage ends, for the progress bar.
STAGE_ENDS = {
    "surface": 0.05, "distance": 0.15, "propagation": 0.2, "relaxation": 0.35, "lines": 0.5,
    "quads": 0.95, "blocks": 1.0,
}

# CPU seconds after which the way being tried is given up for the last one, which never fails.
PATIENCE = 60.0
# Where these ways fail, the creases that are to blame go first.
_GIVES_WAY = (DIRECT, FEWER_CREASES)
# Creases nearer than this share of the diameter to where a layout failed are to blame for it.
NEAR = 0.02
# A worst scaled Jacobian that is no more than rounding keeps above 0, unless the surface has corners
# so sharp; so many other ways are then tried, and the best one is taken.
POOR, MORE_WHEN_POOR = 1e-4, 2
# Triangles of a working surface that may be cut into four for another attempt.
MOST_TO_HALVE = 12_000
# Faults of the program itself: they are told in the report, and another way is taken all the same.
_SLIPS = (ArithmeticError, LookupError, ValueError)
_SLIP = "There is a fault in the program"


class Run:
    """The clock, progress and cancel of one run."""

    def __init__(self, progress=None, cancelled=None):
        self.seconds: dict[str, float] = {}
        self._progress = progress or (lambda fraction, stage: None)
        self.cancelled = cancelled or (lambda: False)
        self._done = 0.0

    @contextmanager
    def stage(self, name: str):
        """Time a stage in CPU seconds; raises Cancelled before and after it when asked to stop."""
        self._stop_if_cancelled()
        self._progress(self._done, name)
        start = process_time()
        try:
            yield
        finally:
            # A stage that fails has taken its time too.
            self.seconds[name] = self.seconds.get(name, 0.0) + process_time() - start
        self._done = max(self._done, STAGE_ENDS[name])
        self._stop_if_cancelled()
        self._progress(self._done, name)

    def _stop_if_cancelled(self):
        if self.cancelled():
            raise Cancelled("The decomposition was cancelled; nothing has been changed.")


def decompose(
    points, polygons, settings: Settings = Settings(), progress=None, cancelled=None,
    marked_edges=None,
) -> Decomposition:
    """Decompose a surface into four-sided blocks and fill them with quads.

    points        (V, 3) float
    polygons      (N, 3) or (N, 4) int, or a list of lists of vertex numbers
    settings      Settings
    progress      function (fraction from 0 to 1, name of the stage)
    cancelled     function () -> bool, asked between and within stages
    marked_edges  (n, 2) int or None, ends of edges that the mesh must keep as edge chains, besides
                  the creases that are found by angle

    Returns a Decomposition. Raises InputError (the mesh cannot be used), LayoutError (no valid
    layout was found), Cancelled; all with one sentence for the user.
    """
    run = Run(progress, cancelled)
    with run.stage("surface"):
        mesh = numbered(clean(points, polygons, settings.weld_distance, settings.repair))
        frame = unit_frame(mesh.points)
        inner = settings_in_frame(settings, frame)
        given = build_surface(frame.inward(mesh.points), mesh.triangles)
        creases = _find_creases(given, mesh, inner, marked_edges)
        working = refine(given, mesh.face_origin, kept=creases.all)
    way, notes, parts = _first_valid(run, working, creases, inner)
    result = _collect(run, settings, mesh, len(polygons), way, notes, *parts)
    return in_user_coordinates(result, frame)


def _find_creases(given, mesh: CleanMesh, settings, marked_edges) -> Creases:
    found = np.zeros(len(given.twin), bool)
    if settings.feature_angle is not None:
        found = detect_features(given, settings.feature_angle, settings.feature_follow_angle)
    marked = np.zeros_like(found)
    if marked_edges is not None and len(marked_edges):
        marked = marked_features(given, mesh.vertex_origin, mesh.weld_target[marked_edges])
    return Creases(given, found | marked, marked)


def _first_valid(run: Run, working: WorkingSurface, creases: Creases, settings):
    """The first way that leads to a valid mesh: (its name, sentences, what `_collect` takes)."""
    notes, failure, poor = [], None, []
    left = ways(creases.masks(), settings, working.surface.face_count <= MOST_TO_HALVE)
    while left and len(poor) <= MORE_WHEN_POOR:
        way = left.pop(0)
        patience = Patience(PATIENCE - sum(run.seconds.values()), run.cancelled)
        if notes and patience():
            break
        try:
            parts = _decompose_along(run, working, way, patience)
        except Cancelled:
            if not patience.ran_out:
                raise
            failure = LayoutError(f"It took longer than {PATIENCE:.0f} seconds.")
            notes.append(f"The {way.name} way was given up: {failure}")
            break
        except (LayoutError, *_SLIPS) as error:
            if not isinstance(error, LayoutError):
                error = LayoutError(f"{_SLIP} ({type(error).__name__}: {error}); please report it.")
            notes.append(f"The {way.name} way failed: {error}")
            failure = error
            if way.name in _GIVES_WAY and len(error.place):
                reach = NEAR * working.surface.diameter
                left = _without(creases.without_near(way.crease, error.place, reach), way) + left
            continue
        filling = parts[-3]
        quads = None if filling is None else filling.quads
        inverted = () if quads is None else quads.quads[quads.scaled_jacobian <= 0]
        if not len(inverted):
            worst = 1.0 if quads is None else float(quads.scaled_jacobian.min())
            if worst > POOR:
                return way.name, notes, parts
            poor.append((worst, way.name, list(notes), parts))
            notes.append(f"The {way.name} way failed: a quad would have no area.")
            continue
        notes.append(f"The {way.name} way failed: {len(inverted)} quads would be inverted.")
        if way.name in _GIVES_WAY:
            left = _without(creases.without_beside(way.crease, quads.points[inverted]), way) + left
    if poor:
        return max(poor, key=lambda found: found[0])[1:]
    if settings.stop_after != "quads":
        raise failure
    return MIDPOINT_SPLIT, notes, _split_triangles(run, working, creases.all, settings)


def _without(fewer, way: Way) -> list:
    """The way with fewer creases, if they are fewer."""
    if fewer.sum() == way.crease.sum():
        return []
    return [Way(FEWER_CREASES, fewer, way.settings)]


def _decompose_along(run: Run, working: WorkingSurface, way: Way, cancelled):
    """All stages on the surface cut along feature edges: what `_collect` takes."""
    settings = way.settings
    with run.stage("surface"):
        if way.halved:
            working = halved(working)
        crease = working.on_edges(way.crease)
        surface, constraints, face_origin, charts = _prepare(working, crease, settings)
    arrival, angle = _propagate(run, surface, constraints)
    angle = way.start(angle, constraints)
    field = _relax(run, surface, constraints, angle, settings.relaxation, cancelled)
    layout = filling = blocks = None
    notes = []
    if settings.stop_after != "field":
        limits = None
        if settings.lines == "full":
            limits = (settings.line_distance * surface.diameter, settings.line_turn)
        with run.stage("lines"):
            layout = trace_layout(surface, constraints, field, limits, cancelled, charts)
    if settings.stop_after == "quads":
        with run.stage("quads"):
            filling = fill_cells(surface, layout, settings, cancelled)
        blocks = _find_blocks(run, filling)
        notes = list(filling.warnings)
    return surface, charts, face_origin, constraints, arrival, field, layout, filling, blocks, notes


def _split_triangles(run: Run, working: WorkingSurface, crease, settings):
    """The last way, which never fails: the field as it is, and quads without it."""
    way = Way(MIDPOINT_SPLIT, crease, replace(settings, stop_after="field"))
    parts = list(_decompose_along(run, working, way, run.cancelled))
    surface, charts, _, constraints = parts[:4]
    whole, feature = surface, np.zeros(len(surface.twin), bool)
    if charts is not None:
        whole, feature = charts.whole, charts.across >= 0
    fixed = np.zeros(whole.vertex_count, bool)
    fixed[whole.tail[(constraints.corner | constraints.kink)[surface.tail]]] = True
    with run.stage("quads"):
        filling = split_at_midpoints(whole, feature, fixed, settings, run.cancelled)
    return (*parts[:7], filling, _find_blocks(run, filling), [])


def _find_blocks(run: Run, filling):
    with run.stage("blocks"):
        mesh = filling.quads
        blocks = find_blocks(mesh.quads, len(mesh.points), filling.source, mesh.crease)
        verify_blocks(blocks, mesh.quads)
    return blocks


def _choose_blocks(run: Run, settings, filling, blocks):
    """T-edges or None, the block of each quad, and sentences."""
    if not settings.t_junctions:
        return None, blocks.quad_block, []
    mesh = filling.quads
    with run.stage("blocks"):
        try:
            edges = find_t_edges(mesh.points, blocks, mesh.crease)
            layout = build_t_layout(mesh.quads, blocks, edges)
            verify_t_layout(layout, mesh.quads, mesh.crease)
        except LayoutError as error:
            return None, blocks.quad_block, [str(error)]
    return edges, layout.quad_block, []


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


def _propagate(run: Run, surface, constraints):
    with run.stage("distance"):
        arrival = arrival_distance(surface, constraints.fixed)
    with run.stage("propagation"):
        angle = propagate(surface, constraints, arrival)
    return arrival, angle


def _relax(run: Run, surface, constraints, angle, mode, cancelled) -> CrossField:
    with run.stage("relaxation"):
        angle = relax(surface, constraints, angle, mode, cancelled)
        return build_cross_field(surface, angle, constraints)


def _count_notes(quad_count, block_count, settings):
    """A sentence where the layout does not allow the wanted number of quads."""
    if settings.edge_length is not None or abs(quad_count / settings.quad_count - 1) <= 0.15:
        return []
    return [
        f"{quad_count:,} quads instead of {settings.quad_count:,}: with {block_count:,} blocks this "
        "is the nearest number that keeps their quads in shape."
    ]


def _collect(
    run, settings, mesh, polygon_count, way, way_notes, surface, charts, face_origin, constraints,
    arrival, field, layout, filling, blocks, notes,
) -> Decomposition:
    singularities = find_singularities(surface, field, constraints)
    polygon_index = np.zeros(polygon_count, np.int64)
    np.add.at(polygon_index, face_origin[singularities.face], singularities.k)
    polygon_block, t_edges = np.full(polygon_count, -1, np.int64), None
    if blocks is not None:
        t_edges, quad_block, t_notes = _choose_blocks(run, settings, filling, blocks)
        # Of a polygon's triangles the last one that a quad covers speaks for it.
        known = filling.face_quad >= 0
        polygon_block[face_origin[known]] = quad_block[filling.face_quad[known]]
        notes = [
            *notes, *_count_notes(len(filling.quads.quads), blocks.count, settings), *t_notes
        ]
    run.seconds["total"] = sum(run.seconds.values())
    return Decomposition(
        settings, mesh, surface, face_origin, arrival.distance, field.direction(surface), field,
        singularities, layout.complex if layout else None, filling.quads if filling else None,
        blocks, filling.placement if filling else None, polygon_index, polygon_block, run.seconds,
        mesh.warnings + way_notes + notes, charts, way, t_edges,
    )
