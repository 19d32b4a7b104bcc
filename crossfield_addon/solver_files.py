"""The contents of files for solvers, from a decomposition: for the command and for the operators.

points, where they are given, are those of the quad mesh in the coordinates of the file.
"""

from __future__ import annotations

import numpy as np

from ..core.blocks.block_quality import block_quality
from ..core.divisions.block_mesh import block_mesh, block_mesh_obj
from ..core.divisions.wall_spacing import edge_loops
from ..core.errors import SettingsError
from ..core.files.block_mesh_dict import block_mesh_dict
from ..core.files.boundary_patches import (
    Patches,
    loop_patches,
    loops_of_material,
    material_patches,
)
from ..core.files.extrusion import extrude, extrusion_height
from ..core.files.plot3d import neutral_map, plot3d_grid
from ..core.files.vtk_blocks import vtk_files
from ..core.surface.projection import plane_normal


def boundary_patches(decomposition, names=(), material=None) -> Patches:
    """The boundary by material, or by loop where there are no names.

    names     list of str
    material  (N,) int64, material of each of the user's polygons, -1 without
    """
    blocks, placement = decomposition.layout, decomposition.placement
    loops = edge_loops(blocks, placement.loop)
    if not names:
        return loop_patches(blocks, loops)
    return material_patches(
        blocks, loops, placement.face, decomposition.face_origin, material, names
    )


def wall_loops(decomposition, name: str, names, material) -> tuple:
    """Numbers of the boundary loops along polygons of the material of this name.

    names, material  as in `boundary_patches`

    Raises SettingsError where there is no such material, or no such loop.
    """
    if name not in names:
        known = ", ".join(repr(other) for other in names) or "none"
        raise SettingsError(f"The mesh has no material {name!r} for the walls; it has {known}.")
    loops = loops_of_material(
        decomposition.whole, decomposition.face_origin, material, list(names).index(name)
    )
    if not loops:
        raise SettingsError(
            f"No boundary loop runs along faces of the material {name!r} for half of its length;"
            " assign the material to the faces along the walls."
        )
    return loops


def quad_width(decomposition) -> float:
    """The mean edge length of the quads: the depth of cells as deep as they are wide."""
    return extrusion_height(decomposition.quads.points, decomposition.quads.quads)


def plot3d(decomposition, form="ascii", height=None) -> bytes:
    """A PLOT3D grid; height None: a surface, else extruded by so much."""
    quads = decomposition.quads
    back = None if height is None else extrude(quads.points, quads.quads, height)
    return plot3d_grid(quads.points, decomposition.layout, form, back)


def plot3d_map(decomposition, patches: Patches, height=None) -> bytes:
    """The neutral map file that goes with `plot3d`."""
    return neutral_map(decomposition.layout, patches, height is not None)


def open_foam(decomposition, patches: Patches, height=None) -> bytes:
    """A blockMeshDict, one cell deep; height None: as deep as quads are wide.

    Raises SettingsError where blocks have T-junctions.
    """
    _refuse_junctions(decomposition)
    quads = decomposition.quads
    back = extrude(quads.points, quads.quads, height)
    planar = plane_normal(decomposition.whole) is not None
    return block_mesh_dict(
        quads.points, back, quads.quads, decomposition.blocks, patches, planar
    )


def vtk(decomposition, patches: Patches, folder: str, height=None):
    """A .vtm, and name -> bytes of the files in the folder of this name beside it."""
    quads, blocks = decomposition.quads, decomposition.layout
    quality = block_quality(quads.points, quads.quads, blocks, quads.scaled_jacobian)
    values = {
        "scaled_jacobian": quality.scaled_jacobian, "skewness": quality.skewness,
        "aspect_ratio": np.nan_to_num(quality.aspect_ratio, posinf=1e300),
    }
    back = None if height is None else extrude(quads.points, quads.quads, height)
    return vtk_files(quads.points, quads.quads, blocks, patches, folder, values, back)


def coarse_mesh(decomposition) -> bytes:
    """The block mesh as OBJ: a quad for each block, and the curves between them.

    Raises SettingsError where blocks have T-junctions.
    """
    _refuse_junctions(decomposition)
    return block_mesh_obj(block_mesh(decomposition.quads.points, decomposition.blocks))


def _refuse_junctions(decomposition):
    if decomposition.t_edges is not None:
        raise SettingsError(
            "This kind of file needs blocks that conform; decompose without T-junctions."
        )
