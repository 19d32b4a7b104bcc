"""Exceptions of the core. Every message is one sentence that names the cause and the cure."""


class CrossfieldError(Exception):
    """Base of everything that the core raises on purpose; its text is meant for the user."""


class InputError(CrossfieldError):
    """The given mesh or file cannot be used as it is."""


class SettingsError(CrossfieldError):
    """A setting is out of range or contradicts another one."""


class LayoutError(CrossfieldError):
    """No valid block layout was found for a surface that is in itself acceptable.

    place  (n, 3) float64, points of the surface where it went wrong; none if that is not known
    """

    def __init__(self, message, place=()):
        super().__init__(message)
        self.place = place


class Cancelled(CrossfieldError):
    """The caller asked to stop; nothing has been changed."""


class CoarseLayoutError(LayoutError):
    """A layout that needs more quads: lengthen the strips that the given mesh edges cross.

    edge  (n, 2) int64, end vertices of mesh edges
    """

    def __init__(self, message, edge):
        super().__init__(message)
        self.edge = edge
