"""Files for solvers, read back: the same blocks, the same points, the same patches."""

import base64
import os
import re
import shutil
import subprocess
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from core.blocks.block_quality import block_quality, quality_rows, quality_text
from core.blocks.t_layout import build_t_layout, find_t_edges
from core.divisions.block_mesh import block_mesh, block_mesh_obj
from core.divisions.regridding import block_grid, edge_chain
from core.divisions.wall_spacing import edge_loops
from core.errors import LayoutError, SettingsError
from core.files.block_mesh_dict import block_mesh_dict
from core.files.boundary_patches import loop_patches, material_patches
from core.files.extrusion import extrude, extrusion_height
from core.files.mesh_files import read_mesh
from core.files.obj_materials import parse_materials
from core.files.plain_hexahedra import cut_to_plain_hexahedra
from core.files.plot3d import FORMS, neutral_map, plot3d_grid
from core.files.vtk_blocks import vtk_files
from core.pipeline import decompose
from core.settings import Settings
from tests.core import surfaces

MAKERS = {
    "holes": lambda: surfaces.plate_with_holes(24),
    "octant": lambda: surfaces.octant(12),
    "annulus": lambda: surfaces.annulus(36, 8),
    "sphere": lambda: surfaces.sphere(8),
}


EXAMPLES = {name: Path(__file__).parents[2] / "examples" / f"{name}.obj" for name in (
    "plate", "aerofoil", "octant",
)}


@pytest.fixture(scope="module", params=[*MAKERS, *(f"{name}.obj" for name in EXAMPLES)])
def result(request):
    if request.param in MAKERS:
        surface = MAKERS[request.param]()
        return decompose(surface.points, surface.triangles, Settings(quad_count=500))
    mesh = read_mesh(EXAMPLES[request.param.removesuffix(".obj")])
    return decompose(*mesh, Settings(quad_count=1500))


@pytest.fixture(params=["conforming", "t-junctions"])
def blocks(request, result):
    """The blocks of a result, conforming ones or those of the T-layout."""
    if request.param == "conforming":
        return result.blocks
    quads = result.quads
    kept = find_t_edges(quads.points, result.blocks, quads.crease)
    return build_t_layout(quads.quads, result.blocks, kept)


def patches_of(result, blocks=None):
    blocks = result.blocks if blocks is None else blocks
    return loop_patches(blocks, edge_loops(blocks, result.placement.loop))


def read_plot3d(data, form):
    """Blocks (k, j, i, 3) of a whole multi-block grid, by the format's definition."""
    if form == "ascii":
        number = np.array(data.split(), float)
        count = int(number[0])
        sizes, number = number[1 : 1 + 3 * count].astype(int), number[1 + 3 * count :]
    else:
        if form == "unformatted":
            records, place = [], 0
            while place < len(data):
                size = int.from_bytes(data[place : place + 4], "little")
                records.append(data[place + 4 : place + 4 + size])
                assert data[place + 4 + size : place + 8 + size] == data[place : place + 4]
                place += size + 8
            data = b"".join(records)
        count = int(np.frombuffer(data, "<i4", 1)[0])
        sizes = np.frombuffer(data, "<i4", 3 * count, 4)
        number = np.frombuffer(data, "<f8", offset=4 + 12 * count)
    grids = []
    for i, j, k in sizes.reshape(-1, 3):
        size = 3 * i * j * k
        grids.append(np.moveaxis(number[:size].reshape(3, k, j, i), 0, -1))
        number = number[size:]
    assert not len(number)
    return grids


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("extruded", [False, True])
def test_plot3d(result, blocks, form, extruded):
    points = result.quads.points
    back = extrude(points, result.quads.quads) if extruded else None
    grids = read_plot3d(plot3d_grid(points, blocks, form, back), form)
    assert len(grids) == blocks.count
    for block, grid in enumerate(grids):
        assert np.array_equal(grid[0], points[block_grid(blocks, block)])
        assert len(grid) == 1 + extruded
        if extruded:
            assert np.array_equal(grid[1], back[block_grid(blocks, block)])


def side_points(grid, face, first, second):
    """Points of a face over both index ranges, in the order in which the map runs them."""
    along, through = (np.arange(a, b + (1 if b >= a else -1), 1 if b >= a else -1) - 1
                      for a, b in (first, second))
    if face in (1, 2):
        return grid[0 if face == 1 else -1][np.ix_(through, along)].swapaxes(0, 1)
    if face in (3, 4):  # ranges j, k
        return grid[:, :, 0 if face == 3 else -1][np.ix_(through, along)].swapaxes(0, 1)
    return grid[:, 0 if face == 5 else -1][np.ix_(along, through)]  # ranges k, i


@pytest.mark.parametrize("extruded", [False, True])
def test_the_neutral_map_joins_the_same_points_and_names_every_side(result, blocks, extruded):
    points, patches = result.quads.points, patches_of(result, blocks)
    back = extrude(points, result.quads.quads) if extruded else None
    grids = read_plot3d(plot3d_grid(points, blocks, "binary", back), "binary")
    text = neutral_map(blocks, patches, extruded).decode()
    rows = [line.split() for line in text.splitlines() if not line.startswith("#")]
    assert int(rows[0][0]) == blocks.count
    for grid, row in zip(grids, rows[1:]):
        assert [int(r) for r in row[1:]] == list(grid.shape[2::-1])
    used, faces = {}, set()
    for row in rows[1 + blocks.count :]:
        number = [int(value) for value in row[1:] if value not in ("TRUE", "FALSE")]
        ends = [number[:6], number[6:]] if row[0] == "ONE_TO_ONE" else [number]
        sides = [
            side_points(grids[b - 1], face, rest[:2], rest[2:]) for b, face, *rest in ends
        ]
        faces |= {(b, face) for b, face, *_ in ends}
        if row[0] == "ONE_TO_ONE":
            other = sides[1].swapaxes(0, 1) if row[-1] == "TRUE" else sides[1]
            assert np.array_equal(sides[0], other)
        else:
            used.setdefault(row[0], []).append(sides[0].reshape(-1, 3))
    assert len(faces) == blocks.count * (6 if extruded else 4)
    for number, name in enumerate(patches.name):
        edges = np.flatnonzero(patches.edge_patch == number)
        wanted = np.unique(np.concatenate([points[edge_chain(blocks, e)] for e in edges]), axis=0)
        found = np.unique(np.concatenate(used.pop(name)), axis=0)
        if not extruded:
            assert np.array_equal(found, wanted)
        assert len(found) == len(wanted) * (2 if extruded else 1)
    assert set(used) == ({"front", "back"} if extruded else set())


def read_block_mesh_dict(text):
    """A small reader: (vertices, blocks, polylines, patches) by OpenFOAM's user guide."""
    body = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    tokens = re.findall(r"[()]|[^\s()]+", body)
    tokens = [t for t in " ".join(tokens).replace("{", " { ").replace("}", " } ").replace(
        ";", " ; ").split()]

    def nested(place):
        found = []
        while tokens[place] != ")":
            if tokens[place] == "(":
                inner, place = nested(place + 1)
                found.append(inner)
            else:
                found.append(tokens[place])
                place += 1
        return found, place + 1

    sections = {
        name: nested(tokens.index(name) + 2)[0]
        for name in ("vertices", "blocks", "edges", "boundary")
    }
    vertices = np.array(sections["vertices"], float)
    rows = sections["blocks"]
    blocks = [rows[k : k + 6] for k in range(0, len(rows), 6)]
    edges = sections["edges"]
    lines = {
        (int(edges[k + 1]), int(edges[k + 2])): np.array(edges[k + 3], float)
        for k in range(0, len(edges), 4)
    }
    patches, rows = {}, sections["boundary"]
    while rows:
        end = rows.index("}")
        patches[rows[0]] = np.array(next(r for r in rows[:end] if isinstance(r, list)), int)
        rows = rows[end + 1 :]
    return vertices, blocks, lines, patches


def graded_fractions(grading, count):
    """Where blockMesh puts the points of an edge, by its rules for multi-grading."""
    if grading == "1":
        return np.linspace(0, 1, count + 1)
    fractions = []
    for length, cells, growth in np.array(grading, float):
        ratio = growth ** (1 / (cells - 1)) if cells > 1 else 1.0
        cell = ratio ** np.arange(cells)
        fractions.append(length * cell / cell.sum())
    cell = np.concatenate(fractions)
    assert len(cell) == count
    return np.concatenate([[0], np.cumsum(cell)]) / cell.sum()


def test_block_mesh_dict(result):
    points, blocks, patches = result.quads.points, result.blocks, patches_of(result)
    back = extrude(points, result.quads.quads)
    text = block_mesh_dict(points, back, result.quads.quads, blocks, patches, False).decode()
    vertices, found, lines, named = read_block_mesh_dict(text)
    parts, owner = cut_to_plain_hexahedra(points, back, result.quads.quads, blocks)
    assert len(found) == parts.count and set(owner) == set(range(blocks.count))
    pairs = ((0, 1), (3, 2), (7, 6), (4, 5), (0, 3), (1, 2), (5, 6), (4, 7))
    corner_of = {tuple(p): k for sheet in (points, back) for k, p in enumerate(sheet)}
    known = {}
    for sheet in (points, back):
        for edge in range(len(parts.edge_offset) - 1):
            curve = sheet[edge_chain(parts, edge)]
            known[tuple(curve[0]), tuple(curve[-1])] = curve
            known[tuple(curve[-1]), tuple(curve[0])] = curve[::-1]
    for number, (_, corners, zone, size, kind, grading) in enumerate(found):
        corners = [int(c) for c in corners]
        assert zone == f"block_{owner[number]:04d}" and kind == "edgeGrading"
        assert [int(s) for s in size] == [*parts.shape[number], 1]
        assert [corner_of[tuple(vertices[c])] for c in corners[:4]] == list(parts.corner[number])
        assert np.array_equal(vertices[corners[4:]], back[parts.corner[number]])
        for place, (a, b) in enumerate(pairs):
            ends = corners[a], corners[b]
            curve = known[tuple(vertices[ends[0]]), tuple(vertices[ends[1]])]
            inner = lines.get(ends)
            inner = lines[ends[::-1]][::-1] if inner is None and ends[::-1] in lines else inner
            inner = np.zeros((0, 3)) if inner is None else inner
            polyline = np.concatenate([vertices[[ends[0]]], inner, vertices[[ends[1]]]])
            arc = np.linalg.norm(np.diff(polyline, axis=0), axis=1)
            arc = np.concatenate([[0], np.cumsum(arc)])
            place_on = graded_fractions(grading[place], len(curve) - 1) * arc[-1]
            made = np.stack([np.interp(place_on, arc, polyline[:, c]) for c in range(3)], axis=1)
            assert np.abs(made - curve).max() < 1e-7
    assert list(named) == ["front", "back", *patches.name]
    assert len(named["front"]) == len(named["back"]) == parts.count
    for number, name in enumerate(patches.name):
        chains = [edge_chain(blocks, e) for e in np.flatnonzero(patches.edge_patch == number)]
        on_patch = {(tuple(points[v]), tuple(points[w])) for c in chains for v, w in zip(c, c[1:])}
        reached = set()
        for start, end, *_ in named[name].tolist():
            curve = [tuple(p) for p in known[tuple(vertices[start]), tuple(vertices[end])]]
            reached |= {*zip(curve, curve[1:])}
        assert {frozenset(step) for step in reached} == {frozenset(step) for step in on_patch}


openfoam = Path("/usr/share/openfoam/etc/bashrc")


@pytest.mark.skipif(
    shutil.which("blockMesh") is None or not openfoam.exists(), reason="OpenFOAM is not installed"
)
def test_openfoam_makes_the_blocks(result, tmp_path):
    points, blocks, patches = result.quads.points, result.blocks, patches_of(result)
    back = extrude(points, result.quads.quads)
    (tmp_path / "system").mkdir()
    (tmp_path / "constant").mkdir()
    data = block_mesh_dict(points, back, result.quads.quads, blocks, patches, False)
    (tmp_path / "system" / "blockMeshDict").write_bytes(data)
    (tmp_path / "system" / "controlDict").write_text(
        "FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }\n"
        "application blockMesh; startFrom startTime; startTime 0; stopAt endTime; endTime 1;\n"
        "deltaT 1; writeControl timeStep; writeInterval 1; writePrecision 14;\n"
    )
    done = subprocess.run(
        ["bash", "-c", f". {openfoam}; blockMesh"], cwd=tmp_path, capture_output=True, text=True,
        env={**os.environ, "HOME": str(tmp_path)},
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert f"nCells: {len(result.quads.quads)}" in done.stdout
    assert f"with {blocks.count} cellZones" in done.stdout
    boundary = (tmp_path / "constant" / "polyMesh" / "boundary").read_text()
    faces = dict(re.findall(r"(\w+)\s*{[^}]*?nFaces\s+(\d+);", boundary))
    for number, name in enumerate(patches.name):
        edges = np.flatnonzero(patches.edge_patch == number)
        assert int(faces[name]) == (np.diff(blocks.edge_offset)[edges] - 1).sum()
    text = (tmp_path / "constant" / "polyMesh" / "points").read_text()
    made = np.array(re.findall(r"^\((\S+) (\S+) (\S+)\)$", text, flags=re.M), float)
    on_edges = np.concatenate([points[blocks.edge_vertex], back[blocks.edge_vertex]])
    distance = np.linalg.norm(on_edges[:, None] - made, axis=2).min(1)
    assert distance.max() < 1e-7


def read_structured(data):
    """Extent, points and cell arrays of a .vts, by the file format's definition."""
    piece = ElementTree.fromstring(data)[0][0]
    extent = [int(value) for value in piece.get("Extent").split()]
    arrays = {}
    for array in piece.iter("DataArray"):
        content = base64.b64decode(array.text)
        assert int.from_bytes(content[:8], "little") == len(content) - 8
        kind = {"Float64": "<f8", "Int32": "<i4"}[array.get("type")]
        value = np.frombuffer(content[8:], kind)
        components = int(array.get("NumberOfComponents", 1))
        arrays[array.get("Name")] = value.reshape(-1, components) if components > 1 else value
    return extent, arrays


def test_vtk_by_its_definition(result, blocks):
    points, patches = result.quads.points, patches_of(result, blocks)
    data, files = vtk_files(points, result.quads.quads, blocks, patches, "folder")
    first, second = ElementTree.fromstring(data)[0]
    assert [first.get("name"), second.get("name")] == ["blocks", "patches"]
    names = [entry.get("file") for entry in ElementTree.fromstring(data).iter("DataSet")]
    assert sorted(names) == sorted(f"folder/{name}" for name in files)
    for block, entry in enumerate(first):
        extent, arrays = read_structured(files[entry.get("file").removeprefix("folder/")])
        assert extent == [0, blocks.shape[block, 0], 0, blocks.shape[block, 1], 0, 0]
        assert np.array_equal(arrays["points"], points[block_grid(blocks, block)].reshape(-1, 3))
        assert (arrays["block"] == block).all()
    assert [group.get("name") for group in second] == patches.name
    for number, group in enumerate(second):
        for entry in group:
            _, arrays = read_structured(files[entry.get("file").removeprefix("folder/")])
            edge = arrays["edge"][0]
            assert patches.edge_patch[edge] == number and (arrays["patch"] == number).all()
            assert np.array_equal(arrays["points"], points[edge_chain(blocks, edge)])


@pytest.mark.parametrize("extruded", [False, True])
def test_vtk(result, blocks, tmp_path, extruded):
    pyvista = pytest.importorskip("pyvista")
    points, patches = result.quads.points, patches_of(result, blocks)
    back = extrude(points, result.quads.quads) if extruded else None
    middle = points[result.quads.quads].mean(1)
    values = {"x": middle[:, 0], "y": middle[:, 1]}
    data, files = vtk_files(points, result.quads.quads, blocks, patches, "grid_vtm", values, back)
    (tmp_path / "grid_vtm").mkdir()
    (tmp_path / "grid.vtm").write_bytes(data)
    for name, content in files.items():
        (tmp_path / "grid_vtm" / name).write_bytes(content)
    read = pyvista.read(tmp_path / "grid.vtm")
    assert read["blocks"].keys() == [f"block_{b:04d}" for b in range(blocks.count)]
    for block in range(blocks.count):
        grid = read["blocks"][block]
        vertex = block_grid(blocks, block)
        assert grid.dimensions == (*vertex.shape[::-1], 1 + extruded)
        wanted = points[vertex].reshape(-1, 3)
        assert np.abs(grid.points[: len(wanted)] - wanted).max() == 0
        assert (grid.cell_data["block"] == block).all()
        inside = wanted.reshape(*vertex.shape, 3)
        centre = inside[:-1, :-1] + inside[1:, :-1] + inside[:-1, 1:] + inside[1:, 1:]
        assert np.allclose(grid.cell_data["x"], centre[..., 0].ravel() / 4)
        assert np.allclose(grid.cell_data["y"], centre[..., 1].ravel() / 4)
    assert [n for n in read["patches"].keys() if n] == patches.name
    for number, name in enumerate(patches.name):
        edges = np.flatnonzero(patches.edge_patch == number)
        group = read["patches"][name]
        assert group.keys() == [f"edge_{e:04d}" for e in edges]
        for edge, line in zip(edges, group):
            wanted = points[edge_chain(blocks, edge)]
            assert np.abs(line.points[: len(wanted)] - wanted).max() == 0


def test_the_block_mesh_has_a_quad_for_each_block(result):
    blocks = result.blocks
    mesh = block_mesh(result.quads.points, blocks)
    assert np.array_equal(mesh.points[mesh.quads], result.quads.points[blocks.corner])
    text = block_mesh_obj(mesh).decode().splitlines()
    vertex = np.array([line.split()[1:] for line in text if line.startswith("v ")], float)
    groups, links, name = {}, [], None
    for line in text:
        word = line.split()
        links += [[int(e) for e in word[2:]]] if line.startswith("# edges") else []
        name = word[1] if word[0] == "g" else name
        if word[0] in "fl":
            groups[name] = np.array(word[1:], int) - 1
    assert np.array_equal(links, blocks.block_edge)
    for block in range(blocks.count):
        corner = vertex[groups[f"block_{block:04d}"]]
        assert np.array_equal(corner, result.quads.points[blocks.corner[block]])
    for edge in range(len(blocks.edge_offset) - 1):
        curve = vertex[groups[f"edge_{edge:04d}"]]
        assert np.array_equal(curve, result.quads.points[edge_chain(blocks, edge)])
    chord = mesh.edge_chord[mesh.block_edge]
    assert np.array_equal(chord[:, :2], chord[:, 2:])


def test_the_quality_table(result, blocks):
    quads = result.quads
    rows = quality_rows(
        blocks, block_quality(quads.points, quads.quads, blocks, quads.scaled_jacobian)
    )
    assert sum(row["quads"] for row in rows) == len(quads.quads)
    assert min(r["min_scaled_jacobian"] for r in rows) == quads.scaled_jacobian.min()
    for row in rows:
        assert row["min_scaled_jacobian"] <= row["mean_scaled_jacobian"] <= 1 + 1e-12
        assert 0 <= row["max_skewness"] <= 1 <= row["max_aspect_ratio"]
        assert len(row["edges"]) >= 4
        around = np.concatenate([edge_chain(blocks, edge) for edge in row["edges"]])
        assert set(blocks.corner[row["block"]]) <= set(around)
    text = quality_text(rows).splitlines()
    assert len(text) == blocks.count + 2 and text[-1].startswith("worst")


def test_extrusion_goes_along_the_normals():
    surface = surfaces.octant(8)
    result = decompose(surface.points, surface.triangles, Settings(quad_count=300))
    points, quads = result.quads.points, result.quads.quads
    back = extrude(points, quads, 0.25)
    assert np.allclose(np.linalg.norm(back - points, axis=1), 0.25)
    outward = np.sign((result.whole.face_normal * result.whole.points[
        result.whole.triangles].mean(1)).sum(1).mean())
    assert np.allclose(np.linalg.norm(back, axis=1), 1 + outward * 0.25, atol=0.02)
    assert extrusion_height(points, quads) == pytest.approx(
        np.linalg.norm(extrude(points, quads) - points, axis=1).mean()
    )
    for height in (0.0, -1.0, np.nan):
        with pytest.raises(SettingsError):
            extrude(points, quads, height)
    inward = quads[:, ::-1] if outward > 0 else quads
    with pytest.raises(LayoutError, match="fold over"):
        extrude(points, inward, 1.5)


def test_materials_name_the_patches():
    surface = surfaces.plate_with_holes(24)
    result = decompose(surface.points, surface.triangles, Settings(quad_count=500))
    left = surface.points[surface.triangles][:, :, 0].mean(1) < surface.points[:, 0].mean()
    loops = edge_loops(result.blocks, result.placement.loop)
    given = result.blocks, loops, result.placement.face, result.face_origin
    patches = material_patches(*given, np.where(left, 1, 0), ["out let", "1n"])
    assert patches.name == ["out_let", "_1n"]
    assert np.array_equal(patches.edge_patch >= 0, loops >= 0)
    middle = [result.quads.points[edge_chain(result.blocks, e)].mean(0)[0]
              for e in np.flatnonzero(patches.edge_patch == 1)]
    assert np.mean(np.array(middle) < surface.points[:, 0].mean()) > 0.9
    bare = material_patches(*given, np.zeros(len(left), int), ["steel"])
    assert bare.name == loop_patches(*given[:2]).name
    half = material_patches(*given, np.where(left, -1, 0), ["front"])
    assert half.name == bare.name
    two = np.where(left, -1, np.arange(len(left)) % 2)
    both = material_patches(*given, two, ["front", "front"])
    assert both.name[:2] == ["front_2", "front_3"] and both.name[2].startswith("loop_")


def test_materials_of_an_obj_file():
    data = b"v 0 0 0\nf 1 2 3\nusemtl in let\nf 1 2 3\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl in let\nf 2 3 1\n"
    names, number = parse_materials(data)
    assert names == ["in let", "b"] and number.tolist() == [-1, 0, 0, 1, 0]
    names, number = parse_materials(b"v 0 0 0\nf 1 2 3\n")
    assert names == [] and number.tolist() == [-1]
