"""Meshes from .obj, .ply and .stl files, and quad meshes to .obj."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ..errors import InputError
from .obj_file import parse_obj
from .ply_file import parse_ply
from .stl_file import parse_stl

_PARSERS = {".obj": parse_obj, ".ply": parse_ply, ".stl": parse_stl}


def read_mesh(path):
    """Points (V, 3) float64 and polygons of a mesh file, its format told by its suffix.

    Polygons are an (N, 3) or (N, 4) int64 array where all are alike, else a list of index lists.
    Raises InputError with one sentence if there is no such file, if it is not what its name says,
    is damaged or truncated, or has no faces.
    """
    path = Path(path)
    parse = _PARSERS.get(path.suffix.lower())
    if parse is None:
        raise InputError(f"{path} is not a mesh that can be read; give an .obj, .ply or .stl file.")
    data = _contents(path)
    try:
        points, polygons = parse(data)
        if polygons.count == 0:
            raise InputError("has no faces; export the mesh with its faces")
        _refuse_outside(len(points), polygons)
    except InputError as error:
        raise InputError(f"{path} {error}.") from None
    return points, polygons.as_lists()


def _contents(path):
    if path.is_dir():
        raise InputError(f"{path} is a directory; name a mesh file.")
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path} does not exist; check the name.") from None
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror}); check the file.") from None
    if not data:
        raise InputError(f"{path} is empty; export the mesh again.")
    return data


def _refuse_outside(count, polygons):
    outside = (polygons.corner < 0) | (polygons.corner >= count)
    if outside.any():
        polygon = polygons.corner_polygon[np.argmax(outside)]
        raise InputError(
            f"has {count:,} vertices, but face {polygon + 1} of {polygons.count:,} refers to one"
            " beyond them, so it is damaged or truncated"
        )


def write_quads_obj(path, points, quads, block=None):
    """Write a quad mesh as OBJ, each block a group `g block_0007`; the file appears whole or not.

    points  (P, 3) float64, written so that reading gives the same numbers
    quads   (Q, 4) int, vertex numbers from 0
    block   (Q,) int, block of each quad, from 0; None writes no groups

    Raises InputError when the file cannot be written; an older file of that name then stays.
    """
    path = Path(os.path.realpath(path))
    content = quads_obj(points, quads, block)
    unfinished = path.with_name(f".{path.name}-{os.getpid()}.unfinished")
    try:
        try:
            unfinished.write_bytes(content)
            os.replace(unfinished, path)
        finally:
            unfinished.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(
            f"{path} cannot be written ({error.strerror}); choose another place for it."
        ) from None


def quads_obj(points, quads, block=None) -> bytes:
    """The content of the file that `write_quads_obj` writes."""
    points, quads = np.asarray(points, np.float64), np.asarray(quads)
    lines = ["# Multi-block quad mesh by Crossfield"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    faces = [f"f {a} {b} {c} {d}" for a, b, c, d in (quads + 1).tolist()]
    if block is None:
        lines += faces
    else:
        block = np.asarray(block)
        order = np.argsort(block, kind="stable")
        start = np.flatnonzero(np.diff(block[order], prepend=-1))
        for rows in np.split(order, start[1:]) if len(start) else []:
            lines.append(f"g block_{block[rows[0]]:04d}")
            lines += [faces[row] for row in rows.tolist()]
    return ("\n".join(lines) + "\n").encode("ascii")
