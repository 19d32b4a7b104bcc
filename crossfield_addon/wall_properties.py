"""Wall spacing as Blender properties: the first cell at walls, its growth, and which walls."""

from __future__ import annotations

import bpy

from ..core.divisions.wall_spacing import Grading
from ..core.errors import SettingsError
from .solver_files import wall_loops
from .typed_numbers import as_typed

_OPTIONS = {"SKIP_SAVE"}


class WallProperties:
    """The properties of `core.divisions.wall_spacing.Grading` that a user can change, and the way back."""

    use_walls: bpy.props.BoolProperty(
        name="Wall Spacing",
        description=(
            "Grade the quads towards walls, with thin cells there that grow until they are as long"
            " as the others"
        ),
        default=False,
        options=_OPTIONS,
    )
    first_height: bpy.props.FloatProperty(
        name="First Height",
        description="Distance of the first vertices from the wall, in the object's own space",
        default=0.01,
        min=0.0,
        precision=5,
        unit="LENGTH",
        options=_OPTIONS,
    )
    growth: bpy.props.FloatProperty(
        name="Growth",
        description="Length of each cell over that of the one before it, nearer to the wall",
        default=Grading.growth,
        min=1.001,
        max=10.0,
        soft_max=2.0,
        precision=3,
        options=_OPTIONS,
    )
    walls: bpy.props.EnumProperty(
        name="Walls",
        description="Which parts of the boundary are walls",
        items=(
            ("ALL", "Whole Boundary", "All boundary loops"),
            ("LOOPS", "Loops by Number", "The boundary loops with the numbers given"),
            ("MATERIAL", "Material", "Boundary loops with faces of one material along most of them"),
        ),
        default="ALL",
        options=_OPTIONS,
    )
    wall_loops: bpy.props.StringProperty(
        name="Loops",
        description="Numbers of the boundary loops that are walls, with spaces between, from 0",
        default="0",
        options=_OPTIONS,
    )
    wall_material: bpy.props.StringProperty(
        name="Material",
        description="Name of the material of the faces along the walls",
        options=_OPTIONS,
    )

    def grading(self, decomposition, names=(), material=None) -> Grading | None:
        """The grading that is asked for, None without.

        names, material  as in `solver_files.boundary_patches`

        Raises SettingsError for values out of range and walls that are not there.
        """
        if not self.use_walls:
            return None
        loops = None
        if self.walls == "LOOPS":
            loops = self._numbers()
        elif self.walls == "MATERIAL":
            loops = wall_loops(decomposition, self.wall_material, names, material)
        return Grading(as_typed(self.first_height), as_typed(self.growth), loops)

    def _numbers(self):
        words = self.wall_loops.replace(",", " ").split()
        if not words or not all(word.isdecimal() for word in words):
            raise SettingsError(
                f"{self.wall_loops!r} names no boundary loops; give numbers such as 0 2."
            )
        return tuple(int(word) for word in words)


def draw_walls(layout, settings, source=None) -> None:
    """The controls for wall spacing."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(settings, "use_walls")
    column = layout.column()
    column.active = settings.use_walls
    column.prop(settings, "first_height")
    column.prop(settings, "growth")
    column.prop(settings, "walls")
    if settings.walls == "LOOPS":
        column.prop(settings, "wall_loops")
    elif settings.walls == "MATERIAL":
        if source is not None and source.type == "MESH":
            column.prop_search(settings, "wall_material", source.data, "materials")
        else:
            column.prop(settings, "wall_material")
