"""decompose(): from any polygons to blocks and quads, with progress and cancel.

Arrays in, arrays out: nothing here knows Blender, and nothing is written anywhere.
"""

from __future__ import annotations

import numpy as np

from .attempts import first_valid
from .blocks.t_layout import build_t_layout, find_t_edges, verify_t_layout
from .cleaning.cleaning import CleanMesh, clean
from .cleaning.numbering import numbered
from .decomposition import Decomposition
from .errors import LayoutError
from .features.creases import Creases
from .features.features import detect_features, marked_features
from .field.singularities import find_singularities
from .run import Run
from .sentences import missed_count
from .settings import Settings
from .stages import Stages
from .surface.resolution import refine
from .surface.surface import build_surface
from .unit_frame import unit_frame
from .user_coordinates import in_user_coordinates, settings_in_frame


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
    way, stages, notes = first_valid(run, working, creases, inner)
    result = _collect(run, settings, mesh, len(polygons), way, stages, notes)
    return in_user_coordinates(result, frame)


def _find_creases(given, mesh: CleanMesh, settings, marked_edges) -> Creases:
    found = np.zeros(len(given.twin), bool)
    if settings.feature_angle is not None:
        found = detect_features(given, settings.feature_angle, settings.feature_follow_angle)
    marked = np.zeros_like(found)
    if marked_edges is not None and len(marked_edges):
        marked = marked_features(given, mesh.vertex_origin, mesh.weld_target[marked_edges])
    return Creases(given, found | marked, marked)


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


def _count_notes(quad_count, block_count, settings):
    """A sentence where the layout does not allow the wanted number of quads."""
    if settings.edge_length is not None or abs(quad_count / settings.quad_count - 1) <= 0.15:
        return []
    return [
        f"{missed_count(quad_count)}{settings.quad_count:,}: with {block_count:,} blocks "
        "this is the nearest number that keeps their quads in shape."
    ]


def _collect(run, settings, mesh, polygon_count, way, stages: Stages, notes) -> Decomposition:
    surface, filling, blocks = stages.surface, stages.filling, stages.blocks
    singularities = find_singularities(surface, stages.field, stages.constraints)
    polygon_index = np.zeros(polygon_count, np.int64)
    np.add.at(polygon_index, stages.face_origin[singularities.face], singularities.k)
    polygon_block, t_edges = np.full(polygon_count, -1, np.int64), None
    notes = mesh.warnings + notes
    if blocks is not None:
        t_edges, quad_block, t_notes = _choose_blocks(run, settings, filling, blocks)
        # Of a polygon's triangles the last one that a quad covers speaks for it.
        known = filling.face_quad >= 0
        polygon_block[stages.face_origin[known]] = quad_block[filling.face_quad[known]]
        count_notes = _count_notes(len(filling.quads.quads), blocks.count, settings)
        notes += list(filling.warnings) + count_notes + t_notes
    run.seconds["total"] = run.total
    return Decomposition(
        settings, mesh, surface, stages.face_origin, stages.arrival.distance,
        stages.field.direction(surface), stages.field, singularities,
        stages.layout.complex if stages.layout else None, filling.quads if filling else None,
        blocks, filling.placement if filling else None, polygon_index, polygon_block, run.seconds,
        notes, stages.charts, way, t_edges,
    )
