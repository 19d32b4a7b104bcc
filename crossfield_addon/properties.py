"""The settings of the core as Blender properties, shared by the panel and the operators."""

from __future__ import annotations

from math import radians

import bpy

from ..core.settings import Settings
from .marked_edges import MARKS, USUAL_MARKS
from .results import ALL_PRODUCTS, PRODUCTS
from .typed_numbers import as_typed
from .wall_properties import WallProperties

_DEFAULTS = Settings()
_OPTIONS = {"SKIP_SAVE"}


class SettingProperties:
    """The properties of `core.settings.Settings` that a user can change, and the way back."""

    size: bpy.props.EnumProperty(
        name="Size",
        description="What the size of the quads is chosen by",
        items=(
            ("COUNT", "Number of Quads", "About this many quads on the whole surface"),
            ("LENGTH", "Edge Length", "Quads with edges of about this length"),
        ),
        default="COUNT",
        options=_OPTIONS,
    )
    quad_count: bpy.props.IntProperty(
        name="Quads",
        description="Wanted number of quads",
        default=_DEFAULTS.quad_count,
        min=1,
        soft_max=100_000,
        options=_OPTIONS,
    )
    edge_length: bpy.props.FloatProperty(
        name="Edge Length",
        description="Wanted length of a quad's edge, in the object's own space",
        default=0.1,
        min=0.0,
        precision=4,
        unit="LENGTH",
        options=_OPTIONS,
    )
    relaxation: bpy.props.EnumProperty(
        name="Relaxation",
        description="How the propagated cross field is relaxed",
        items=(
            ("none", "None", "The field as propagated from the boundary"),
            ("harmonic", "Harmonic", "Smoothest field with the same singularities"),
            ("diffused", "Diffused", "Singularities move to where they cost least"),
        ),
        default=_DEFAULTS.relaxation,
        options=_OPTIONS,
    )
    lines: bpy.props.EnumProperty(
        name="Lines",
        description="Where the lines traced from singularities and corners end",
        items=(
            ("motorcycle", "Motorcycle Graph", "Lines stop where they meet another line"),
            ("full", "Full Streamlines", "Lines cross one another and run on to the boundary"),
        ),
        default=_DEFAULTS.lines,
        options=_OPTIONS,
    )
    coarseness: bpy.props.EnumProperty(
        name="Blocks",
        description="How far blocks are merged",
        items=(
            ("direct", "As Traced", "All blocks that the traced lines ask for"),
            ("balanced", "Balanced", "Few blocks of good shape"),
            ("fewest", "Fewest", "Fewer blocks still; shapes count less"),
        ),
        default=_DEFAULTS.coarseness,
        options=_OPTIONS,
    )
    t_junctions: bpy.props.BoolProperty(
        name="T-Junctions",
        description=(
            "The fewest blocks of all: a corner of one may lie inside a side of another. The quads"
            " are the same"
        ),
        default=_DEFAULTS.t_junctions,
        options=_OPTIONS,
    )
    kink_angle: bpy.props.FloatProperty(
        name="Kink Angle",
        description="Boundary vertices that turn by more stay vertices of the quad mesh",
        default=_DEFAULTS.kink_angle,
        min=radians(1.0),
        max=radians(89.0),
        subtype="ANGLE",
        options=_OPTIONS,
    )
    keep_creases: bpy.props.BoolProperty(
        name="Keep Creases",
        description="Sharp edges inside the surface stay edges of the quad mesh",
        default=_DEFAULTS.feature_angle is not None,
        options=_OPTIONS,
    )
    feature_angle: bpy.props.FloatProperty(
        name="Crease Angle",
        description="Angle between faces from which their edge is a crease",
        default=_DEFAULTS.feature_angle or radians(40.0),
        min=radians(1.0),
        max=radians(179.0),
        subtype="ANGLE",
        options=_OPTIONS,
    )
    feature_follow_angle: bpy.props.FloatProperty(
        name="Follow Down To",
        description="Angle between faces down to which a crease is followed from its ends",
        default=_DEFAULTS.feature_follow_angle,
        min=radians(1.0),
        max=radians(179.0),
        subtype="ANGLE",
        options=_OPTIONS,
    )
    marks: bpy.props.EnumProperty(
        name="Marked Edges",
        description="Edges with these marks stay edges of the quad mesh",
        items=MARKS,
        options=_OPTIONS | {"ENUM_FLAG"},
        default=set(USUAL_MARKS),
    )
    line_distance: bpy.props.FloatProperty(
        name="Longest Line",
        description="Limit on a full streamline, in diameters of the surface",
        default=_DEFAULTS.line_distance,
        min=0.1,
        soft_max=100.0,
        options=_OPTIONS,
    )
    line_turn: bpy.props.FloatProperty(
        name="Largest Turn",
        description="Limit on the total turning of a full streamline",
        default=_DEFAULTS.line_turn,
        min=radians(90.0),
        soft_max=radians(36000.0),
        subtype="ANGLE",
        options=_OPTIONS,
    )
    repair: bpy.props.BoolProperty(
        name="Repair",
        description="Repair a faulty mesh inside, instead of refusing it; the mesh itself stays",
        default=_DEFAULTS.repair,
        options=_OPTIONS,
    )
    weld_distance: bpy.props.FloatProperty(
        name="Weld Distance",
        description="Vertices no farther apart count as one, in the object's own space",
        default=_DEFAULTS.weld_distance,
        min=0.0,
        precision=4,
        unit="LENGTH",
        options=_OPTIONS,
    )
    products: bpy.props.EnumProperty(
        name="Show",
        description="Results to show besides the block mesh",
        items=PRODUCTS,
        options=_OPTIONS | {"ENUM_FLAG"},
        default=set(ALL_PRODUCTS),
    )
    keep_lines: bpy.props.BoolProperty(
        name="Keep Lines",
        description="Also show the traced lines as a curve object of their own",
        default=False,
        options=_OPTIONS,
    )

    def settings(self, stop_after: str) -> Settings:
        """The core's settings; raises SettingsError when they are out of range."""
        return Settings(
            edge_length=as_typed(self.edge_length) if self.size == "LENGTH" else None,
            quad_count=self.quad_count,
            relaxation=self.relaxation,
            lines=self.lines,
            coarseness=self.coarseness,
            t_junctions=self.t_junctions,
            kink_angle=self.kink_angle,
            feature_angle=self.feature_angle if self.keep_creases else None,
            feature_follow_angle=self.feature_follow_angle,
            weld_distance=as_typed(self.weld_distance),
            repair=self.repair,
            line_distance=self.line_distance,
            line_turn=self.line_turn,
            stop_after=stop_after,
        )


class CrossfieldSettings(SettingProperties, WallProperties, bpy.types.PropertyGroup):
    """``Scene.crossfield``: what the panel shows and the operators start from."""
