"""The headless command: ``crossfield.py decompose`` and ``blender -c crossfield decompose``.

Exit codes: 0 done; 1 no valid result was found; 2 the command, a setting or the input is wrong;
130 interrupted. Every failure is one line on standard error, and no output file is touched.
"""

from __future__ import annotations

import argparse
import json
import sys
import traceback
from dataclasses import dataclass, replace
from math import degrees, radians
from pathlib import Path

import numpy as np

from ..core.errors import CrossfieldError, InputError, LayoutError, SettingsError
from ..core.files.mesh_files import read_mesh, write_quads_obj
from ..core.pipeline import decompose
from ..core.settings import COARSENESSES, LINES, RELAXATIONS, STAGES, Settings
from . import exports
from .marked_edges import MARKS, USUAL_MARKS
from .output_files import OutputFiles, check_targets

_DEFAULTS = Settings()
_SUFFIXES = {"output": ".blend", "quads": ".obj", "report": ".json", "picture": ".png"}
_SUFFIXES |= exports.SUFFIXES


def main(argv=None) -> int:
    """Run the command with these arguments (default: the process's) and return its exit code."""
    try:
        _run(_parser().parse_args(argv))
    except SystemExit as end:
        return int(end.code or 0)
    except KeyboardInterrupt:
        return _fail(130, "Interrupted; nothing was written.")
    except LayoutError as error:
        return _fail(1, str(error))
    except CrossfieldError as error:
        return _fail(2, str(error))
    except MemoryError:
        return _fail(1, "The memory does not suffice for this mesh; use a coarser one.")
    except OSError as error:
        return _fail(2, f"{error.filename or 'A file'}: {error.strerror or error}.")
    except ImportError as error:
        return _fail(1, f"A library cannot be loaded ({error}); install it and run again.")
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(place.filename).name}, line {place.lineno}"
        return _fail(
            1, f"Crossfield failed on this input ({error!r} in {where}); please report it."
        )
    return 0


def _fail(code, sentence) -> int:
    print("crossfield: " + " ".join(sentence.split()), file=sys.stderr)
    return code


class _Parser(argparse.ArgumentParser):
    """Usage errors in one line."""

    def error(self, message):
        raise SettingsError(f"{message}; see {self.prog} --help.")


def _parser():
    parser = _Parser(prog="crossfield", description="Multi-block decomposition of surfaces.")
    commands = parser.add_subparsers(dest="command", required=True, parser_class=_Parser)
    command = commands.add_parser(
        "decompose",
        help="turn a mesh into blocks of quads",
        description="Turn a mesh into a conforming multi-block quad mesh.",
    )
    command.add_argument("input", type=Path, help="mesh to decompose: .obj .ply .stl .blend")
    _add_outputs(command)
    exports.add_flags(command)
    _add_settings(command)
    return parser


def _add_outputs(command):
    outputs = command.add_argument_group("outputs, written together or not at all")
    outputs.add_argument("--output", type=Path, metavar="F.blend", help="Blender file with results")
    outputs.add_argument("--quads", type=Path, metavar="F.obj", help="quad mesh, grouped by block")
    outputs.add_argument("--report", type=Path, metavar="F.json", help="numbers of the result")
    outputs.add_argument("--picture", type=Path, metavar="F.png", help="picture of the blocks")


def _add_settings(command):
    settings = command.add_argument_group("settings")
    size = settings.add_mutually_exclusive_group()
    size.add_argument("--edge-length", type=float, metavar="L", help="wanted edge of a quad")
    size.add_argument(
        "--quad-count",
        type=int,
        metavar="N",
        default=_DEFAULTS.quad_count,
        help="wanted number of quads (%(default)s)",
    )
    _add_layout_settings(settings)
    _add_feature_settings(settings)
    _add_input_settings(settings)


def _add_layout_settings(settings):
    settings.add_argument(
        "--relaxation",
        choices=RELAXATIONS,
        default=_DEFAULTS.relaxation,
        help="relaxation of the cross field (%(default)s)",
    )
    settings.add_argument(
        "--lines",
        choices=LINES,
        default=_DEFAULTS.lines,
        help="lines stop at lines, or cross and run on to the boundary (%(default)s)",
    )
    settings.add_argument(
        "--coarseness",
        choices=COARSENESSES,
        default=_DEFAULTS.coarseness,
        help="blocks as traced, few of good shape, or fewest (%(default)s)",
    )
    settings.add_argument(
        "--t-junctions",
        action="store_true",
        help="the fewest blocks of all; corners may lie inside sides of others",
    )
    settings.add_argument(
        "--line-distance",
        type=float,
        metavar="D",
        default=_DEFAULTS.line_distance,
        help="limit on a full streamline, in diameters of the surface (%(default).0f)",
    )
    settings.add_argument(
        "--line-turn",
        type=float,
        metavar="DEGREES",
        default=degrees(_DEFAULTS.line_turn),
        help="limit on the turning of a full streamline (%(default).0f)",
    )
    settings.add_argument(
        "--stop-after",
        choices=STAGES,
        default=_DEFAULTS.stop_after,
        help="last stage to run (%(default)s)",
    )


def _add_feature_settings(settings):
    settings.add_argument(
        "--kink-angle",
        type=float,
        metavar="DEGREES",
        default=degrees(_DEFAULTS.kink_angle),
        help="boundary vertices that turn by more are kept (%(default).0f)",
    )
    settings.add_argument(
        "--feature-angle",
        type=float,
        metavar="DEGREES",
        default=degrees(_DEFAULTS.feature_angle or 0.0),
        help="angle between faces from which their edge is kept, 0: never (%(default).0f)",
    )
    settings.add_argument(
        "--feature-follow-angle",
        type=float,
        metavar="DEGREES",
        default=degrees(_DEFAULTS.feature_follow_angle),
        help="angle down to which a crease is followed from its ends (%(default).0f)",
    )


def _add_input_settings(settings):
    settings.add_argument(
        "--weld-distance",
        type=float,
        metavar="L",
        default=_DEFAULTS.weld_distance,
        help="vertices no farther apart count as one (%(default).0f)",
    )
    settings.add_argument(
        "--no-repair", action="store_true", help="refuse a faulty mesh instead of repairing it"
    )
    settings.add_argument("--keep-lines", action="store_true", help="lines in the Blender file too")
    settings.add_argument(
        "--marks",
        type=_marks,
        metavar="KINDS",
        help="edges of a .blend to keep, of sharp,seam,crease,material, or none (sharp)",
    )
    settings.add_argument("--object", metavar="NAME", help="mesh object to take from a .blend")


def _marks(text):
    """Identifiers of MARKS from names with commas between them."""
    known = {mark[0].lower(): mark[0] for mark in MARKS}
    names = [] if text == "none" else text.lower().split(",")
    for name in names:
        if name not in known:
            raise argparse.ArgumentTypeError(
                f"{name!r} is no kind of mark; choose of {', '.join(known)}, or none"
            )
    return frozenset(known[name] for name in names)


def _settings(arguments) -> Settings:
    return Settings(
        edge_length=arguments.edge_length,
        quad_count=arguments.quad_count,
        relaxation=arguments.relaxation,
        lines=arguments.lines,
        coarseness=arguments.coarseness,
        t_junctions=arguments.t_junctions,
        kink_angle=radians(arguments.kink_angle),
        feature_angle=radians(arguments.feature_angle) if arguments.feature_angle else None,
        feature_follow_angle=radians(arguments.feature_follow_angle),
        weld_distance=arguments.weld_distance,
        repair=not arguments.no_repair,
        line_distance=arguments.line_distance,
        line_turn=radians(arguments.line_turn),
        stop_after=arguments.stop_after,
    )


@dataclass(frozen=True)
class _Given:
    """The mesh to decompose, the Blender object it came from (None for other files), and the
    decomposition before it was divided as wanted.
    """

    points: np.ndarray
    polygons: object
    source: object = None
    arrays: object = None
    computed: object = None
    wanted: object = None


def _run(arguments):
    settings = _settings(arguments)
    targets = _targets(arguments, settings)
    wanted = exports.wanted_divisions(arguments)
    given = _read(arguments)
    computed = decompose(
        given.points, given.polygons, settings, progress=_progress(),
        marked_edges=None if given.arrays is None else given.arrays.marked_edges,
    )
    wanted = exports.with_material_walls(wanted, given, arguments, computed)
    decomposition = wanted.divide(computed)
    given = replace(given, computed=computed, wanted=wanted)
    with OutputFiles() as files:
        for kind, target in targets.items():
            _WRITERS[kind](files.temporary(target), arguments, given, decomposition)
    _tell(decomposition, targets)
    if arguments.quality_table:
        exports.print_table(decomposition)


def _read(arguments) -> _Given:
    path = arguments.input
    from_blend = path.suffix.lower() == ".blend"
    if arguments.object is not None and not from_blend:
        raise SettingsError("--object names an object of a .blend file; leave it out here.")
    if arguments.marks is not None and not from_blend:
        raise SettingsError("--marks names edges marked in a .blend file; leave it out here.")
    if path.is_dir() or not path.exists():
        raise InputError(
            f"{path} is {'a directory' if path.is_dir() else 'not there'}; name a file."
        )
    if not from_blend:
        return _Given(*read_mesh(path))
    from .blend_files import open_object

    marks = USUAL_MARKS if arguments.marks is None else arguments.marks
    source, arrays = open_object(path, arguments.object, marks)
    return _Given(arrays.points, arrays.polygons, source, arrays)


def _write_blend(path, arguments, given, decomposition):
    from .blend_files import new_file_with, save_results

    source, arrays = given.source, given.arrays
    if source is None:
        source, arrays = new_file_with(arguments.input.stem, given.points, given.polygons)
    save_results(
        path, source, arrays, decomposition, arguments.keep_lines, given.computed, given.wanted
    )


def _write_quads(path, arguments, given, decomposition):
    quads, blocks = decomposition.quads, decomposition.layout
    write_quads_obj(path, quads.points, quads.quads, blocks.quad_block)


def _write_report(path, arguments, given, decomposition):
    report = decomposition.report()
    if arguments.quality_table:
        report["blocks"]["table"] = exports.quality_table(decomposition)
    text = json.dumps(report, indent=2, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def _write_picture(path, arguments, given, decomposition):
    from .picture import render_picture

    render_picture(path, decomposition)


_WRITERS = {
    "output": _write_blend,
    "quads": _write_quads,
    "report": _write_report,
    "picture": _write_picture,
    **exports.WRITERS,
}


def _targets(arguments, settings) -> dict[str, Path]:
    """Kind of output -> file, for the outputs that were asked for."""
    targets = {k: getattr(arguments, k) for k in _SUFFIXES if getattr(arguments, k) is not None}
    for kind, target in targets.items():
        if target.suffix.lower() != _SUFFIXES[kind]:
            flag, suffix = kind.replace("_", "-"), _SUFFIXES[kind] or "no suffix"
            raise SettingsError(f"The file for --{flag} must end in {suffix}: {target}.")
    if settings.stop_after != "quads" and "quads" in targets:
        raise SettingsError(f"There are no quads after --stop-after {settings.stop_after}.")
    if settings.stop_after != "quads" and "picture" in targets:
        raise SettingsError(
            f"There are no blocks to draw after --stop-after {settings.stop_after}."
        )
    exports.refuse_without_blocks(arguments, settings)
    for kind, target in list(targets.items()):
        targets |= exports.companions(kind, target)
    check_targets(list(targets.values()), arguments.input)
    return targets


def _progress():
    """Progress on standard error where somebody watches it, else None."""
    if not sys.stderr.isatty():
        return None

    def show(fraction, stage):
        end = "\r\033[K" if fraction >= 1 else ""
        print(f"\r\033[K{100 * fraction:3.0f} %  {stage}{end}", end="", file=sys.stderr, flush=True)

    return show


def _tell(decomposition, targets):
    """The short result for a reader."""
    print(decomposition.sentence())
    for warning in decomposition.warnings:
        print(f"note: {warning}")
    times = [f"{stage} {seconds:.2f}" for stage, seconds in decomposition.seconds.items()]
    print("CPU seconds: " + ", ".join(times))
    for target in targets.values():
        print(f"wrote {target}")
