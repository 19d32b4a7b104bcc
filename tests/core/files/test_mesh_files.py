"""Mesh files read back to the last bit, and hostile files refused in one sentence."""

import os
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.errors import InputError
from core.files.mesh_files import read_mesh, write_quads_obj

POINTS = np.array(
    [(0, 0, 0), (1, 0, 1 / 3), (1, 1, -0.1), (0, 1, 1e-7), (2.5, 0.5, 1e9), (1.5, 2, np.pi)]
)
MIXED = [[0, 1, 2, 3], [1, 4, 2], [3, 2, 5], [0, 3, 5, 4, 1]]


def file_with(folder, name, content):
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def refusal(path):
    """The one sentence, about this path, with which it is refused."""
    with pytest.raises(InputError) as caught:
        read_mesh(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message and message.endswith(".") and ". " not in message
    return message


# ---- OBJ


def obj_text(points, polygons):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += ["f " + " ".join(str(v + 1) for v in p) for p in polygons]
    return "\n".join(lines) + "\n"


def test_obj_of_mixed_polygons(tmp_path):
    points, polygons = read_mesh(file_with(tmp_path, "a.obj", obj_text(POINTS, MIXED)))
    assert np.array_equal(points, POINTS)
    assert polygons == MIXED


@pytest.mark.parametrize("corners", [3, 4])
def test_obj_of_equal_polygons_is_an_array(tmp_path, corners):
    expected = [list(range(corners)), list(range(corners))[::-1]]
    _, polygons = read_mesh(file_with(tmp_path, "a.OBJ", obj_text(POINTS, expected)))
    assert polygons.dtype == np.int64 and polygons.tolist() == expected


OBJ_WITH_EVERYTHING = """\
# a comment with v 1 2 3 and f 1 2 3
mtllib some#thing.mtl
o thing
v 0 0 0 # behind the numbers
  v\t1 0 0 0.5 0.25 0.125
vt 0.5 0.5
vn 0 0 1
v 1 \\
  1 0
g first
usemtl red
s off
f 1/1/1 2/1/1 3/1/1
v 0 1.0e0 0 1.0
vp 1 2
f -4//1 -2//1 -1//1
f 1/1 2/1\t3 4
l 1 2
fo 1 2 3
  #f 1 2 4
f -4 -1 2/1/"""


@pytest.mark.parametrize("line_end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_obj_with_everything(tmp_path, line_end, mark):
    text = mark + OBJ_WITH_EVERYTHING.replace("\n", line_end)
    points, polygons = read_mesh(file_with(tmp_path, "a.obj", text))
    assert points.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    assert polygons == [[0, 1, 2], [0, 2, 3], [0, 1, 2, 3], [0, 3, 1]]


def test_obj_may_use_vertices_before_they_come(tmp_path):
    path = file_with(tmp_path, "a.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n")
    assert read_mesh(path)[1].tolist() == [[0, 1, 2]]


TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


@pytest.mark.parametrize(
    "text, expected",
    [
        ("", "is empty"),
        ("hello\nworld\n", "has no vertices, so it is not an OBJ mesh"),
        ("# only a comment", "has no vertices"),
        ("<html><body>not found</body></html>", "has no vertices"),
        (TRIANGLE, "has no faces"),
        (TRIANGLE + "l 1 2\n", "has no faces"),
        (TRIANGLE + "f 1 2 4\n", "face 1 of 1 refers to one beyond them"),
        (TRIANGLE + "f 1 2 3\nf -1 -2 -4\n", "face 2 of 2 refers to one beyond them"),
        (TRIANGLE + "f 1 2 99999999999999999999\n", "beyond them"),
        (TRIANGLE + "f 0 1 2\n", "refers to vertex 0 on line 4"),
        (TRIANGLE + "f 1 2 x\n", "line 4 has 'x' for a number"),
        (TRIANGLE + "f 1 2 3.5\n", "line 4 has '3.5' for a number"),
        (TRIANGLE + "f 1 2 /3\n", "line 4 has '/3' for a number"),
        ("v 0 0 0\nv 1 0,5 0\nv 0 1 0\nf 1 2 3\n", "line 2 has '0,5' for a number"),
        ("v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n", "fewer than three coordinates on line 2"),
        ("v 0 0 0\nv 1 0 1_0\nv 0 1 0\nf 1 2 3\n", "cannot be read"),
        ("ply\nformat ascii 1.0\n\0\0", "is not an OBJ file but binary data"),
        (("v 0 0 0\n" * 3 + "f 1 2 3\n").encode("utf-16"), "binary data"),
    ],
)
def test_hostile_obj(tmp_path, text, expected):
    assert expected in refusal(file_with(tmp_path, "a.obj", text))


def test_obj_passes_on_odd_numbers_to_the_cleaning(tmp_path):
    path = file_with(tmp_path, "a.obj", "v nan 0 0\nv inf 0 0\nv 0 1e400 0\nf 1 2 3\nf\nf 1 2\n")
    points, polygons = read_mesh(path)
    assert not np.isfinite(points).all()
    assert polygons == [[0, 1, 2], [], [0, 1]]


# ---- PLY


def ply_bytes(points, polygons, order="<", kinds=("d", "B", "i"), extra=False):
    """A PLY file; kinds are struct letters of coordinates, list lengths and vertex numbers."""
    names = {
        "f": "float", "d": "double", "b": "char", "B": "uchar", "h": "short", "H": "ushort",
        "i": "int32", "I": "uint32",
    }  # fmt: skip
    formats = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}
    coordinate, length, number = kinds

    def row(letters, values):
        if order == "":
            return (" ".join(map(repr, values)) + "\n").encode()
        return struct.pack(order + letters, *values)

    header = ["ply", f"format {formats[order]} 1.0", "comment made by hand"]
    body = []
    if extra:
        header += ["element junk 2", "property uchar a", "property list ushort double b"]
        body += [row("BHd", (7, 1, 0.5)), row("BHddd", (8, 3, 1.5, 2.5, 3.5))]
    header += [f"element vertex {len(points)}"]
    header += [f"property {names[coordinate]} {axis}" for axis in "xyz"]
    header += ["property uchar red"] if extra else []
    for point in points.tolist():
        body.append(row(coordinate * 3 + "B" * extra, [*point, 255][: 3 + extra]))
    header += [f"element face {len(polygons)}"]
    header += ["property float quality"] if extra else []
    header += [f"property list {names[length]} {names[number]} vertex_indices"]
    header += ["property list uchar float texcoord"] if extra else []
    for n, polygon in enumerate(polygons):
        letters = "f" * extra + length + number * len(polygon) + "Bff" * extra
        values = [0.5] * extra + [len(polygon), *polygon] + [2, 0.25, n] * extra
        body.append(row(letters, values))
    header += ["element edge 1", "property int vertex1", "end_header"]
    body.append(row("i", (0,)))
    return "\n".join(header).encode() + b"\n" + b"".join(body)


@pytest.mark.parametrize("order", ["", "<", ">"])
@pytest.mark.parametrize("extra", [False, True])
@pytest.mark.parametrize("length", "bBhHiI")
@pytest.mark.parametrize("number", "bBhHiI")
def test_ply_of_all_integers(tmp_path, order, extra, length, number):
    content = ply_bytes(POINTS, MIXED, order, ("d", length, number), extra)
    points, polygons = read_mesh(file_with(tmp_path, "a.ply", content))
    assert np.array_equal(points, POINTS)
    assert polygons == MIXED


@pytest.mark.parametrize("order", ["", "<", ">"])
@pytest.mark.parametrize("extra", [False, True])
def test_ply_of_triangles(tmp_path, order, extra):
    triangles = [[0, 1, 2], [0, 2, 3], [3, 2, 5]]
    content = ply_bytes(POINTS[:, :], triangles, order, ("f", "B", "i"), extra)
    points, polygons = read_mesh(file_with(tmp_path, "a.ply", content))
    expected = POINTS if order == "" else POINTS.astype(np.float32)
    assert np.array_equal(points, expected)
    assert isinstance(polygons, np.ndarray) and polygons.tolist() == triangles


def test_ply_with_windows_line_ends(tmp_path):
    content = ply_bytes(POINTS, MIXED, "").replace(b"\n", b"\r\n")
    assert read_mesh(file_with(tmp_path, "a.ply", content))[1] == MIXED
    header, body = ply_bytes(POINTS, MIXED, "<").split(b"end_header\n")
    content = header.replace(b"\n", b"\r\n") + b"end_header\r\n" + body
    assert read_mesh(file_with(tmp_path, "b.ply", content))[1] == MIXED


def test_ply_with_the_older_name_of_the_list(tmp_path):
    content = ply_bytes(POINTS, MIXED).replace(b"vertex_indices", b"vertex_index")
    assert read_mesh(file_with(tmp_path, "a.ply", content))[1] == MIXED


@pytest.mark.parametrize("order", ["", "<", ">"])
def test_truncated_ply(tmp_path, order):
    whole = ply_bytes(POINTS, MIXED, order)
    body = whole.index(b"end_header") + 12
    edge = 2 if order == "" else 4
    for size in (*range(body, len(whole) - edge, 7), body - 15, 60, 10):
        with pytest.raises(InputError):
            read_mesh(file_with(tmp_path, "a.ply", whole[:size]))
    assert "truncated" in refusal(file_with(tmp_path, "a.ply", whole[: body + 40]))


HEADER = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
FACES = "element face 1\nproperty list uchar int vertex_indices\nend_header\n"


@pytest.mark.parametrize(
    "content, expected",
    [
        ("", "is empty"),
        ("solid x\n", "is not a PLY file"),
        ("plyer\n", "is not a PLY file"),
        ("ply\nformat ascii 1.0\n", "truncated"),
        ("ply\nformat utf8 1.0\nend_header\n", "has 'format utf8 1.0' in its header"),
        ("ply\nelement vertex 0\nend_header\n", "does not say its format"),
        ("ply\nformat ascii 1.0\nproperty float x\nend_header\n", "in its header"),
        ("ply\nformat ascii 1.0\nelement vertex -3\nend_header\n", "in its header"),
        ("ply\nformat ascii 1.0\nelement vertex many\nend_header\n", "in its header"),
        ("ply\nformat ascii 1.0\nelement vertex 3\nproperty list float int a\nend_header\n",
         "in its header"),
        ("ply\nformat ascii 1.0\nend_header\n", "has no vertices"),
        (HEADER + FACES + "0 0\n1 0\n0 1\n3 0 1 2\n", "without x, y and z"),
        (HEADER + "property float z\nend_header\n0 0 0 1 0 0 0 1 0\n", "has no faces"),
        (HEADER + "property float z\nelement face 0\nproperty list uchar int vertex_indices\n"
         "end_header\n0 0 0 1 0 0 0 1 0\n", "has no faces"),
        (HEADER + "property float z\nelement face 1\nproperty int a\nend_header\n"
         "0 0 0 1 0 0 0 1 0\n5\n", "without lists"),
        (HEADER + "property float z\n" + FACES + "0 0 0 1 0 0 0 1 0\n3 0 1 3\n", "beyond them"),
        (HEADER + "property float z\n" + FACES + "0 0 0 1 0 0 0 1 0\n3 0 1 -1\n", "beyond them"),
        (HEADER + "property float z\n" + FACES + "0 0 0 1 0 0 0 1 0\n3 0 1 .5\n", "whole number"),
        (HEADER + "property float z\n" + FACES + "0 0 0 1 0 0 0 1 0\n-3 0 1 2\n", "damaged"),
        (HEADER + "property float z\n" + FACES + "0 0 0 1 0 0 0 1 0\nnan 0 1 2\n", "damaged"),
        (HEADER + "property float z\n" + FACES + "0 0 0 1 0 0 0 x 0\n3 0 1 2\n", "damaged"),
        (HEADER.replace(" 3", " 999999999999999") + "property float z\n" + FACES, "truncated"),
        (HEADER.replace("ascii", "binary_little_endian").replace(" 3", " 999999999999999")
         + "property float z\n" + FACES, "truncated"),
        (HEADER + "property float z\nelement face 1\nproperty list uint int vertex_indices\n"
         "end_header\n0 0 0 1 0 0 0 1 0\n4000000000 0 1 2\n", "truncated"),
    ],
)  # fmt: skip
def test_hostile_ply(tmp_path, content, expected):
    assert expected in refusal(file_with(tmp_path, "a.ply", content))


# ---- STL


def corners(triangles):
    return np.asarray(POINTS, np.float32)[np.array(triangles, int).reshape(-1, 3)]


def binary_stl(triangles, start=b"made by hand"):
    content = start.ljust(80, b" ") + struct.pack("<I", len(triangles))
    for corner in corners(triangles):
        content += struct.pack("<12fH", 0, 0, 1, *corner.ravel(), 0)
    return content


def text_stl(triangles):
    lines = ["solid made by hand # 7"]
    for triangle in triangles:
        lines += ["  facet normal 0 0 1", "    outer loop"]
        lines += ["      vertex " + " ".join(map(repr, POINTS[v].tolist())) for v in triangle]
        lines += ["    endloop", "  endfacet"]
    return "\n".join([*lines, "endsolid made by hand"]) + "\n"


TRIANGLES = [[2, 0, 1], [0, 2, 3], [3, 2, 5]]


@pytest.mark.parametrize(
    "content",
    [
        binary_stl(TRIANGLES),
        binary_stl(TRIANGLES, b"solid in spite of being binary"),
        binary_stl(TRIANGLES) + b"more behind",
        text_stl(TRIANGLES),
        text_stl(TRIANGLES).replace("\n", "\r\n"),
        text_stl(TRIANGLES).upper(),
        "\n " + text_stl(TRIANGLES),
    ],
)
def test_stl_is_welded_where_coordinates_are_equal(tmp_path, content):
    points, triangles = read_mesh(file_with(tmp_path, "a.stl", content))
    assert triangles.tolist() == [[0, 1, 2], [1, 0, 3], [3, 0, 4]]
    kind = np.float32 if isinstance(content, bytes) else np.float64
    assert np.array_equal(points, POINTS[[2, 0, 1, 3, 5]].astype(kind))


def test_stl_does_not_weld_what_is_only_near(tmp_path):
    near = np.nextafter(np.float32(1), np.float32(2))
    content = binary_stl([[0, 1, 2], [0, 2, 3]])
    changed = content[:-14] + struct.pack("<f", near) + content[-10:]
    assert len(read_mesh(file_with(tmp_path, "a.stl", content))[0]) == 4
    assert len(read_mesh(file_with(tmp_path, "b.stl", changed))[0]) == 4
    both_zeros = content.replace(struct.pack("<f", 0.0), struct.pack("<f", -0.0), 5)
    assert len(read_mesh(file_with(tmp_path, "c.stl", both_zeros))[0]) == 4


@pytest.mark.parametrize(
    "content, expected",
    [
        ("", "is empty"),
        (b"\x00" * 20, "is not an STL file"),
        ("ply\nformat ascii 1.0\n", "is not an STL file"),
        (binary_stl(TRIANGLES)[:-1], "announces 3 triangles but holds 2"),
        (binary_stl(TRIANGLES)[:90], "announces 3 triangles but holds 0"),
        (b"v 0 0 0\n" * 40, "truncated or not an STL file"),
        (binary_stl([])[:84], "has no faces"),
        ("solid x\nendsolid x\n", "has no faces"),
        (text_stl(TRIANGLES)[:-40], "ends without endsolid"),
        (
            text_stl(TRIANGLES).replace("0.3333333333333333", ""),
            "without three coordinates on line",
        ),
        (text_stl(TRIANGLES).replace("0.3333333333333333", "1/3"), "has '1/3' for a number"),
        (text_stl([[0, 1, 2, 3]]), "triangle without three vertices"),
    ],
)
def test_hostile_stl(tmp_path, content, expected):
    assert expected in refusal(file_with(tmp_path, "a.stl", content))


# ---- All of them


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl"])
def test_files_that_are_not_there(tmp_path, suffix):
    assert "does not exist" in refusal(tmp_path / ("missing" + suffix))
    (tmp_path / ("folder" + suffix)).mkdir()
    assert "is a directory" in refusal(tmp_path / ("folder" + suffix))
    assert "does not exist" in refusal(tmp_path / "missing" / ("a" + suffix))


@pytest.mark.parametrize("name", ["a.txt", "a", "a.gltf", ".obj"])
def test_unknown_formats(tmp_path, name):
    assert "give an .obj, .ply or .stl file" in refusal(file_with(tmp_path, name, TRIANGLE))


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads all")
def test_file_without_permission(tmp_path):
    path = file_with(tmp_path, "a.obj", TRIANGLE)
    path.chmod(0)
    assert "cannot be read" in refusal(path)


def test_name_as_text(tmp_path):
    path = file_with(tmp_path, "a.obj", TRIANGLE + "f 1 2 3\n")
    assert len(read_mesh(str(path))[0]) == 3


@settings(deadline=None, max_examples=120)
@given(st.data())
def test_damaged_files_are_read_or_refused(tmp_path_factory, data):
    name, whole = data.draw(
        st.sampled_from(
            [
                ("a.obj", OBJ_WITH_EVERYTHING.encode()),
                ("a.ply", ply_bytes(POINTS, MIXED, "")),
                ("a.ply", ply_bytes(POINTS, MIXED, ">", extra=True)),
                ("a.stl", binary_stl(TRIANGLES)),
                ("a.stl", text_stl(TRIANGLES).encode()),
            ]
        )
    )
    damaged = bytearray(whole)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.integers(0, 255))
    start = data.draw(st.integers(0, 3))
    path = file_with(tmp_path_factory.mktemp("damaged"), name, bytes(damaged[start:]))
    try:
        points, polygons = read_mesh(path)
    except InputError as error:
        assert "\n" not in str(error)
    else:
        assert points.shape[1] == 3 and len(polygons) > 0


# ---- Writing


def test_quads_come_back_to_the_last_bit(tmp_path):
    points = np.random.default_rng(0).normal(size=(6, 3)) * [1e-9, 1, 1e9]
    quads = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    path = tmp_path / "quads.obj"
    write_quads_obj(path, points, quads)
    again, polygons = read_mesh(path)
    assert np.array_equal(again, points) and np.array_equal(polygons, quads)
    assert "g " not in path.read_text()
    assert [p.name for p in tmp_path.iterdir()] == ["quads.obj"]


def test_each_block_is_a_group(tmp_path):
    quads = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 1, 0]])
    path = tmp_path / "quads.obj"
    write_quads_obj(path, POINTS, quads, np.array([12, 0, 12]))
    lines = [x for x in path.read_text().splitlines() if x[0] in "gf"]
    assert lines == ["g block_0000", "f 2 3 6 5", "g block_0012", "f 1 2 5 4", "f 4 5 2 1"]


def test_older_file_stays_when_writing_fails(tmp_path):
    path = tmp_path / "quads.obj"
    path.write_text("older")
    with pytest.raises(IndexError):
        write_quads_obj(path, POINTS, np.zeros((2, 4), int), np.zeros(0, int)[[1]])
    assert path.read_text() == "older"
    (tmp_path / "folder.obj").mkdir()
    for place in (tmp_path / "missing" / "quads.obj", tmp_path / "folder.obj"):
        with pytest.raises(InputError, match="cannot be written"):
            write_quads_obj(place, POINTS, np.zeros((2, 4), int))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["folder.obj", "quads.obj"]


def test_a_link_is_followed(tmp_path):
    (tmp_path / "folder").mkdir()
    target = tmp_path / "folder" / "target.obj"
    link = tmp_path / "link.obj"
    try:
        link.symlink_to(target)
    except OSError:
        pytest.skip("no links here")
    write_quads_obj(link, POINTS, np.array([[0, 1, 2, 3]]))
    assert link.is_symlink() and target.is_file()
