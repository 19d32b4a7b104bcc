"""The operators: each takes the active mesh, runs the core and writes the results."""

from __future__ import annotations

import bpy

from ..core.errors import CrossfieldError
from ..core.pipeline import decompose
from . import mesh_arrays, results
from .properties import SettingProperties


def _can_run(operator, context) -> bool:
    source = context.object
    if source is None:
        operator.poll_message_set("There is no active object; select a mesh.")
    elif source.type != "MESH":
        operator.poll_message_set(
            f"{source.name!r} is not a mesh; select a mesh or convert the object to one."
        )
    elif source.mode not in {"OBJECT", "EDIT"}:
        operator.poll_message_set("Crossfield runs in object mode and in edit mode only.")
    else:
        return True
    return False


class _StageOperator(SettingProperties):
    """Runs the core up to one stage.

    A property that the caller did not give is taken from ``Scene.crossfield``.
    """

    bl_options = {"REGISTER", "UNDO"}
    stop_after = "quads"

    @classmethod
    def poll(cls, context):
        return _can_run(cls, context)

    def execute(self, context):
        self._fill_in(context.scene.crossfield)
        source = context.object
        progress = context.window_manager
        progress.progress_begin(0.0, 1.0)
        try:
            arrays = mesh_arrays.read_object(context, source, self.marks)
            decomposition = decompose(
                arrays.points,
                arrays.polygons,
                self.settings(self.stop_after),
                progress=lambda fraction, stage: progress.progress_update(fraction),
                marked_edges=arrays.marked_edges,
            )
        except CrossfieldError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except MemoryError:
            self.report({"ERROR"}, "The memory does not suffice for this mesh; use a coarser one.")
            return {"CANCELLED"}
        finally:
            progress.progress_end()
        notes = results.write_results(context.scene, source, arrays, decomposition, self.keep_lines)
        for note in notes:
            self.report({"WARNING"}, note)
        self.report({"INFO"}, decomposition.sentence())
        return {"FINISHED"}

    def _fill_in(self, scene_settings):
        given = self.properties
        if given.is_property_set("edge_length") and not given.is_property_set("size"):
            self.size = "LENGTH"
        if given.is_property_set("quad_count") and not given.is_property_set("size"):
            self.size = "COUNT"
        for name in SettingProperties.__annotations__:
            if not given.is_property_set(name):
                setattr(self, name, getattr(scene_settings, name))

    def draw(self, context):
        if self.stop_after == "quads":
            draw_size(self.layout, self)
        draw_details(self.layout, self, self.stop_after)


def draw_size(layout, settings):
    """The controls for the size of the quads and the number of blocks."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(settings, "size")
    layout.prop(settings, "quad_count" if settings.size == "COUNT" else "edge_length")
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
    if stop_after == "quads":
        layout.prop(settings, "keep_lines")


class CROSSFIELD_OT_decompose(_StageOperator, bpy.types.Operator):
    """Turn the active mesh into a conforming multi-block quad mesh"""

    bl_idname = "crossfield.decompose"
    bl_label = "Decompose into Blocks"


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
        if not results.remove_results(context.object):
            self.report({"INFO"}, f"{context.object.name!r} has no results to remove.")
            return {"CANCELLED"}
        return {"FINISHED"}
