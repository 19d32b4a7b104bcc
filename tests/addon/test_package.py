"""The extension as a package: valid, complete, pure Python, and Blender takes it in and out."""

import subprocess
import sys
import zipfile

from tests.addon.blender_process import EXTENSION, ROOT, in_blender, needs_blender, packager


@needs_blender
def test_manifest_is_valid():
    command = [sys.executable, packager(), "validate", ROOT]
    outcome = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr


@needs_blender
def test_package_holds_the_program_and_nothing_else(built_extension):
    names = zipfile.ZipFile(built_extension).namelist()
    folders = {name.split("/")[0] for name in names if "/" in name}
    assert folders == {"core", "crossfield_addon"}
    assert {"__init__.py", "blender_manifest.toml", "LICENSE"} <= set(names)
    assert {n for n in names if n.startswith(("core/", "crossfield_addon/"))} >= {
        "core/pipeline.py",
        "crossfield_addon/operators.py",
    }
    assert all(n.endswith((".py", "/")) for n in names if "/" in n)


@in_blender
def test_disabling_takes_everything_away_and_enabling_brings_it_back():
    import bpy

    assert "decompose" in dir(bpy.ops.crossfield)
    bpy.ops.preferences.addon_disable(module=EXTENSION)
    assert "decompose" not in dir(bpy.ops.crossfield)
    assert not hasattr(bpy.types.Scene, "crossfield")
    assert not hasattr(bpy.types, "CROSSFIELD_PT_main")
    bpy.ops.preferences.addon_enable(module=EXTENSION)
    assert "decompose" in dir(bpy.ops.crossfield)
    assert bpy.context.scene.crossfield.quad_count == 2000


@in_blender
def test_the_core_needs_no_scene():
    import importlib

    import numpy as np

    pipeline = importlib.import_module(f"{EXTENSION}.core.pipeline")
    settings = importlib.import_module(f"{EXTENSION}.core.settings")
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    x, y = np.meshgrid(np.linspace(0, 1, 9), np.linspace(0, 1, 9))
    points = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
    number = np.arange(81).reshape(9, 9)
    corners = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    quads = np.stack(corners, axis=-1).reshape(-1, 4)
    result = pipeline.decompose(points, quads, settings.Settings(quad_count=100))
    assert result.blocks.count == 1
    assert result.quads.quads.shape[1] == 4
