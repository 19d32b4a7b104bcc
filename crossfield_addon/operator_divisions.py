"""Operators on the divisions of blocks: lock and unlock the counts of block edges, divide anew."""

from __future__ import annotations

from dataclasses import replace

import bpy
import numpy as np

from ..core.blocks.chords import find_chords
from ..core.errors import InputError
from . import results, shown_result
from .block_edge_selection import present_divisions, select_edges, selected_edges
from .operators import draw_size, fill_in
from .properties import SettingProperties
from .reporting import ReportingOperator, poll_blocks, result_of, results_in_object_mode
from .result_objects import read_numbers
from .typed_numbers import as_typed
from .wall_properties import WallProperties, draw_walls

_EDGE = "Number of the block edge; -1 takes those that are selected on the block mesh"


class _DivisionOperator(ReportingOperator):
    """Divides the blocks of the active result anew; a subclass says how, with `wish`."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return poll_blocks(cls, context)

    def run(self, context):
        collection = result_of(context)
        with results_in_object_mode(collection.objects):
            computed, before, _ = shown_result.divided(collection)
            edges = selected_edges(context.object, results.find_object(collection, "blocks"))
            wanted = self.wish(context, collection, computed, before, edges)
            _refuse_lost_edges(results.find_object(collection, "blocks").data, wanted, computed)
            divided = wanted.divide(computed)
            source = results.source_of(collection)
            results.update_divisions(collection, source, divided, wanted)
            select_edges(context.object, edges)
        for note in [note for note in divided.warnings if note not in computed.warnings]:
            self.report({"WARNING"}, note)
        self.report({"INFO"}, self.outcome(divided, wanted))
        return {"FINISHED"}


def _refuse_lost_edges(mesh, wanted, computed):
    """Locks are attributes of edges: without the edge there is no place for one."""
    there = read_numbers(mesh, "EDGE", "block_edge")
    for edge, _ in wanted.locks:
        if edge < len(computed.blocks.edge_on_boundary) and edge not in there:
            raise InputError(
                f"Block edge {edge} was deleted from the block mesh; decompose the mesh again."
            )


class CROSSFIELD_OT_lock_divisions(_DivisionOperator, bpy.types.Operator):
    """Locks on block edges"""

    bl_idname = "crossfield.lock_divisions"
    bl_label = "Lock Divisions"
    bl_description = (
        "Fix the number of quads along the selected block edges. All edges that face them across"
        " blocks follow, and the quads are made anew; the blocks stay"
    )

    divisions: bpy.props.IntProperty(
        name="Divisions",
        description="Number of quads along each of the block edges",
        default=10,
        min=1,
        soft_max=1000,
    )
    edge: bpy.props.IntProperty(name="Edge", description=_EDGE, default=-1, min=-1)

    def invoke(self, context, event):
        if not self.properties.is_property_set("divisions"):
            self.divisions = present_divisions(context.object) or self.divisions
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop(self, "divisions")

    def wish(self, context, collection, computed, before, edges):
        edges = [self.edge] if self.edge >= 0 else edges
        if not len(edges):
            raise InputError(
                "No block edge is selected; select edges of the block mesh in edit mode."
            )
        locks = dict(before.locks) | {int(edge): self.divisions for edge in edges}
        return replace(before, locks=tuple(sorted(locks.items())))

    def outcome(self, divided, wanted):
        chord = find_chords(divided.blocks).edge_chord
        locked = [edge for edge, _ in wanted.locks]
        follow = np.isin(chord, chord[locked]).sum() - len(locked)
        edges = "edge" if len(locked) == 1 else "edges"
        return (
            f"{len(locked)} block {edges} locked, {follow} more must follow;"
            f" {len(divided.quads.quads):,} quads"
        )


def draw_edge_menu(menu, context):
    """The entries in the context menu of edit mode, on block meshes."""
    if context.object is not None and context.object.get(results.ROLE) == "blocks":
        menu.layout.separator()
        menu.layout.operator("crossfield.lock_divisions", icon="LOCKED")
        menu.layout.operator("crossfield.unlock_divisions", icon="UNLOCKED")


class CROSSFIELD_OT_unlock_divisions(_DivisionOperator, bpy.types.Operator):
    """Free the selected block edges, and all that face them across blocks, of locked divisions"""

    bl_idname = "crossfield.unlock_divisions"
    bl_label = "Unlock Divisions"

    edge: bpy.props.IntProperty(name="Edge", description=_EDGE, default=-1, min=-1)
    every: bpy.props.BoolProperty(
        name="All Edges", description="Free all block edges, selected or not", default=False
    )

    def wish(self, context, collection, computed, before, edges):
        if self.every:
            return replace(before, locks=())
        edges = [self.edge] if self.edge >= 0 else edges
        chord = find_chords(computed.blocks).edge_chord
        known = [edge for edge in edges if edge < len(chord)]
        free = set(chord[known].tolist())
        kept = tuple((edge, count) for edge, count in before.locks if chord[edge] not in free)
        if kept == before.locks:
            raise InputError("None of the selected block edges is locked; select locked ones.")
        return replace(before, locks=kept)

    def outcome(self, divided, wanted):
        edges = "edge is" if len(wanted.locks) == 1 else "edges are"
        return f"{len(wanted.locks)} block {edges} locked; {len(divided.quads.quads):,} quads"


class CROSSFIELD_OT_regrid(_DivisionOperator, SettingProperties, WallProperties, bpy.types.Operator):
    """Fill the same blocks with another number of quads or another wall spacing; locks stay"""

    bl_idname = "crossfield.regrid"
    bl_label = "Regrid Blocks"

    def wish(self, context, collection, computed, before, edges):
        fill_in(self, context.scene.crossfield)
        materials = shown_result.materials(context, collection, len(computed.polygon_index))
        by_count = self.size == "COUNT"
        return replace(
            before,
            grading=self.grading(computed, *materials),
            quad_count=self.quad_count if by_count else None,
            edge_length=None if by_count else as_typed(self.edge_length),
        )

    def draw(self, context):
        draw_size(self.layout, self, blocks=False)
        draw_walls(self.layout, self, results.source_for(context.object))

    def outcome(self, divided, wanted):
        return divided.sentence()


class CROSSFIELD_OT_edit_block_edges(ReportingOperator, bpy.types.Operator):
    """The way to the edges that can be locked"""

    bl_idname = "crossfield.edit_block_edges"
    bl_label = "Edit Block Edges"
    bl_description = (
        "Show the block mesh and edit it, to select block edges whose divisions are to be locked."
        " Locked edges are marked as seams, edges that follow them as sharp"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return poll_blocks(cls, context)

    def run(self, context):
        blocks = results.find_object(result_of(context), "blocks")
        if blocks.name not in context.view_layer.objects:
            raise InputError(
                f"{blocks.name!r} is not in this view layer; enable its collection there."
            )
        if context.object.mode != "OBJECT":
            bpy.ops.object.mode_set(mode="OBJECT")
        for other in context.selected_objects:
            other.select_set(False)
        blocks.hide_viewport = False
        blocks.hide_set(False)
        blocks.select_set(True)
        context.view_layer.objects.active = blocks
        bpy.ops.object.mode_set(mode="EDIT")
        context.tool_settings.mesh_select_mode = False, True, False
        return {"FINISHED"}
