"""The sidebar panels of the 3D viewport."""

from __future__ import annotations

import textwrap

import bpy

from . import quality_colours, results
from .block_edge_selection import active_block_edge
from .operator_export import EXPORTS
from .operators import draw_details, draw_size
from .wall_properties import draw_walls


class _SidebarPanel:
    """Where our panels are."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Crossfield"


class _SubPanel(_SidebarPanel):
    """A closed panel inside the main one."""

    bl_parent_id = "CROSSFIELD_PT_main"
    bl_options = {"DEFAULT_CLOSED"}


class CROSSFIELD_PT_main(_SidebarPanel, bpy.types.Panel):
    """Controls, the operators and the result in words"""

    bl_idname = "CROSSFIELD_PT_main"
    bl_label = "Crossfield"

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
        collection = results.find_collection(source)
        if collection is None and (source is None or source.type != "MESH"):
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


class CROSSFIELD_PT_details(_SubPanel, bpy.types.Panel):
    """The settings that a first run need not touch"""

    bl_idname = "CROSSFIELD_PT_details"
    bl_label = "Settings"

    def draw(self, context):
        draw_details(self.layout.column(), context.scene.crossfield)


class CROSSFIELD_PT_divisions(_SubPanel, bpy.types.Panel):
    """Numbers of quads along block edges, and their spacing towards walls"""

    bl_idname = "CROSSFIELD_PT_divisions"
    bl_label = "Divisions"

    def draw(self, context):
        layout = self.layout
        column = layout.column(align=True)
        column.operator("crossfield.edit_block_edges", icon="EDGESEL")
        edge = active_block_edge(context.object)
        if edge is not None:
            layout.label(text=edge.sentence(), icon="LOCKED" if edge.state else "UNLOCKED")
            column = layout.column(align=True)
        row = column.row(align=True)
        row.operator("crossfield.lock_divisions", text="Lock", icon="LOCKED")
        row.operator("crossfield.unlock_divisions", text="Unlock", icon="UNLOCKED")
        every = row.operator("crossfield.unlock_divisions", text="Unlock All")
        every.every = True
        source = results.source_for(context.object)
        draw_walls(layout.column(), context.scene.crossfield, source)
        layout.operator("crossfield.regrid", icon="FILE_REFRESH")


class CROSSFIELD_PT_quality(_SubPanel, bpy.types.Panel):
    """Grid quality as colours and as a table"""

    bl_idname = "CROSSFIELD_PT_quality"
    bl_label = "Quality"

    def draw(self, context):
        layout = self.layout
        collection = results.find_collection(context.object)
        shown = "NONE" if collection is None else quality_colours.shown_measure(collection)
        column = layout.column(align=True)
        for measure, label, _ in quality_colours.MEASURES:
            button = column.operator(
                "crossfield.show_quality", text=label, depress=measure == shown
            )
            button.measure = measure
        if collection is not None:
            _draw_range(layout, quality_colours.shown_range(collection))
        rows = results.quality_table(collection)
        if rows:
            grid = layout.box().column(align=True)
            for row in [("", "Worst", "Mean"), *rows]:
                _draw_row(grid, row)
        layout.operator("crossfield.quality_table", icon="SPREADSHEET")


def _draw_range(layout, values):
    if values:
        dark, light = values
        layout.label(text=f"Dark {dark:.3g}, light {light:.3g}", icon="COLOR")


def _draw_row(layout, row):
    split = layout.split(factor=0.56)
    split.label(text=row[0])
    numbers = split.split(factor=0.5)
    for number in row[1:]:
        numbers.label(text=number)


class CROSSFIELD_PT_export(_SubPanel, bpy.types.Panel):
    """The blocks as files for solvers; also in File > Export"""

    bl_idname = "CROSSFIELD_PT_export"
    bl_label = "Export"

    def draw(self, context):
        column = self.layout.column(align=True)
        for operator in EXPORTS:
            column.operator(operator.bl_idname, text=operator.bl_label.removeprefix("Export "))
