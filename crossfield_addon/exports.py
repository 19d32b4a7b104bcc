"""Flags and files of the headless command for what comes after the block layout."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from ..core.blocks.block_quality import block_quality, quality_rows, quality_text
from ..core.divisions.wall_spacing import Grading
from ..core.errors import SettingsError
from ..core.files.obj_materials import parse_materials
from . import solver_files
from .wanted_divisions import WantedDivisions

SUFFIXES = {"plot3d": ".xyz", "blockmesh": "", "vtk": ".vtm", "block_mesh": ".obj"}


def add_flags(command) -> None:
    """The flags, in two groups."""
    outputs = command.add_argument_group("outputs for solvers")
    outputs.add_argument("--plot3d", type=Path, metavar="F.xyz", help="PLOT3D grid, and F.nmf")
    form = outputs.add_mutually_exclusive_group()
    form.add_argument("--plot3d-binary", action="store_true", help="binary, without records")
    form.add_argument("--plot3d-unformatted", action="store_true", help="binary, Fortran records")
    outputs.add_argument("--blockmesh", type=Path, metavar="F", help="OpenFOAM's blockMeshDict")
    outputs.add_argument("--vtk", type=Path, metavar="F.vtm", help="VTK blocks, and a folder F_vtm")
    outputs.add_argument("--block-mesh", type=Path, metavar="F.obj", help="one quad for each block")
    outputs.add_argument(
        "--extrude", type=float, metavar="H",
        help="height of grids extruded by one cell; blockMeshDict: one cell as deep as wide",
    )
    outputs.add_argument(
        "--quality-table", action="store_true", help="quality of every block, in the report too"
    )
    divisions = command.add_argument_group("divisions of the blocks")
    divisions.add_argument(
        "--lock", type=_lock, action="append", default=[], metavar="EDGE=N",
        help="divisions of a block edge and all that must follow (repeatable)",
    )
    divisions.add_argument(
        "--first-height", type=float, metavar="H", help="first cell at walls, in lengths"
    )
    divisions.add_argument(
        "--growth", type=float, metavar="R", help=f"growth from cell to cell ({Grading.growth})"
    )
    divisions.add_argument(
        "--wall", type=int, action="append", metavar="LOOP",
        help="boundary loop that is a wall (repeatable; all of them)",
    )
    divisions.add_argument(
        "--wall-material", metavar="NAME", help="boundary loops along faces of it are walls"
    )


def _lock(text):
    edge, _, count = text.partition("=")
    try:
        return int(edge), int(count)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not of the form EDGE=N with two whole numbers"
        ) from None


def wanted_divisions(arguments) -> WantedDivisions:
    """Check the flags for divisions; raises SettingsError before any work is done."""
    if arguments.first_height is None:
        for flag, value in (
            ("--growth", arguments.growth), ("--wall", arguments.wall),
            ("--wall-material", arguments.wall_material),
        ):
            if value is not None:
                raise SettingsError(f"{flag} needs --first-height; give both or none.")
        return WantedDivisions(tuple(arguments.lock))
    if arguments.wall is not None and arguments.wall_material is not None:
        raise SettingsError("--wall and --wall-material both name the walls; give one of them.")
    growth = Grading.growth if arguments.growth is None else arguments.growth
    walls = None if arguments.wall is None else tuple(arguments.wall)
    return WantedDivisions(
        tuple(arguments.lock), Grading(arguments.first_height, growth, walls)
    )


def refuse_without_blocks(arguments, settings) -> None:
    """Raises SettingsError for flags about blocks when the run stops before there are any."""
    if settings.stop_after == "quads":
        if arguments.extrude is not None and arguments.extrude <= 0:
            raise SettingsError(f"The height {arguments.extrude} must be a positive number.")
        if (arguments.plot3d_binary or arguments.plot3d_unformatted) and not arguments.plot3d:
            raise SettingsError("The form of a PLOT3D file was given without --plot3d.")
        for flag in ("blockmesh", "block_mesh"):
            if settings.t_junctions and getattr(arguments, flag):
                raise SettingsError(
                    f"--{flag.replace('_', '-')} needs blocks that conform; leave out --t-junctions."
                )
        return
    for flag in ("plot3d", "blockmesh", "vtk", "block_mesh", "quality_table", "lock", "first_height"):
        if getattr(arguments, flag):
            raise SettingsError(
                f"There are no blocks for --{flag.replace('_', '-')} after --stop-after"
                f" {settings.stop_after}."
            )


def with_material_walls(wanted: WantedDivisions, given, arguments, decomposition):
    """The same with the walls that a material names, if one was given."""
    if arguments.wall_material is None:
        return wanted
    materials = _materials(given, arguments)
    loops = solver_files.wall_loops(decomposition, arguments.wall_material, *materials)
    return replace(wanted, grading=replace(wanted.grading, loops=loops))


def quality_table(decomposition) -> list:
    """Rows of the quality table, one dict for each block."""
    quads, blocks = decomposition.quads, decomposition.layout
    quality = block_quality(quads.points, quads.quads, blocks, quads.scaled_jacobian)
    return quality_rows(blocks, quality)


def print_table(decomposition) -> None:
    print(quality_text(quality_table(decomposition)))


def companions(kind: str, target: Path) -> dict:
    """Further targets that belong to an output: kind -> path."""
    if kind == "plot3d":
        return {"neutral_map": target.with_suffix(".nmf")}
    if kind == "vtk":
        return {"vtk_folder": target.with_name(f"{target.stem}_vtm")}
    return {}


def _patches(given, arguments, decomposition):
    return solver_files.boundary_patches(decomposition, *_materials(given, arguments))


def _materials(given, arguments):
    """Names and (N,) material of each polygon; no names where the input has none."""
    if given.source is not None:
        from .blend_files import object_materials

        return object_materials(given.source)
    if arguments.input.suffix.lower() == ".obj":
        return parse_materials(arguments.input.read_bytes())
    return [], None


def _write_plot3d(path, arguments, given, decomposition):
    form = "binary" if arguments.plot3d_binary else "ascii"
    form = "unformatted" if arguments.plot3d_unformatted else form
    path.write_bytes(solver_files.plot3d(decomposition, form, arguments.extrude))


def _write_neutral_map(path, arguments, given, decomposition):
    patches = _patches(given, arguments, decomposition)
    path.write_bytes(solver_files.plot3d_map(decomposition, patches, arguments.extrude))


def _write_blockmesh(path, arguments, given, decomposition):
    patches = _patches(given, arguments, decomposition)
    path.write_bytes(solver_files.open_foam(decomposition, patches, arguments.extrude))


def _vtk(arguments, given, decomposition):
    folder = companions("vtk", arguments.vtk)["vtk_folder"].name
    patches = _patches(given, arguments, decomposition)
    return solver_files.vtk(decomposition, patches, folder, arguments.extrude)


def _write_vtk(path, arguments, given, decomposition):
    path.write_bytes(_vtk(arguments, given, decomposition)[0])


def _write_vtk_folder(path, arguments, given, decomposition):
    path.mkdir()
    for name, content in _vtk(arguments, given, decomposition)[1].items():
        (path / name).write_bytes(content)


def _write_block_mesh(path, arguments, given, decomposition):
    path.write_bytes(solver_files.coarse_mesh(decomposition))


WRITERS = {
    "plot3d": _write_plot3d,
    "neutral_map": _write_neutral_map,
    "blockmesh": _write_blockmesh,
    "vtk": _write_vtk,
    "vtk_folder": _write_vtk_folder,
    "block_mesh": _write_block_mesh,
}
