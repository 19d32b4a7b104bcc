"""The headless command: every flag, bad input, files all or none, interruption."""

import importlib.util
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import crossfield

ROOT = Path(crossfield.ROOT)
FLAGS = "--output --quads --report --picture --edge-length --quad-count --relaxation --lines"
FLAGS += (
    " --coarseness --t-junctions --kink-angle --feature-angle --feature-follow-angle --weld-distance --no-repair"
)
FLAGS += " --line-distance --line-turn --stop-after --keep-lines --object --marks"
needs_blender = pytest.mark.skipif(
    importlib.util.find_spec("bpy") is None, reason="Blender's Python module is not installed"
)


def grid(columns=12, rows=8, width=3.0, height=2.0):
    """Points and triangles of a flat rectangle."""
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1))
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]), triangles


def write_obj(path, points, polygons):
    lines = [f"v {x} {y} {z}" for x, y, z in points]
    lines += ["f " + " ".join(str(v + 1) for v in polygon) for polygon in polygons]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture
def plate(tmp_path):
    return write_obj(tmp_path / "plate.obj", *grid())


def run(*arguments):
    """Run the command in this process."""
    return crossfield.run_command(["decompose", *map(str, arguments)])


def run_apart(*arguments, **options):
    """Run the command as a user does."""
    command = [sys.executable, str(ROOT / "crossfield.py"), "decompose", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, **options)


def contents(folder):
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()}


def refused(capsys, code, *words):
    """Check that the last run printed one line with these words on standard error and no more."""
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("crossfield: ") and err.count("\n") == 1, err
    assert len(err) < 300 and "Traceback" not in err
    for word in words:
        assert word in err, err
    return code


def faces(path):
    return sum(line.startswith("f ") for line in path.read_text().splitlines())


def test_quads_and_report(plate, tmp_path, capsys):
    quads, report = tmp_path / "q.obj", tmp_path / "r.json"
    assert run(plate, "--quads", quads, "--report", report, "--quad-count", 150) == 0
    numbers = json.loads(report.read_text())
    assert numbers["index_sum"] == numbers["expected_index_sum"]
    assert numbers["singularities"] == [] and numbers["blocks"]["count"] == 1
    assert numbers["quads"]["count"] == faces(quads)
    assert 127 <= faces(quads) <= 173
    assert numbers["quads"]["min_scaled_jacobian"] > 0.9
    out, err = capsys.readouterr()
    assert err == ""
    assert out.startswith("0 singularities, index sum as topology asks; 1 block; ")
    assert "CPU seconds: " in out and f"wrote {quads}" in out and f"wrote {report}" in out
    assert sorted(contents(tmp_path)) == ["plate.obj", "q.obj", "r.json"]


def test_edge_length(plate, tmp_path):
    quads = tmp_path / "q.obj"
    assert run(plate, "--quads", quads, "--edge-length", 0.25) == 0
    assert 82 <= faces(quads) <= 110


@pytest.mark.parametrize(
    "option, value",
    [("--relaxation", v) for v in ("none", "harmonic", "diffused")]
    + [("--lines", v) for v in ("motorcycle", "full")]
    + [("--coarseness", v) for v in ("direct", "balanced", "fewest")]
    + [("--kink-angle", 30), ("--feature-angle", 0), ("--feature-follow-angle", 30)]
    + [("--weld-distance", 0.001), ("--line-distance", 3), ("--line-turn", 720)],
)
def test_settings(plate, tmp_path, option, value):
    report = tmp_path / "r.json"
    stop = ("--stop-after", "lines") if value == "full" else ()
    assert run(plate, "--report", report, option, value, *stop) == 0
    assert json.loads(report.read_text())["index_sum"] == 4


def test_stopping_early(plate, tmp_path, capsys):
    report = tmp_path / "r.json"
    assert run(plate, "--stop-after", "field", "--report", report) == 0
    assert "quads" not in json.loads(report.read_text())
    assert capsys.readouterr().out.startswith("0 singularities, index sum as topology asks\n")
    assert run(plate, "--stop-after", "lines", "--report", report) == 0
    assert "quads" not in json.loads(report.read_text())
    capsys.readouterr()
    assert run(plate, "--stop-after", "lines", "--quads", tmp_path / "q.obj") == 2
    refused(capsys, 2, "no quads")


def test_help_names_every_flag(capsys):
    assert run("--help") == 0
    text = capsys.readouterr().out
    assert all(flag in text for flag in FLAGS.split())


@pytest.mark.parametrize(
    "arguments, words",
    [
        ([], ["input"]),
        (["--quad-count", "many"], ["--quad-count", "many"]),
        (["--quad-count", "0"], ["quads", "0"]),
        (["--quad-count", "-5"], ["quads", "-5"]),
        (["--edge-length", "0"], ["edge length"]),
        (["--edge-length", "nan"], ["edge length"]),
        (["--edge-length", "1", "--quad-count", "9"], ["not allowed with"]),
        (["--relaxation", "strong"], ["strong", "diffused"]),
        (["--lines", "wavy"], ["wavy", "motorcycle"]),
        (["--coarseness", "rough"], ["rough", "balanced"]),
        (["--stop-after", "lunch"], ["lunch", "field"]),
        (["--kink-angle", "120"], ["kink angle"]),
        (["--line-distance", "-1"], ["limits"]),
        (["--weld-distance", "-1"], ["weld distance"]),
        (["--feature-angle", "200"], ["feature angles"]),
        (["--feature-angle", "30", "--feature-follow-angle", "50"], ["must not exceed"]),
        (["--colour", "red"], ["--colour"]),
        (["--object", "Cube"], ["--object", ".blend"]),
        (["--marks", "seam"], ["--marks", ".blend"]),
        (["--marks", "sharp,bevel"], ["'bevel'", "crease"]),
        (["--quads", "q.stl"], ["--quads", ".obj"]),
        (["--report", "r.txt"], ["--report", ".json"]),
        (["--output", "r.obj"], ["--output", ".blend"]),
        (["--picture", "r.jpg"], ["--picture", ".png"]),
        (["--quads", "nowhere/q.obj"], ["nowhere", "create"]),
        (["--quads", "folder.obj"], ["folder.obj", "directory"]),
        (["--quads", "plate.obj"], ["plate.obj", "input"]),
    ],
)
def test_wrong_usage(plate, tmp_path, monkeypatch, capsys, arguments, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.obj").mkdir()
    before = contents(tmp_path)
    assert run(*([plate.name, *arguments] if arguments else [])) == 2
    refused(capsys, 2, *words)
    assert contents(tmp_path) == before


SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
FAN = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]]
BAD_FILES = {
    "empty.obj": (b"", []),
    "points.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", ["face"]),
    "prose.obj": (b"This is not a mesh.\n", []),
    "binary.obj": (bytes(range(256)) * 8, []),
    "range.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", ["range.obj", "face 1"]),
    "nan.obj": (b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n", ["ertex"]),
    "infinite.obj": (b"v 0 0 0\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n", ["ertex"]),
    "picture.ply": (b"\x89PNG\r\n\x1a\n" + bytes(64), []),
    "short.stl": (bytes(80) + b"\x05\x00\x00\x00" + bytes(30), []),
    "empty.stl": (b"", []),
    "mesh.xyz": (b"0 0 0\n", [".obj"]),
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_files_that_are_no_mesh(name, tmp_path, capsys):
    content, words = BAD_FILES[name]
    (tmp_path / name).write_bytes(content)
    assert run(tmp_path / name, "--quads", tmp_path / "q.obj") == 2
    refused(capsys, 2, name if not words else words[0], *words)
    assert sorted(contents(tmp_path)) == [name]


def test_input_that_is_not_there(tmp_path, capsys):
    assert run(tmp_path / "absent.obj") == 2
    refused(capsys, 2, "absent.obj")
    assert run(tmp_path) == 2
    refused(capsys, 2, "directory")


@pytest.mark.parametrize(
    "points, polygons, words",
    [
        (FAN, [[0, 1, 2], [1, 0, 3], [0, 1, 4]], ["edge"]),
        (SQUARE, [[0, 1, 2], [3, 2, 0]], ["0 and 1", "normals"]),
        ([[0, 0, 0]] * 3, [[0, 1, 2]], []),
    ],
    ids=["non-manifold", "orientation", "no-area"],
)
def test_meshes_that_cannot_be_decomposed(tmp_path, capsys, points, polygons, words):
    path = write_obj(tmp_path / "bad.obj", points, polygons)
    old = tmp_path / "q.obj"
    old.write_text("earlier result")
    assert run(path, "--no-repair", "--quads", old, "--report", tmp_path / "r.json") == 2
    refused(capsys, 2, *words)
    assert old.read_text() == "earlier result"
    assert sorted(contents(tmp_path)) == ["bad.obj", "q.obj"]


def test_files_appear_all_or_none(plate, tmp_path, monkeypatch, capsys):
    command_line = crossfield.load_command_line()

    def broken(path, *_):
        path.write_text("half a repor")
        raise OSError(28, "No space left on device", str(path))

    quads, report = tmp_path / "q.obj", tmp_path / "r.json"
    report.write_text("earlier report")
    monkeypatch.setitem(command_line._WRITERS, "report", broken)
    assert run(plate, "--quads", quads, "--report", report) == 2
    refused(capsys, 2, "No space left on device")
    assert sorted(contents(tmp_path)) == ["plate.obj", "r.json"]
    assert report.read_text() == "earlier report"


def test_interruption_in_the_core(plate, tmp_path, monkeypatch, capsys):
    command_line = crossfield.load_command_line()

    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(command_line, "decompose", interrupted)
    assert run(plate, "--quads", tmp_path / "q.obj") == 130
    refused(capsys, 130, "nterrupted")
    assert sorted(contents(tmp_path)) == ["plate.obj"]


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_interruption_from_the_keyboard(tmp_path):
    path = write_obj(tmp_path / "big.obj", *grid(250, 250))
    target = tmp_path / "q.obj"
    command = [sys.executable, str(ROOT / "crossfield.py"), "decompose", str(path)]
    command += ["--quad-count", "200000", "--quads", str(target)]
    # A shell that runs the tests in the background hands down that interrupts are ignored.
    process = subprocess.Popen(
        command,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    time.sleep(3)
    process.send_signal(signal.SIGINT)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    assert err.startswith("crossfield: ") and err.count("\n") == 1, err
    assert sorted(contents(tmp_path)) == ["big.obj"]


@needs_blender
def test_blender_file_and_picture(plate, tmp_path):
    blend, picture = tmp_path / "out.blend", tmp_path / "out.png"
    done = run_apart(plate, "--output", blend, "--picture", picture, "--keep-lines")
    assert done.returncode == 0 and done.stderr == "", done.stderr
    # Blender itself may log a line, with the time since its start in front.
    ours = [line for line in done.stdout.splitlines() if not line[:2].isdigit()]
    assert len(ours) == 4, done.stdout
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n" and picture.stat().st_size > 5000
    again, report = tmp_path / "again.blend", tmp_path / "r.json"
    done = run_apart(blend, "--object", "plate", "--output", again, "--report", report)
    assert done.returncode == 0, done.stderr
    assert json.loads(report.read_text())["blocks"]["count"] == 1
    names = "plate.obj out.blend out.png again.blend r.json"
    assert sorted(contents(tmp_path)) == sorted(names.split())
    for arguments, words in (
        ([blend, "--object", "Suzanne"], ["Suzanne", "'plate'"]),
        ([blend], []),
        ([blend, "--output", blend], ["input"]),
    ):
        done = run_apart(*arguments, "--quad-count", 50)
        if words:
            assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
            assert all(word in done.stderr for word in words), done.stderr
        else:
            assert done.returncode == 0, done.stderr


@needs_blender
def test_results_in_the_blender_file(plate, tmp_path):
    blend = tmp_path / "out.blend"
    arguments = "--output", blend, "--keep-lines", "--lock", "0=23"
    assert run_apart(plate, *arguments).returncode == 0
    look = """
import bpy, sys
bpy.ops.wm.open_mainfile(filepath=sys.argv[1])
objects = bpy.data.collections["Crossfield plate"].objects
print(sorted(o.name for o in objects), "crossfield_block" in bpy.data.meshes["plate"].attributes)
print("locks", sorted(v.value for v in objects["plate blocks"].data.attributes["lock"].data))
"""
    seen = subprocess.run([sys.executable, "-c", look, blend], capture_output=True, text=True)
    names = ["plate block boundaries", "plate blocks", "plate lines", "plate quads"]
    assert f"{names} True" in seen.stdout, seen.stdout + seen.stderr
    assert "locks [0, 0, 0, 23]" in seen.stdout, seen.stdout


@needs_blender
def test_marks_in_a_blender_file_are_kept_as_asked(plate, tmp_path):
    blend, marked, report = (tmp_path / name for name in ("out.blend", "marked.blend", "r.json"))
    assert run_apart(plate, "--output", blend, "--quad-count", 50).returncode == 0
    mark = """
import bpy, sys
bpy.ops.wm.open_mainfile(filepath=sys.argv[1])
mesh = bpy.data.meshes["plate"]
for edge in mesh.edges:
    points = [mesh.vertices[v].co for v in edge.vertices]
    edge.use_edge_sharp = all(abs(p.x - 0.75) < 1e-5 for p in points)
    edge.use_seam = all(abs(p.y - 0.5) < 1e-5 for p in points)
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[2], copy=True)
"""
    subprocess.run([sys.executable, "-c", mark, blend, marked], check=True, capture_output=True)
    arguments = [marked, "--object", "plate", "--quad-count", 150, "--report", report]
    for marks, count in (([], 2), (["--marks", "none"], 1), (["--marks", "sharp,seam"], 4)):
        done = run_apart(*arguments, *marks)
        assert done.returncode == 0, done.stderr
        assert json.loads(report.read_text())["blocks"]["count"] == count, marks


@needs_blender
def test_blender_files_that_are_none(tmp_path):
    for name, content in (("empty.blend", b""), ("prose.blend", b"BLENDER but not really")):
        path = tmp_path / name
        path.write_bytes(content)
        done = run_apart(path)
        assert done.returncode == 2, done.stderr
        assert done.stderr.startswith("crossfield: ") and done.stderr.count("\n") == 1
        assert name in done.stderr
