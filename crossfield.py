#!/usr/bin/env python3
"""Crossfield without a window, on a machine that has only Python 3.11 or 3.13.

    python3 crossfield.py example             the main job on a shipped example, into output/
    python3 crossfield.py test [--slow] ...   the tests; further arguments go to pytest
    python3 crossfield.py decompose ...       any mesh; see decompose --help

What a command needs and this Python lacks is installed once into a virtual environment beside this
file. This file is read by old Pythons too, so that they can say what is missing: it keeps to a
syntax that they know.
"""

import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.abspath(__file__))
PACKAGE = "crossfield_checkout"
NEEDED = {"example": ("numpy", "bpy"), "test": ("numpy", "bpy", "pytest", "hypothesis", "scipy")}
EXAMPLE = ["decompose", os.path.join("examples", "plate.obj"), "--quad-count", "5000"]
EXAMPLE_OUTPUTS = {"output": "blend", "quads": "obj", "report": "json", "picture": "png"}


def main(arguments):
    """Run one command and return its exit code."""
    if sys.version_info[:2] not in ((3, 11), (3, 13)):
        return fail(
            2,
            "crossfield.py needs Python 3.11 or 3.13, for which Blender is published as a"
            " module; this is Python {0}.{1}.".format(*sys.version_info[:2]),
        )
    # The matrices are too small for threads, which only cost time waiting for one another.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    command = arguments[0] if arguments else "--help"
    if command in ("--help", "-h", "help"):
        say(__doc__.strip())
        return 0
    modules = NEEDED.get(command) or modules_for(arguments)
    try:
        if any(missing(name) for name in modules):
            return run_in_environment(arguments, modules)
        if command == "test":
            return run_tests(arguments[1:])
        if command == "example":
            return run_example(arguments[1:])
        return run_command(arguments)
    except KeyboardInterrupt:
        return fail(130, "Interrupted.")


def say(sentence):
    """One line on standard output, at once."""
    sys.stdout.write(sentence + "\n")
    sys.stdout.flush()


def fail(code, sentence):
    """One line on standard error; returns the exit code."""
    sys.stderr.write("crossfield: " + sentence + "\n")
    return code


def modules_for(arguments):
    """Modules that a headless command needs: Blender only for its own files and for pictures."""
    blender = any(a.lower().endswith(".blend") or a.startswith("--picture") for a in arguments)
    return ("numpy", "bpy") if blender else ("numpy",)


def missing(module):
    """True when this Python has no such module."""
    import importlib.util

    return importlib.util.find_spec(module) is None


def run_in_environment(arguments, modules):
    """Run this file again, in the environment beside it, after installing what is missing there."""
    folder = os.path.join(ROOT, ".venv-{0}.{1}".format(*sys.version_info[:2]))
    if os.path.realpath(sys.prefix) == os.path.realpath(folder):
        python = sys.executable
    else:
        place = ("Scripts", "python.exe") if os.name == "nt" else ("bin", "python")
        python = os.path.join(folder, *place)
    failure = prepare_environment(folder, python, modules)
    if failure:
        return fail(1, failure)
    again = [python, os.path.abspath(__file__)] + arguments
    if os.name == "posix":
        sys.stderr.flush()
        os.execv(python, again)
    return subprocess.call(again)


def prepare_environment(folder, python, modules):
    """Make the environment where needed; returns "" or the sentence that says what went wrong."""
    if not os.path.exists(python):
        say("Making an environment in " + folder)
        made = subprocess.run(
            [sys.executable, "-m", "venv", folder], capture_output=True, text=True
        )
        if made.returncode:
            return (
                "No virtual environment could be made in {0}; install Python's venv module"
                " (on Debian: python3-venv).".format(folder)
            )
    names = ", ".join(modules)
    check = "import importlib.util as u, sys; sys.exit(any(u.find_spec(m) is None for m in {0!r}))"
    if subprocess.call([python, "-c", check.format(modules)]) == 0:
        return ""
    say("Installing {0} into {1}; this is done once".format(names, folder))
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    installed = subprocess.run(pip + requirements(modules), capture_output=True, text=True)
    if installed.returncode:
        lines = [x for x in installed.stderr.splitlines() if "ERROR" in x] or [installed.stderr]
        return "pip could not install {0} ({1}).".format(names, lines[0].strip())
    return ""


def requirements(modules):
    """The requirements that pyproject.toml declares for these modules."""
    import tomllib

    with open(os.path.join(ROOT, "pyproject.toml"), "rb") as file:
        project = tomllib.load(file)["project"]
    wanted = list(project["dependencies"])
    if "bpy" in modules:
        wanted += project["optional-dependencies"]["blender"]
    if "pytest" in modules:
        wanted += project["optional-dependencies"]["test"]
    return wanted


def load_command_line():
    """The module crossfield_addon.command_line, with this folder as its package's root.

    Blender loads the same module as a part of the extension; here the root package gets a name of
    its own, so that the module's relative imports work whatever this folder is called.
    """
    import importlib
    import importlib.util

    if PACKAGE not in sys.modules:
        spec = importlib.util.spec_from_file_location(
            PACKAGE, os.path.join(ROOT, "__init__.py"), submodule_search_locations=[ROOT]
        )
        package = importlib.util.module_from_spec(spec)
        sys.modules[PACKAGE] = package
        spec.loader.exec_module(package)
    return importlib.import_module(PACKAGE + ".crossfield_addon.command_line")


def run_command(arguments):
    """The headless command itself."""
    return load_command_line().main(arguments)


def run_example(arguments):
    """Decompose the shipped plate; writes a Blender file, quads, a report and a picture."""
    os.chdir(ROOT)
    if not os.path.isdir("output"):
        os.mkdir("output")
    outputs = []
    for option in sorted(EXAMPLE_OUTPUTS):
        outputs += ["--" + option, os.path.join("output", "plate." + EXAMPLE_OUTPUTS[option])]
    return run_command(EXAMPLE + outputs + arguments)


def run_tests(arguments):
    """pytest on this checkout; the slow tests only with --slow."""
    slow = "--slow" in arguments
    chosen = [] if slow else ["-m", "not slow"]
    rest = [a for a in arguments if a != "--slow"]
    return subprocess.call([sys.executable, "-m", "pytest"] + chosen + rest, cwd=ROOT)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
