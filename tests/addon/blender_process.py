"""Runs a test inside Blender, in a process of its own, with the extension as users install it.

Decorate a test that takes no arguments with `in_blender`. pytest then runs a stand-in that starts
this file in a new process, which enables the installed extension and calls the test there; a
failure shows that process's traceback.
"""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
EXTENSION = "bl_ext.user_default.crossfield"
_INSIDE = "CROSSFIELD_TEST_INSIDE_BLENDER"

needs_blender = pytest.mark.skipif(
    importlib.util.find_spec("bpy") is None, reason="Blender's Python module is not installed"
)


def packager() -> Path:
    """The extension packager that ships with Blender's Python module."""
    blender = Path(importlib.util.find_spec("bpy").origin).parent
    found = [*blender.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")]
    found += [*blender.parents[2].glob("scripts/addons_core/bl_pkg/cli/blender_ext.py")]
    return found[0]


def run_blender(*arguments, user_folder: Path) -> subprocess.CompletedProcess:
    """Run Python with these arguments, Blender keeping all its user files in one folder."""
    environment = os.environ | {
        "BLENDER_USER_RESOURCES": str(user_folder),
        "PYTHONDONTWRITEBYTECODE": "1",
        _INSIDE: "1",
    }
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        env=environment,
        cwd=user_folder,
        capture_output=True,
        text=True,
        timeout=300,
    )


def in_blender(test):
    """Turn a test into one that runs in a Blender process of its own."""
    if _INSIDE in os.environ:
        return test

    def stand_in(installed_extension):
        outcome = run_blender(
            __file__, test.__code__.co_filename, test.__name__, user_folder=installed_extension
        )
        assert outcome.returncode == 0, outcome.stdout + outcome.stderr

    stand_in.__name__, stand_in.__doc__ = test.__name__, test.__doc__
    stand_in.__module__ = test.__module__
    return needs_blender(stand_in)


def _run_inside(path, name):
    import bpy

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.preferences.addon_enable(module=EXTENSION)
    sys.path.insert(0, str(ROOT))
    spec = importlib.util.spec_from_file_location("tests_inside", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    getattr(module, name)()


if __name__ == "__main__":
    _run_inside(*sys.argv[1:])
