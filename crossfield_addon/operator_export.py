"""Operators that write the active result into files for solvers and other programs."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper

from ..core.files.mesh_files import quads_obj
from . import shown_result, solver_files
from .output_files import OutputFiles, check_targets
from .reporting import (
    ReportingOperator,
    poll_blocks,
    result_name,
    result_of,
    results_in_object_mode,
)
from .typed_numbers import as_typed

# The forms of `plot3d.FORMS`.
_FORMS = (
    ("ascii", "Text", "Numbers as text"),
    ("binary", "Binary", "4-byte integers and 8-byte reals, little-endian"),
    ("unformatted", "Fortran Records", "The same in unformatted Fortran records"),
)


class _ExportOperator(ReportingOperator, ExportHelper):
    """Writes files that appear together or not at all.

    A subclass gives `contents(decomposition, patches, target)`: path -> bytes, or for a folder a
    dict of name -> bytes.
    """

    bl_options = {"REGISTER", "PRESET"}

    in_world: bpy.props.BoolProperty(
        name="Apply Transform",
        description=(
            "Write the points where they are in the world; otherwise in the object's own space,"
            " without its place, rotation and scale"
        ),
        default=True,
    )

    @classmethod
    def poll(cls, context):
        return poll_blocks(cls, context)

    def invoke(self, context, event):
        if not self.filepath:
            folder = Path(bpy.data.filepath).parent
            self.filepath = str(folder / self.file_name(result_name(context)))
        return super().invoke(context, event)

    def file_name(self, name):
        """The file to offer for the result of an object of this name."""
        return bpy.path.clean_name(name) + self.filename_ext

    def run(self, context):
        collection = result_of(context)
        with results_in_object_mode(collection.objects):
            decomposition = shown_result.shown_decomposition(context, collection, self.in_world)
        materials = shown_result.materials(context, collection, len(decomposition.polygon_index))
        patches = solver_files.boundary_patches(decomposition, *materials)
        files = self.contents(decomposition, patches, Path(bpy.path.abspath(self.filepath)))
        check_targets(list(files), Path(bpy.data.filepath or "untitled.blend"))
        with OutputFiles() as output:
            for target, content in files.items():
                _write(output.temporary(target), content)
        names = ", ".join(target.name for target in files)
        self.report({"INFO"}, f"{decomposition.layout.count:,} blocks written: {names}")
        return {"FINISHED"}


def _write(path, content):
    if isinstance(content, bytes):
        path.write_bytes(content)
        return
    path.mkdir()
    for name, part in content.items():
        (path / name).write_bytes(part)


class _Extruded:
    """The choice of a second sheet of vertices, some way along the normals."""

    extrude: bpy.props.BoolProperty(
        name="Extrude",
        description="Give the grid a depth of one cell along its normals; otherwise it is a surface",
        default=False,
    )
    thickness: bpy.props.FloatProperty(
        name="Thickness",
        description="Depth of the extruded grid, in the lengths of the file; 0: as deep as quads are wide",
        default=0.0,
        min=0.0,
        precision=4,
        unit="LENGTH",
    )

    def height(self, decomposition):
        if not self.extrude:
            return None
        return as_typed(self.thickness) or solver_files.quad_width(decomposition)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(self, "in_world")
        layout.prop(self, "extrude")
        column = layout.column()
        column.active = self.extrude
        column.prop(self, "thickness")


class CROSSFIELD_OT_export_plot3d(_Extruded, _ExportOperator, bpy.types.Operator):
    """Write the blocks as a PLOT3D grid, and how they join as a neutral map file beside it"""

    bl_idname = "crossfield.export_plot3d"
    bl_label = "Export PLOT3D"
    filename_ext = ".xyz"

    filter_glob: bpy.props.StringProperty(default="*.xyz", options={"HIDDEN"})
    form: bpy.props.EnumProperty(
        name="Form",
        description="How numbers are written",
        items=_FORMS,
        default="ascii",
    )

    def contents(self, decomposition, patches, target):
        height = self.height(decomposition)
        return {
            target: solver_files.plot3d(decomposition, self.form, height),
            target.with_suffix(".nmf"): solver_files.plot3d_map(decomposition, patches, height),
        }

    def draw(self, context):
        super().draw(context)
        self.layout.prop(self, "form")


class CROSSFIELD_OT_export_open_foam(_ExportOperator, bpy.types.Operator):
    """OpenFOAM's description of blocks"""

    bl_idname = "crossfield.export_open_foam"
    bl_label = "Export blockMeshDict"
    bl_description = (
        "Write the blocks as OpenFOAM's blockMeshDict, one cell deep, with the boundary as patches:"
        " by material where it has two or more, else by boundary loop"
    )
    filename_ext = ""
    check_extension = None

    thickness: bpy.props.FloatProperty(
        name="Thickness",
        description="Depth of the cells, in the lengths of the file; 0: as deep as quads are wide",
        default=0.0,
        min=0.0,
        precision=4,
        unit="LENGTH",
    )

    def file_name(self, name):
        return "blockMeshDict"

    def contents(self, decomposition, patches, target):
        height = as_typed(self.thickness) or None
        return {target: solver_files.open_foam(decomposition, patches, height)}


class CROSSFIELD_OT_export_vtk(_Extruded, _ExportOperator, bpy.types.Operator):
    """Write the blocks with their quality as VTK multi-block data: a file, and a folder beside it"""

    bl_idname = "crossfield.export_vtk"
    bl_label = "Export VTK Blocks"
    filename_ext = ".vtm"

    filter_glob: bpy.props.StringProperty(default="*.vtm", options={"HIDDEN"})

    def contents(self, decomposition, patches, target):
        folder = target.with_name(f"{target.stem}_vtm")
        height = self.height(decomposition)
        file, parts = solver_files.vtk(decomposition, patches, folder.name, height)
        return {target: file, folder: parts}


class CROSSFIELD_OT_export_obj(_ExportOperator, bpy.types.Operator):
    """Write the quads as OBJ with a group for each block, or one quad for each block"""

    bl_idname = "crossfield.export_obj"
    bl_label = "Export Blocks as OBJ"
    filename_ext = ".obj"

    filter_glob: bpy.props.StringProperty(default="*.obj", options={"HIDDEN"})
    mesh: bpy.props.EnumProperty(
        name="Mesh",
        description="Which mesh is written",
        items=(
            ("QUADS", "Quads", "All quads, a group for each block"),
            ("BLOCKS", "Block Mesh", "One quad for each block, and the curves between them"),
        ),
        default="QUADS",
    )

    def contents(self, decomposition, patches, target):
        if self.mesh == "BLOCKS":
            return {target: solver_files.coarse_mesh(decomposition)}
        quads = decomposition.quads
        block = decomposition.layout.quad_block
        return {target: quads_obj(quads.points, quads.quads, block)}


EXPORTS = (
    CROSSFIELD_OT_export_plot3d,
    CROSSFIELD_OT_export_open_foam,
    CROSSFIELD_OT_export_vtk,
    CROSSFIELD_OT_export_obj,
)


def draw_menu(menu, context):
    """The entries in the menu File > Export."""
    menu.layout.separator()
    for operator in EXPORTS:
        label = operator.bl_label.removeprefix("Export ")
        suffix = f" ({operator.filename_ext})" if operator.filename_ext else ""
        menu.layout.operator(operator.bl_idname, text=f"Crossfield {label}{suffix}")
