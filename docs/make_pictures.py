#!/usr/bin/env python3
"""Makes the pictures of the docs from real runs on the examples.

python3 docs/make_pictures.py        needs NumPy and Blender's Python module
"""

from __future__ import annotations

import importlib
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "pictures"
STEPS = {
    "distance": ("distance",),
    "field": ("surface", "field", "singularities"),
    "cells": ("surface", "lines", "singularities"),
    "blocks": ("quads", "blocks", "singularities"),
}
WINDOWS = {"plate": None, "aerofoil": ((-0.62, -0.62), (1.5, 0.52)), "octant": None}
COUNTS = {"plate": 3000, "aerofoil": 5000, "octant": 600}


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
    """Write pixels (height, width, 4) as a PNG."""
    image = bpy.data.images.new("picture", pixels.shape[1], pixels.shape[0])
    image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    bpy.data.images.remove(image)


def side_by_side(panels, gap=24):
    """Panels of one height in a row, on white."""
    blank = np.ones((panels[0].shape[0], gap, 4), np.float32)
    row = [part for panel in panels for part in (panel, blank)]
    return np.concatenate(row[:-1], axis=1)


def main():
    """Decompose each example once and write its pictures."""
    picture = load("crossfield_addon.picture")
    pipeline, settings = load("core.pipeline"), load("core.settings")
    mesh_files = load("core.mesh_files")
    PICTURES.mkdir(exist_ok=True)
    for name, window in WINDOWS.items():
        points, polygons = mesh_files.read_mesh(ROOT / "examples" / f"{name}.obj")
        wanted = settings.Settings(quad_count=COUNTS[name])
        decomposition = pipeline.decompose(points, polygons, wanted)
        print(f"{name}: {decomposition.sentence()}")
        panels = {}
        with tempfile.TemporaryDirectory() as folder:
            for step, layers in STEPS.items():
                path = Path(folder) / f"{step}.png"
                picture.render_picture(path, decomposition, layers, pixels=1100, window=window)
                panels[step] = pixels_of(path)
        if name == "octant":
            save(PICTURES / "octant.png", side_by_side([panels["field"], panels["blocks"]]))
            continue
        for step, pixels in panels.items():
            save(PICTURES / f"{name}-{step}.png", pixels)
        shown = [panels[step] for step in ("field", "cells", "blocks")]
        save(PICTURES / f"{name}.png", side_by_side(shown))


if __name__ == "__main__":
    main()
