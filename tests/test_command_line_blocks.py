"""The headless command after the block layout: exports, locks, grading, quality."""

import json

import numpy as np
import pytest

from core.files.mesh_files import read_mesh
from tests.core import surfaces
from tests.test_command_line import ROOT, contents, plate, refused, run, write_obj  # noqa: F401

FLAGS = "--plot3d --plot3d-binary --plot3d-unformatted --blockmesh --vtk --block-mesh --extrude"
FLAGS += " --quality-table --lock --first-height --growth --wall --wall-material"


def test_help_names_every_flag(capsys):
    assert run("--help") == 0
    text = capsys.readouterr().out
    assert all(flag in text for flag in FLAGS.split())


def test_all_exports_appear_together(plate, tmp_path):  # noqa: F811
    arguments = [
        "--plot3d", tmp_path / "g.xyz", "--blockmesh", tmp_path / "blockMeshDict",
        "--vtk", tmp_path / "g.vtm", "--block-mesh", tmp_path / "b.obj",
    ]
    assert run(plate, *arguments, "--quad-count", 150) == 0
    names = ["b.obj", "blockMeshDict", "g.nmf", "g.vtm", "g.xyz", "plate.obj"]
    assert sorted(contents(tmp_path)) == names
    files = sorted(contents(tmp_path / "g_vtm"))
    assert files == ["block_0000.vts", *(f"edge_000{e}.vts" for e in range(4))]
    assert "loop_0" in (tmp_path / "blockMeshDict").read_text()
    assert "loop_0 1 5 1 1 1" in (tmp_path / "g.nmf").read_text()
    first = (tmp_path / "g.xyz").read_text().split()
    assert first[0] == "1" and first[3] == "1"
    _, polygons = read_mesh(tmp_path / "b.obj")
    assert len(polygons) == 1
    # A second run takes the place of the first, folder included.
    before = contents(tmp_path / "g_vtm")
    assert run(plate, *arguments, "--quad-count", 600, "--extrude", 0.5) == 0
    assert contents(tmp_path / "g_vtm") != before
    assert (tmp_path / "g.xyz").read_text().split()[3] == "2"
    assert "(0.0 0.0 0.5)" in (tmp_path / "blockMeshDict").read_text()
    assert not [p for p in tmp_path.iterdir() if "unfinished" in p.name]


@pytest.mark.parametrize("flag, marks", [("--plot3d-binary", 0), ("--plot3d-unformatted", 1)])
def test_binary_plot3d(plate, tmp_path, flag, marks):  # noqa: F811
    assert run(plate, "--plot3d", tmp_path / "g.xyz", flag, "--quad-count", 150) == 0
    number = np.frombuffer((tmp_path / "g.xyz").read_bytes()[:12], "<i4")
    assert number[marks] == 1 and (not marks or number[0] == 4)


def table(plate, tmp_path, *arguments):  # noqa: F811
    report = tmp_path / "r.json"
    assert run(plate, "--report", report, "--quality-table", *arguments) == 0
    return json.loads(report.read_text())["blocks"]["table"]


def test_locks_and_the_quality_table(plate, tmp_path, capsys):  # noqa: F811
    (row,) = table(plate, tmp_path, "--quad-count", 150)
    assert row["block"] == 0 and row["min_scaled_jacobian"] > 0.9
    out = capsys.readouterr().out
    assert "max skew" in out and out.rstrip().splitlines()[-1].startswith("worst")
    edge = row["edges"][0]
    (locked,) = table(plate, tmp_path, "--quad-count", 150, "--lock", f"{edge}=23")
    assert locked["divisions"][0] == 23
    assert abs(locked["quads"] / 150 - 1) <= 0.1
    both = [f"{edge}=23", f"{row['edges'][1]}=5"]
    (locked,) = table(plate, tmp_path, *(x for lock in both for x in ("--lock", lock)))
    assert locked["divisions"] == [23, 5]
    capsys.readouterr()
    against = ["--lock", f"{edge}=23", "--lock", f"{row['edges'][2]}=24"]
    assert run(plate, "--report", tmp_path / "x.json", *against) == 2
    refused(capsys, 2, "23", "24", str(edge), str(row["edges"][2]))
    assert not (tmp_path / "x.json").exists()


def test_grading(plate, tmp_path, capsys):  # noqa: F811
    grading = ["--first-height", 1e-3, "--growth", 1.3, "--wall", 0]
    (row,) = table(plate, tmp_path, *grading, "--vtk", tmp_path / "g.vtm")
    assert row["max_aspect_ratio"] > 20 and row["min_scaled_jacobian"] > 0.9
    pyvista = pytest.importorskip("pyvista")
    points = pyvista.read(tmp_path / "g.vtm")["blocks"][0].points
    assert np.diff(np.unique(points[:, 1].round(9)))[0] == pytest.approx(1e-3, rel=0.05)


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["--lock", "3"], ["--lock", "EDGE=N"]),
        (["--lock", "a=b"], ["EDGE=N"]),
        (["--lock", "99=3"], ["99"]),
        (["--lock", "0=0"], ["0"]),
        (["--growth", "1.2"], ["--growth", "--first-height"]),
        (["--wall", "0"], ["--wall", "--first-height"]),
        (["--wall-material", "skin"], ["--wall-material", "--first-height"]),
        (["--first-height", "1e-3", "--wall-material", "skin"], ["'skin'", "it has none"]),
        (["--first-height", "1e-3", "--wall-material", "a", "--wall", "0"], ["give one"]),
        (["--first-height", "-1"], ["first height"]),
        (["--first-height", "1e-3", "--growth", "0.9"], ["growth"]),
        (["--first-height", "1e-3", "--wall", "5"], ["loop 5"]),
        (["--first-height", "10"], ["regular spacing"]),
        (["--plot3d", "g.dat"], ["--plot3d", ".xyz"]),
        (["--vtk", "g.vtk"], ["--vtk", ".vtm"]),
        (["--block-mesh", "b.ply"], ["--block-mesh", ".obj"]),
        (["--plot3d-binary"], ["--plot3d"]),
        (["--extrude", "0"], ["height"]),
        (["--vtk", "g.vtm", "--stop-after", "lines"], ["--vtk", "blocks"]),
        (["--lock", "0=3", "--stop-after", "field"], ["--lock", "blocks"]),
        (["--blockmesh", "d", "--t-junctions"], ["--blockmesh", "conform", "--t-junctions"]),
        (["--block-mesh", "b.obj", "--t-junctions"], ["--block-mesh", "conform"]),
        (["--vtk", "mine.vtm"], ["mine_vtm", "directory"]),
    ],
)
def test_wrong_usage(plate, tmp_path, monkeypatch, capsys, arguments, words):  # noqa: F811
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine_vtm").mkdir()
    (tmp_path / "mine_vtm" / "notes.txt").write_text("my own")
    before = contents(tmp_path)
    assert run(plate.name, *arguments) == 2
    refused(capsys, 2, *words)
    assert contents(tmp_path) == before
    assert contents(tmp_path / "mine_vtm") == {"notes.txt": b"my own"}


def test_t_junctions(tmp_path):
    surface = surfaces.lshape(8)
    path = write_obj(tmp_path / "lshape.obj", surface.points, surface.triangles)
    report, quads, grid = tmp_path / "r.json", tmp_path / "q.obj", tmp_path / "g.xyz"
    outputs = ["--report", report, "--quads", quads, "--plot3d", grid, "--vtk", tmp_path / "g.vtm"]
    for divisions in ([], ["--lock", "0=7"]):
        assert run(path, "--t-junctions", "--quad-count", 200, "--quality-table", *outputs,
                   *divisions) == 0
        blocks = json.loads(report.read_text())["blocks"]
        assert (blocks["count"], blocks["conforming_count"]) == (2, 3)
        assert blocks["conforming"] is False and len(blocks["interfaces"]) == 8
        assert [row["divisions"] for row in blocks["table"]] == blocks["divisions"]
        assert quads.read_text().count("\ng block_") == 2
        assert grid.read_text().split()[0] == "2"
        assert (tmp_path / "g.nmf").read_text().count("ONE_TO_ONE") == 1
        assert len([f for f in contents(tmp_path / "g_vtm") if f.startswith("block_")]) == 2


def test_materials_become_patches(tmp_path, plate):  # noqa: F811
    lines, number = plate.read_text().splitlines(), -1
    result = []
    for line in lines:
        if line.startswith("f "):
            number += 1
            # The lower rows of the grid, and the others.
            lower = max(int(v) for v in line.split()[1:]) <= 13 * 3
            result.append("usemtl inlet" if lower else "usemtl wall")
        result.append(line)
    path = tmp_path / "two.obj"
    path.write_text("\n".join(result) + "\n")
    assert run(path, "--plot3d", tmp_path / "g.xyz") == 0
    text = (tmp_path / "g.nmf").read_text()
    names = [line.split()[0] for line in text.splitlines() if line.startswith(("inlet", "wall"))]
    assert sorted(names) == ["inlet", "wall", "wall", "wall"] and "loop_" not in text


def test_a_material_names_the_walls(tmp_path, plate):  # noqa: F811
    lines = plate.read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("f "))
    path = tmp_path / "skin.obj"
    path.write_text("\n".join([*lines[:first], "usemtl skin", *lines[first:]]) + "\n")
    (row,) = table(path, tmp_path, "--first-height", 1e-3, "--wall-material", "skin")
    assert row["max_aspect_ratio"] > 20


def test_the_number_of_quads_is_not_told_of_before_new_divisions(tmp_path, capsys):
    arguments = [ROOT / "examples" / "plate.obj", "--report", tmp_path / "r.json"]
    # As traced, the plate has more blocks than this.
    arguments += ["--quad-count", 40, "--coarseness", "direct"]
    assert run(*arguments) == 0
    assert " quads instead of 40" in capsys.readouterr().out
    assert run(*arguments, "--lock", "0=9") == 0
    assert " quads instead of 40" not in capsys.readouterr().out
