#!/usr/bin/env python3
"""Makes the pictures of the docs from real runs on the examples.

python3 docs/make_pictures.py        needs NumPy and Blender's Python module
"""

from __future__ import annotations

import importlib
import struct
import sys
import tempfile
import zlib
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
STEPS = {
    "distance": ("surface", "distance"),
    "field": ("surface", "field", "singularities"),
    "cells": ("surface", "lines", "singularities"),
    "blocks": ("quads", "blocks", "singularities"),
}
COUNTS = {"plate": 2500, "aerofoil": 5000, "octant": 600}
SHOWN = {"octant": ("field", "blocks")}
# The plate and the aerofoil again, as traced, by default and with the fewest blocks.
COARSENESS = ("direct", "balanced", "fewest")
COMPARED = ("plate", "aerofoil")


def load(name):
    """A module of this checkout, under the package name that the launcher gives it."""
    sys.path.insert(0, str(ROOT))
    launcher = importlib.import_module("crossfield")
    launcher.load_command_line()
    return importlib.import_module(f"{launcher.PACKAGE}.{name}")


def pixels_of(path):
    """(height, width, 4) float32, the lowest row first."""
    image = bpy.data.images.load(str(path))
    values = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(values)
    shape = (image.size[1], image.size[0], 4)
    bpy.data.images.remove(image)
    return values.reshape(shape)


def save(path, pixels):
    """Write pixels (height, width, 4), the lowest row first, as a small PNG without transparency."""
    rows = np.round(255 * pixels[::-1, :, :3]).astype(np.uint8)
    above = np.concatenate([np.zeros_like(rows[:1]), rows[:-1]])
    height, width, _ = rows.shape
    filtered = np.full(
        (height, 1 + 3 * width), 2, np.uint8
    )  # filter 2: difference to the row above
    filtered[:, 1:] = (rows - above).reshape(height, -1)

    def chunk(kind, data):
        check = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + check

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = chunk(b"IHDR", header), chunk(b"IDAT", zlib.compress(filtered.tobytes(), 9))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(parts) + chunk(b"IEND", b""))


def tiled(panels, columns=2, gap=20):
    """Panels of one size on their own background, row by row, the first one above on the left."""
    height, width, _ = panels[0].shape
    rows = -(-len(panels) // columns)
    shape = rows * (height + gap) - gap, columns * (width + gap) - gap, 4
    sheet = np.empty(shape, np.float32)
    sheet[:] = panels[0][0, 0]
    for number, panel in enumerate(panels):
        low = (rows - 1 - number // columns) * (height + gap)
        left = (number % columns) * (width + gap)
        sheet[low : low + height, left : left + width] = panel
    return sheet


def decomposed(name, **chosen):
    """The Decomposition of an example."""
    pipeline, settings = load("core.pipeline"), load("core.settings")
    points, polygons = load("core.files.mesh_files").read_mesh(ROOT / "examples" / f"{name}.obj")
    result = pipeline.decompose(points, polygons, settings.Settings(**chosen))
    print(f"{name} {chosen}: {result.sentence()}")
    return result


def panels_of(result, steps, pixels=760):
    """One rendered panel for each step."""
    picture = load("crossfield_addon.picture")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "panel.png"
        panels = []
        for step in steps:
            picture.render_picture(path, result, STEPS[step], pixels=pixels, weight=1.6)
            panels.append(pixels_of(path))
    return panels


def joined_panels(name):
    """Conforming blocks and those with T-junctions, as traced and by default."""
    panels = []
    for coarseness in ("direct", "balanced"):
        for joined in (False, True):
            result = decomposed(
                name, quad_count=COUNTS[name], coarseness=coarseness, t_junctions=joined
            )
            panels += panels_of(result, ["blocks"], pixels=440)
    return panels


def main():
    """Write the pictures of each example: the steps, the choices of coarseness, T-junctions."""
    PICTURES.mkdir(exist_ok=True)
    for name, count in COUNTS.items():
        result = decomposed(name, quad_count=count)
        save(PICTURES / f"{name}.png", tiled(panels_of(result, SHOWN.get(name, STEPS))))
    for name in COMPARED:
        panels = []
        for coarseness in COARSENESS:
            result = decomposed(name, quad_count=COUNTS[name], coarseness=coarseness)
            panels += panels_of(result, ["blocks"], pixels=620)
        save(PICTURES / f"{name}-coarseness.png", tiled(panels, columns=3))
    save(PICTURES / "plate-t-junctions.png", tiled(joined_panels("plate")))


if __name__ == "__main__":
    main()
