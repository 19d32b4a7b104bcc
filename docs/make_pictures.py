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


def tiled(panels, gap=20):
    """Panels of one size on their own background, two in a row, the first one above on the left."""
    height, width, _ = panels[0].shape
    rows = (len(panels) + 1) // 2
    sheet = np.empty((rows * (height + gap) - gap, 2 * width + gap, 4), np.float32)
    sheet[:] = panels[0][0, 0]
    for number, panel in enumerate(panels):
        low = (rows - 1 - number // 2) * (height + gap)
        left = (number % 2) * (width + gap)
        sheet[low : low + height, left : left + width] = panel
    return sheet


def main():
    """Decompose each example once and write its picture: field, singularities, cells, blocks."""
    picture = load("crossfield_addon.picture")
    pipeline, settings = load("core.pipeline"), load("core.settings")
    mesh_files = load("core.mesh_files")
    PICTURES.mkdir(exist_ok=True)
    for name, count in COUNTS.items():
        points, polygons = mesh_files.read_mesh(ROOT / "examples" / f"{name}.obj")
        result = pipeline.decompose(points, polygons, settings.Settings(quad_count=count))
        print(f"{name}: {result.sentence()}")
        panels = []
        with tempfile.TemporaryDirectory() as folder:
            for step in SHOWN.get(name, STEPS):
                path = Path(folder) / f"{step}.png"
                picture.render_picture(path, result, STEPS[step], pixels=760, weight=1.6)
                panels.append(pixels_of(path))
        save(PICTURES / f"{name}.png", tiled(panels))


if __name__ == "__main__":
    main()
