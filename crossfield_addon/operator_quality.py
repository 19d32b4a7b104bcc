"""Operators on grid quality: colours in the viewport, and a table of all blocks."""

from __future__ import annotations

import bpy

from ..core.blocks.block_quality import block_quality, quality_csv, quality_rows
from ..core.errors import InputError
from . import quality_colours, results, shown_result
from .reporting import ReportingOperator, poll_blocks, result_of, results_in_object_mode

TABLE = "crossfield quality.csv"


class CROSSFIELD_OT_show_quality(ReportingOperator, bpy.types.Operator):
    """Colour the quads by block or by quality, in solid shading and as the active colour attribute"""

    bl_idname = "crossfield.show_quality"
    bl_label = "Show Quality"
    bl_options = {"REGISTER", "UNDO"}

    measure: bpy.props.EnumProperty(
        name="Measure",
        description="What the quads are coloured by",
        items=quality_colours.MEASURES,
        default="SCALED_JACOBIAN",
    )
    fit_range: bpy.props.BoolProperty(
        name="Fit Range",
        description=(
            "Dark is the worst quad of this mesh; otherwise it is the worst there can be, or an"
            " aspect ratio of 100"
        ),
        default=True,
    )

    @classmethod
    def poll(cls, context):
        return poll_blocks(cls, context)

    def run(self, context):
        collection = result_of(context)
        quads = results.find_object(collection, "quads")
        if quads is None:
            raise InputError("These results have no quad mesh to colour; regrid the blocks.")
        with results_in_object_mode(collection.objects):
            quality_colours.show_measure(collection, quads, self.measure, self.fit_range)
        quality_colours.show_in_viewports(context, self.measure)
        return {"FINISHED"}


class CROSSFIELD_OT_quality_table(ReportingOperator, bpy.types.Operator):
    """Write scaled Jacobian, skewness, aspect ratio and divisions of every block into a text"""

    bl_idname = "crossfield.quality_table"
    bl_label = "Quality Table"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return poll_blocks(cls, context)

    def run(self, context):
        collection = result_of(context)
        with results_in_object_mode(collection.objects):
            decomposition = shown_result.shown_decomposition(context, collection)
        quads, layout = decomposition.quads, decomposition.layout
        quality = block_quality(quads.points, quads.quads, layout, quads.scaled_jacobian)
        text = bpy.data.texts.get(TABLE) or bpy.data.texts.new(TABLE)
        text.from_string(quality_csv(quality_rows(layout, quality)))
        for area in context.screen.areas if context.screen else ():
            if area.type == "TEXT_EDITOR":
                area.spaces.active.text = text
        self.report({"INFO"}, f"{layout.count:,} blocks are in the text {text.name!r}")
        return {"FINISHED"}
