"""The operators: each takes the active mesh, runs the core and writes the results."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from ..core.errors import CrossfieldError
from ..core.pipeline import decompose
from . import kept_blocks, mesh_arrays, results
from .properties import SettingProperties
from .reporting import ReportingOperator, results_in_object_mode
from .wall_properties import WallProperties, draw_walls
from .wanted_divisions import WantedDivisions


def _can_run(operator, context) -> bool:
    source = results.source_for(context.object)
    if source is None:
        operator.poll_message_set("There is no active object; select a mesh.")
    elif source.type != "MESH":
        operator.poll_message_set(
            f"{source.name!r} is not a mesh; select a mesh or convert the object to one."
        )
    elif context.object.mode not in {"OBJECT", "EDIT"}:
        operator.poll_message_set("Crossfield runs in object mode and in edit mode only.")
    else:
        return True
    return False


class _StageOperator(ReportingOperator, SettingProperties, WallProperties):
    """Runs the core up to one stage.

    A property that the caller did not give is taken from ``Scene.crossfield``.
    """

    bl_options = {"REGISTER", "UNDO"}
    stop_after = "quads"

    @classmethod
    def poll(cls, context):
        return _can_run(cls, context)

    def run(self, context):
        fill_in(self, context.scene.crossfield)
        source = results.source_for(context.object)
        arrays = mesh_arrays.read_object(context, source, self.marks)
        computed = self._decompose(context, arrays)
        notes, wanted, divided = [], WantedDivisions(), computed
        if computed.blocks is not None:
            materials = mesh_arrays.evaluated_materials(context, source)
            wanted = WantedDivisions(grading=self.grading(computed, *materials))
            divided, wanted, notes = _with_earlier_locks(source, computed, wanted)
        collection = results.find_collection(source)
        with results_in_object_mode(collection.objects if collection else ()):
            notes += results.write_results(
                context.scene, source, arrays, divided, self.keep_lines, self.products, computed,
                wanted,
            )
        for note in notes:
            self.report({"WARNING"}, note)
        self.report({"INFO"}, divided.sentence())
        return {"FINISHED"}

    def _decompose(self, context, arrays):
        progress = context.window_manager
        progress.progress_begin(0.0, 1.0)
        try:
            return decompose(
                arrays.points,
                arrays.polygons,
                self.settings(self.stop_after),
                progress=lambda fraction, stage: progress.progress_update(fraction),
                marked_edges=arrays.marked_edges,
            )
        finally:
            progress.progress_end()

    def draw(self, context):
        if self.stop_after == "quads":
            draw_size(self.layout, self)
        draw_details(self.layout, self, self.stop_after)
        if self.stop_after == "quads":
            draw_walls(self.layout, self, results.source_for(context.object))


def fill_in(operator, scene_settings) -> None:
    """Take properties that the caller of an operator did not give from the settings of the scene."""
    given = operator.properties
    if given.is_property_set("edge_length") and not given.is_property_set("size"):
        operator.size = "LENGTH"
    if given.is_property_set("quad_count") and not given.is_property_set("size"):
        operator.size = "COUNT"
    if given.is_property_set("first_height") and not given.is_property_set("use_walls"):
        operator.use_walls = True
    for name in (*SettingProperties.__annotations__, *WallProperties.__annotations__):
        if hasattr(operator, name) and not given.is_property_set(name):
            setattr(operator, name, getattr(scene_settings, name))


def _with_earlier_locks(source, computed, wanted):
    """The decomposition divided as wanted, with the locks of earlier results of the same blocks."""
    collection = results.find_collection(source)
    if collection is None or results.find_object(collection, "blocks") is None:
        return wanted.divide(computed), wanted, []
    try:
        with results_in_object_mode(collection.objects):
            mesh = results.find_object(collection, "blocks").data
            before = kept_blocks.kept_decomposition(mesh)
            earlier = kept_blocks.wanted_divisions(mesh)
        if not earlier.locks:
            return wanted.divide(computed), wanted, []
        if _same_blocks(before, computed):
            locked = replace(wanted, locks=earlier.locks)
            return locked.divide(computed), locked, []
    except CrossfieldError:
        # Locks that do not go with the new settings, or earlier results that were damaged.
        pass
    note = "The locks of the earlier blocks were dropped: they do not fit the new ones."
    return wanted.divide(computed), wanted, [note]


def _same_blocks(first, second) -> bool:
    """Do two decompositions have the same blocks in about the same places?"""
    if not np.array_equal(first.blocks.block_edge, second.blocks.block_edge):
        return False
    corners = [d.quads.points[d.blocks.corner] for d in (first, second)]
    return bool(np.abs(corners[0] - corners[1]).max() < 0.05 * first.whole.diameter)


def draw_size(layout, settings, blocks=True):
    """The controls for the size of the quads and, if wanted, for the number of blocks."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(settings, "size")
    layout.prop(settings, "quad_count" if settings.size == "COUNT" else "edge_length")
    if blocks:
        layout.prop(settings, "coarseness")
        layout.prop(settings, "t_junctions")


def draw_details(layout, settings, stop_after="quads"):
    """The controls for everything else that matters up to a stage."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(settings, "relaxation")
    if stop_after != "field":
        layout.prop(settings, "lines")
        if settings.lines == "full":
            layout.prop(settings, "line_distance")
            layout.prop(settings, "line_turn")
    layout.prop(settings, "kink_angle")
    layout.prop(settings, "keep_creases")
    if settings.keep_creases:
        layout.prop(settings, "feature_angle")
        layout.prop(settings, "feature_follow_angle")
    layout.column(heading="Keep marked").prop(settings, "marks")
    layout.prop(settings, "repair")
    layout.prop(settings, "weld_distance")
    layout.column(heading="Show").prop(settings, "products")
    if stop_after == "quads":
        layout.prop(settings, "keep_lines")


class CROSSFIELD_OT_decompose(_StageOperator, bpy.types.Operator):
    """From a mesh to quads and blocks"""

    bl_idname = "crossfield.decompose"
    bl_label = "Decompose into Blocks"
    bl_description = (
        "Turn the active mesh into blocks with four sides, filled with a conforming quad mesh. The"
        " mesh itself only gets attributes; results of an earlier run are replaced"
    )


class CROSSFIELD_OT_cross_field(_StageOperator, bpy.types.Operator):
    """Compute the cross field of the active mesh and its singularities, and nothing after"""

    bl_idname = "crossfield.cross_field"
    bl_label = "Cross Field Only"
    stop_after = "field"


class CROSSFIELD_OT_trace(_StageOperator, bpy.types.Operator):
    """Compute the cross field and trace the lines from its singularities and corners"""

    bl_idname = "crossfield.trace"
    bl_label = "Field and Lines Only"
    stop_after = "lines"


class CROSSFIELD_OT_clear(bpy.types.Operator):
    """Remove the results of the active mesh and the attributes written onto it"""

    bl_idname = "crossfield.clear"
    bl_label = "Clear Results"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return _can_run(cls, context)

    def execute(self, context):
        source = results.source_for(context.object)
        if not results.remove_results(source):
            self.report({"INFO"}, f"{source.name!r} has no results to remove.")
            return {"CANCELLED"}
        return {"FINISHED"}
