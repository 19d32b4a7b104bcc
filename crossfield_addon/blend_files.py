"""Reading a mesh from a .blend file and writing results into one, without a window."""

from __future__ import annotations

import os
import sys
from contextlib import contextmanager
from pathlib import Path

import bpy
import numpy as np

from ..core.errors import InputError
from . import mesh_arrays, results


@contextmanager
def quiet():
    """Keep Blender's own messages off the terminal while it reads, writes or renders."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = os.dup(1), os.dup(2)
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    try:
        yield
    finally:
        os.dup2(kept[0], 1)
        os.dup2(kept[1], 2)
        for descriptor in (silent, *kept):
            os.close(descriptor)


def open_object(path: Path, name: str | None, marks=()):
    """Open a .blend file and return (object, MeshArrays) of the named mesh.

    Without a name: the active object, or else the only mesh of the file. marks are identifiers of
    `marked_edges.MARKS` whose edges are wanted. Raises InputError.
    """
    with open(path, "rb") as file:
        start = file.read(12)
    if not start.startswith((b"BLENDER", b"\x28\xb5\x2f\xfd", b"\x1f\x8b")):
        raise InputError(f"{path} is not a Blender file; check its name and its content.")
    try:
        with quiet():
            bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        cause = " ".join(str(error).split()).removeprefix("Error: ").rstrip(".")
        raise InputError(f"{path} cannot be opened ({cause}); save it again in Blender.") from None
    source = _choose(path, name)
    return source, mesh_arrays.read_object(bpy.context, source, marks)


def _choose(path, name):
    meshes = [o for o in bpy.context.view_layer.objects if o.type == "MESH"]
    names = ", ".join(repr(o.name) for o in meshes[:8]) + (", ..." if len(meshes) > 8 else "")
    if not meshes:
        raise InputError(f"{path} holds no mesh object; add one or name another file.")
    if name is not None:
        for source in meshes:
            if source.name == name:
                return source
        raise InputError(f"{path} has no mesh object {name!r}; it has {names}.")
    if bpy.context.view_layer.objects.active in meshes:
        return bpy.context.view_layer.objects.active
    if len(meshes) > 1:
        raise InputError(f"{path} holds several meshes; name one with --object: {names}.")
    return meshes[0]


def new_file_with(name: str, points, polygons):
    """Start an empty file with one mesh object and return (object, MeshArrays)."""
    with quiet():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(points).tolist(), [], [list(map(int, p)) for p in polygons])
    source = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(source)
    bpy.context.view_layer.objects.active = source
    bpy.context.view_layer.update()
    return source, mesh_arrays.read_object(bpy.context, source)


def object_materials(source):
    """Names of the materials of an object, and the material of each of its polygons as evaluated."""
    return mesh_arrays.evaluated_materials(bpy.context, source)


def save_results(path: Path, source, arrays, decomposition, keep_lines, computed, wanted) -> None:
    """Write the results into the open file and save a copy of it; as `results.write_results`."""
    results.write_results(
        bpy.context.scene, source, arrays, decomposition, keep_lines, computed=computed,
        wanted=wanted,
    )
    with quiet():
        bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True, compress=True)
