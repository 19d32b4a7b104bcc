"""Crossfield, a Blender extension; the add-on is imported when Blender registers it."""


def register():
    """Called by Blender when the extension is enabled."""
    from . import crossfield_addon

    crossfield_addon.register()


def unregister():
    """Called by Blender when the extension is disabled."""
    from . import crossfield_addon

    crossfield_addon.unregister()
