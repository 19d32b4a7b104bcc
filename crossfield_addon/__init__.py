"""Everything of Crossfield that knows Blender; computing is left to `core`.

Importing this package does not import bpy, so that the command line can use it without Blender.
"""


def register():
    """Add the operators, the settings on the scene, the panel and the command line."""
    from . import registration

    registration.register()


def unregister():
    """Take everything that `register` added away again."""
    from . import registration

    registration.unregister()
