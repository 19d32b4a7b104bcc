"""What cannot be used, or shall not be repaired, is refused in the user's numbers."""

import pathlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cleaning.cleaning import clean
from core.errors import InputError
from core.surface.surface import build_surface

MESHES = pathlib.Path(__file__).resolve().parents[3].parent / "shared" / "meshes"

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def refusal(points, polygons):
    with pytest.raises(InputError) as caught:
        clean(points, polygons, repair=False)
    message = str(caught.value)
    assert "\n" not in message
    assert message.endswith(".") and ". " not in message
    return message


def test_soup_stays_one_without_repair():
    points = np.array([*SQUARE[:3], SQUARE[0], *SQUARE[2:]], float)
    mesh = clean(points, [[0, 1, 2], [3, 4, 5]], repair=False)
    assert len(mesh.warnings) == 1 and "2 vertices lie exactly on another one" in mesh.warnings[0]


@pytest.mark.parametrize(
    "points, polygons",
    [([], []), (SQUARE, []), (np.zeros((0, 3)), np.zeros((0, 3), int)), (SQUARE, np.zeros((0, 4)))],
)
def test_empty_mesh(points, polygons):
    assert refusal(points, polygons).startswith("The mesh has no faces")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e200])
def test_coordinates_that_are_no_numbers(value):
    points = np.array(SQUARE, float)
    points[2, 1] = points[3, 0] = value
    assert refusal(points, [[0, 1, 2, 3]]).startswith("Vertex 2 (and 1 more) lies at (1, ")


@pytest.mark.parametrize("points", [[(0, 0), (1, 0), (0, 1)], [1, 2, 3], [("a", "b", "c")], [None]])
def test_vertices_that_are_no_points(points):
    assert refusal(points, [[0, 1, 2]]).startswith("The vertices")


@pytest.mark.parametrize("wrong", [-1, 4, 10**12])
def test_vertex_number_out_of_range(wrong):
    message = refusal(SQUARE, [[0, 1, 2], [0, 2, wrong]])
    assert message.startswith(f"Polygon 1 refers to vertex {wrong}, but the mesh has 4 vertices")


def test_polygons_with_too_few_corners():
    assert refusal(SQUARE, [[0, 1, 2], [0, 1]]).startswith("Polygon 1 has fewer than three")
    assert refusal(SQUARE, [[], [0, 1, 2]]).startswith("Polygon 0 has fewer than three")


def test_polygon_that_passes_a_vertex_twice():
    assert refusal(SQUARE, [[0, 1, 2], [2, 3, 0, 3]]).startswith("Polygon 1 passes vertex 3 twice")


@pytest.mark.parametrize("again", [[0, 1, 2], [1, 2, 0], [2, 1, 0]])
def test_repeated_faces(again):
    message = refusal(SQUARE, [[0, 1, 2], [0, 2, 3], again])
    assert message.startswith("Polygon 2 has the same corners as polygon 0")


def test_edge_of_three_faces():
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)]
    message = refusal(points, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    assert message.startswith(
        "The edge between vertices 0 and 1 belongs to 3 polygons (0, 1 and 2)"
    )


def test_vertex_where_parts_only_touch():
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (-1, 0, 0), (-1, -1, 0)]
    assert refusal(points, [[0, 1, 2], [0, 3, 4]]).startswith("Vertex 0 joins parts")


def test_two_closed_cones_that_touch():
    upper = [(0, 1, 2), (0, 2, 3), (0, 3, 1), (2, 1, 3)]
    lower = [(0, 4, 5), (0, 5, 6), (0, 6, 4), (5, 4, 6)]
    ring = [(1, 0, 1), (-1, 1, 1), (-1, -1, 1)]
    points = [(0, 0, 0), *ring, *[(x, y, -1) for x, y, _ in ring]]
    assert refusal(points, upper + lower).startswith("Vertex 0 joins parts")


def test_neighbours_that_disagree():
    message = refusal(SQUARE, [[0, 1, 2], [0, 3, 2]])
    assert message.startswith("Polygons 0 and 1 disagree on which side is outside")
    assert "between vertices 0 and 2;" in message


def test_moebius_band():
    n = 12
    angle = 2 * np.pi * np.arange(n) / n
    centre = np.c_[np.cos(angle), np.sin(angle), 0 * angle]
    offset = (
        0.3
        * np.c_[
            np.cos(angle) * np.cos(angle / 2), np.sin(angle) * np.cos(angle / 2), np.sin(angle / 2)
        ]
    )
    points = np.concatenate([centre + offset, centre - offset])
    quads = [[i, i + 1, n + i + 1, n + i] for i in range(n - 1)] + [[n - 1, n, 0, 2 * n - 1]]
    assert refusal(points, quads).startswith("The surface is one-sided, like a Möbius band")


@pytest.mark.parametrize(
    "points, polygon",
    [
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [0, 1, 2]),
        ([(0, 0, 0), (0, 0, 0), (1, 0, 0)], [0, 1, 2]),
        ([(1, 1, 1)] * 3, [0, 1, 2]),
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)], [0, 1, 2, 3]),
        ([(0, 0, 0), (1, 0, 0), (1, 0, 0), (0, 1, 0)], [0, 1, 2, 3]),
    ],
)
def test_faces_without_area(points, polygon):
    good = [(5, 0, 0), (6, 0, 0), (5, 1, 0)]
    message = refusal(good + points, [[0, 1, 2], [v + 3 for v in polygon]])
    assert message.startswith("Polygon 1 has no area between its vertices")


def test_places_are_in_the_users_numbers_in_spite_of_unused_vertices():
    points = [(9, 9, 9)] * 4 + [(0, 0, 0), (1, 0, 0), (2, 0, 0)]
    assert "vertices 4, 5 and 6" in refusal(points, [[4, 5, 6]])


@settings(deadline=None, max_examples=150)
@given(st.data())
def test_any_input_is_refused_or_becomes_a_surface(data):
    count = data.draw(st.integers(3, 9))
    coordinate = st.sampled_from([0.0, 1.0, 2.0, 0.5, -1.0, np.nan, 1e300, 1e-300])
    points = data.draw(
        st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=count, max_size=count)
        | st.just(np.random.default_rng(count).random((count, 3)).tolist())
    )
    polygons = data.draw(
        st.lists(st.lists(st.integers(0, count - 1), min_size=2, max_size=7), max_size=6)
    )
    try:
        mesh = clean(points, polygons, repair=False)
    except InputError:
        return
    surface = build_surface(mesh.points, mesh.triangles)
    assert surface.face_count == sum(len(p) - 2 for p in polygons)
    assert np.array_equal(mesh.points, np.array(points)[mesh.vertex_origin])


REFUSED = {
    "u_degenerate_dup_isolated": "twice",
    "u_mixed_orientation": "disagree",
    "u_three_sheets": "belongs to 3 polygons",
    "fan3_nonmanifold_edge": "belongs to 3 polygons",
    "triple_vierbein_nonmanifold": "belongs to 3 polygons",
    "hourglass_nonmanifold_vertex": "Vertex 22 joins parts",
    "moebius": "one-sided",
}


@pytest.mark.skipif(not MESHES.is_dir(), reason="the shared meshes are not here")
def test_shared_meshes():
    from core.files.mesh_files import read_mesh

    seen = 0
    for path in sorted(MESHES.glob("*/*.obj")):
        points, polygons = read_mesh(path)
        if path.stem in REFUSED:
            assert REFUSED[path.stem] in refusal(points, polygons)
        else:
            mesh = clean(points, polygons, repair=False)
            build_surface(mesh.points, mesh.triangles)
        seen += 1
    assert seen > 40
