"""What the add-on adds to Blender, and how it is taken away again."""

from __future__ import annotations

import bpy

from . import (
    command_line,
    operator_divisions,
    operator_export,
    operator_quality,
    operators,
    overlay,
    panel,
    properties,
)

_CLASSES = (
    properties.CrossfieldSettings,
    operators.CROSSFIELD_OT_decompose,
    operators.CROSSFIELD_OT_cross_field,
    operators.CROSSFIELD_OT_trace,
    operators.CROSSFIELD_OT_clear,
    operator_divisions.CROSSFIELD_OT_lock_divisions,
    operator_divisions.CROSSFIELD_OT_unlock_divisions,
    operator_divisions.CROSSFIELD_OT_regrid,
    operator_divisions.CROSSFIELD_OT_edit_block_edges,
    operator_quality.CROSSFIELD_OT_show_quality,
    operator_quality.CROSSFIELD_OT_quality_table,
    *operator_export.EXPORTS,
    panel.CROSSFIELD_PT_main,
    panel.CROSSFIELD_PT_details,
    panel.CROSSFIELD_PT_divisions,
    panel.CROSSFIELD_PT_quality,
    panel.CROSSFIELD_PT_export,
)
_commands = []
_handlers = []


def register():
    """Register the classes, ``Scene.crossfield`` and ``blender -c crossfield``."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.crossfield = bpy.props.PointerProperty(type=properties.CrossfieldSettings)
    bpy.types.TOPBAR_MT_file_export.append(operator_export.draw_menu)
    bpy.types.VIEW3D_MT_edit_mesh_context_menu.append(operator_divisions.draw_edge_menu)
    _handlers.append(overlay.add_handler())
    if hasattr(bpy.utils, "register_cli_command"):
        _commands.append(bpy.utils.register_cli_command("crossfield", command_line.main))


def unregister():
    """The reverse of `register`; settings stored in the open file stay in the file."""
    while _commands:
        bpy.utils.unregister_cli_command(_commands.pop())
    while _handlers:
        overlay.remove_handler(_handlers.pop())
    bpy.types.VIEW3D_MT_edit_mesh_context_menu.remove(operator_divisions.draw_edge_menu)
    bpy.types.TOPBAR_MT_file_export.remove(operator_export.draw_menu)
    del bpy.types.Scene.crossfield
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
