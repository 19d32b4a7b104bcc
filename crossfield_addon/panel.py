"""The sidebar panel of the 3D viewport."""

from __future__ import annotations

import textwrap

import bpy

from . import results
from .operators import draw_details, draw_size


class CROSSFIELD_PT_main(bpy.types.Panel):
    """Controls, the operators and the result in words"""

    bl_idname = "CROSSFIELD_PT_main"
    bl_label = "Crossfield"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Crossfield"

    def draw(self, context):
        layout = self.layout
        draw_size(layout.column(), context.scene.crossfield)
        column = layout.column(align=True)
        column.scale_y = 1.4
        column.operator("crossfield.decompose", icon="MESH_GRID")
        row = layout.row(align=True)
        row.operator("crossfield.cross_field", text="Field", icon="ORIENTATION_NORMAL")
        row.operator("crossfield.trace", text="Lines", icon="CURVE_DATA")
        row.operator("crossfield.clear", text="Clear", icon="TRASH")
        self._draw_result(layout, context)

    def _draw_result(self, layout, context):
        source = context.object
        if source is None or source.type != "MESH":
            layout.label(text="Select a mesh.", icon="INFO")
            return
        sentence, notes = results.result_text(source)
        if not sentence:
            return
        width = max(24, int(context.region.width / (9 * context.preferences.system.ui_scale)))
        box = layout.box().column(align=True)
        for text, icon in [(sentence, "CHECKMARK")] + [(note, "ERROR") for note in notes]:
            for number, line in enumerate(textwrap.wrap(text, width)):
                box.label(text=line, icon="BLANK1" if number else icon)


class CROSSFIELD_PT_details(bpy.types.Panel):
    """The settings that a first run need not touch"""

    bl_idname = "CROSSFIELD_PT_details"
    bl_label = "Settings"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Crossfield"
    bl_parent_id = "CROSSFIELD_PT_main"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        draw_details(self.layout.column(), context.scene.crossfield)
