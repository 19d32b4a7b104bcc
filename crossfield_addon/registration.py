"""What the add-on adds to Blender, and how it is taken away again."""

from __future__ import annotations

import bpy

from . import command_line, operators, panel, properties

_CLASSES = (
    properties.CrossfieldSettings,
    operators.CROSSFIELD_OT_decompose,
    operators.CROSSFIELD_OT_cross_field,
    operators.CROSSFIELD_OT_trace,
    operators.CROSSFIELD_OT_clear,
    panel.CROSSFIELD_PT_main,
    panel.CROSSFIELD_PT_details,
)
_commands = []


def register():
    """Register the classes, ``Scene.crossfield`` and ``blender -c crossfield``."""
    for cls in _CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.crossfield = bpy.props.PointerProperty(type=properties.CrossfieldSettings)
    if hasattr(bpy.utils, "register_cli_command"):
        _commands.append(bpy.utils.register_cli_command("crossfield", command_line.main))


def unregister():
    """The reverse of `register`; settings stored in the open file stay in the file."""
    while _commands:
        bpy.utils.unregister_cli_command(_commands.pop())
    del bpy.types.Scene.crossfield
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
