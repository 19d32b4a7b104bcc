"""The extension, built and installed once for all tests of the add-on."""

import subprocess
import sys

import pytest

from tests.addon.blender_process import ROOT, packager, run_blender

_INSTALL = """
import bpy, sys
bpy.ops.extensions.package_install_files(
    filepath=sys.argv[1], repo="user_default", enable_on_install=True
)
"""


@pytest.fixture(scope="session")
def built_extension(tmp_path_factory):
    """Path of the zip, made by Blender's own packager."""
    folder = tmp_path_factory.mktemp("built")
    build = [sys.executable, packager(), "build", "--source-dir", ROOT, "--output-dir", folder]
    outcome = subprocess.run(build, capture_output=True, text=True, timeout=120)
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    (package,) = folder.glob("*.zip")
    return package


@pytest.fixture(scope="session")
def installed_extension(built_extension, tmp_path_factory):
    """A folder for Blender's user files with the extension installed in it."""
    folder = tmp_path_factory.mktemp("blender")
    outcome = run_blender("-c", _INSTALL, built_extension, user_folder=folder)
    assert outcome.returncode == 0, outcome.stdout + outcome.stderr
    return folder
