"""Cleaning: any polygons become a surface, each repair counted, with the way back to the user."""

import pathlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cleaning import clean
from core.errors import InputError
from core.surface import build_surface
from tests.core.surfaces import crumpled, lshape, octant, plate_with_holes, sphere, torus

MESHES = pathlib.Path(__file__).resolve().parents[2].parent / "shared" / "meshes"

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def cleaned(points, polygons, **settings):
    """The mesh and its surface, with what is true of every result checked."""
    points = np.array(points, float)
    mesh = clean(points, polygons, **settings)
    assert np.array_equal(mesh.points, points[mesh.vertex_origin])
    assert (np.diff(mesh.vertex_origin) >= 0).all() and (np.diff(mesh.face_origin) >= 0).all()
    assert np.array_equal(np.unique(mesh.triangles), np.arange(len(mesh.points)))
    assert np.array_equal(mesh.weld_target[mesh.vertex_origin], mesh.vertex_origin)
    for sentence in mesh.warnings:
        assert sentence.endswith(".") and "\n" not in sentence
    return mesh, build_surface(mesh.points, mesh.triangles)


def same_surface(one, other):
    """Same topology and the same shape, whatever the numbers."""
    assert one.face_count == other.face_count
    assert one.euler_characteristic == other.euler_characteristic
    assert (one.loop_count, one.component_count) == (other.loop_count, other.component_count)
    assert one.face_area.sum() == pytest.approx(other.face_area.sum())
    assert np.sort(one.edge_length) == pytest.approx(np.sort(other.edge_length))


def test_quads_and_polygons_become_triangles_with_the_way_back():
    points = [*SQUARE, (2, 0, 0), (2, 1, 0), (3, 0.5, 0)]
    mesh = clean(points, [[0, 1, 2, 3], [1, 4, 6, 5, 2]])
    assert mesh.face_origin.tolist() == [0, 0, 1, 1, 1]
    assert mesh.vertex_origin.tolist() == list(range(7))
    assert mesh.warnings == []
    surface = build_surface(mesh.points, mesh.triangles)
    assert surface.face_area.sum() == pytest.approx(2.5)
    assert surface.face_normal[:, 2] == pytest.approx(np.ones(5))


def test_unused_vertices_are_dropped():
    points = [(9, 9, 9), (0, 0, 0), (7, 7, 7), (1, 0, 0), (0, 1, 0)]
    mesh = clean(points, [[1, 3, 4]])
    assert mesh.vertex_origin.tolist() == [1, 3, 4]
    assert mesh.triangles.tolist() == [[0, 1, 2]]
    assert np.array_equal(mesh.points, np.array(points, float)[[1, 3, 4]])
    assert mesh.warnings == ["2 vertices that no face uses were left out."]


def test_coordinates_are_kept_to_the_last_bit():
    points = 1e9 + 1e-7 * np.random.default_rng(1).random((4, 3)) * 1e8
    mesh = clean(points, [[0, 1, 2], [0, 2, 3]])
    assert np.array_equal(mesh.points, points)


@pytest.mark.parametrize("scale", [1e-90, 1e-7, 1e7, 1e90])
def test_scale_does_not_matter(scale):
    surface = octant(4)
    mesh = clean(surface.points * scale, surface.triangles)
    assert len(mesh.triangles) == surface.face_count


@pytest.mark.parametrize("surface", [octant(5), sphere(5), plate_with_holes()])
def test_clean_surfaces_pass_unchanged(surface):
    mesh = clean(surface.points, surface.triangles)
    assert np.array_equal(mesh.triangles, surface.triangles)
    assert np.array_equal(mesh.face_origin, np.arange(surface.face_count))
    assert mesh.warnings == []


def test_input_is_not_changed():
    points, polygons = np.array(SQUARE, float), np.array([[0, 1, 2, 3]])
    mesh = clean(points, polygons)
    mesh.points[0] = 5
    assert points[0, 0] == 0 and polygons.tolist() == [[0, 1, 2, 3]]


def test_random_quads_of_a_crumpled_surface():
    """Pairs of triangles joined to quads, then cut again: as many triangles, same boundary."""
    surface = crumpled(octant(8), 0.5)
    inner = np.flatnonzero(surface.twin > np.arange(len(surface.twin)))
    taken, polygons = set(), []
    for h in inner.tolist():
        f, g = h // 3, int(surface.twin[h]) // 3
        if f not in taken and g not in taken:
            taken |= {f, g}
            apex = [
                surface.triangles[t, (c + 2) % 3] for t, c in ((f, h % 3), (g, surface.twin[h] % 3))
            ]
            polygons.append([surface.tail[h], apex[1], surface.head[h], apex[0]])
    polygons += [surface.triangles[f].tolist() for f in range(surface.face_count) if f not in taken]
    mesh = clean(surface.points, polygons)
    again = build_surface(mesh.points, mesh.triangles)
    assert again.face_count == surface.face_count
    assert again.euler_characteristic == 1
    assert len(again.loop_halfedges) == len(surface.loop_halfedges)


def test_needle_is_no_fault():
    mesh = clean([(0, 0, 0), (1, 0, 0), (0.5, 1e-8, 0)], [[0, 1, 2]])
    assert len(mesh.triangles) == 1


# Welding


def soup(surface):
    return surface.points[surface.triangles].reshape(-1, 3), np.arange(3 * surface.face_count)


@pytest.mark.parametrize("surface", [sphere(4), torus(), octant(5), plate_with_holes()])
@pytest.mark.parametrize("noise", [0, 1e-8])
def test_loose_triangles_are_joined(surface, noise):
    points, number = soup(surface)
    points = points + noise * np.random.default_rng(1).uniform(-1, 1, points.shape)
    mesh, joined = cleaned(points, number.reshape(-1, 3))
    assert joined.face_count == surface.face_count
    assert joined.euler_characteristic == surface.euler_characteristic
    assert joined.loop_count == surface.loop_count
    gone = len(points) - surface.vertex_count
    (sentence,) = mesh.warnings
    assert sentence.startswith(f"{gone:,} vertices were merged into one in the same place")
    # Every vertex of the user goes to one in its place, and that one is in the mesh.
    assert np.abs(points[mesh.weld_target] - points).max() <= 4 * noise
    assert np.isin(mesh.weld_target, mesh.vertex_origin).all()


def test_loose_faces_beside_a_joined_mesh():
    whole, loose = octant(4), sphere(3)
    points, number = soup(loose)
    points = np.concatenate([whole.points + [3, 0, 0], points])
    faces = np.concatenate([whole.triangles, number.reshape(-1, 3) + whole.vertex_count])
    _, surface = cleaned(points, faces)
    assert (surface.component_count, surface.loop_count) == (2, 1)


def test_sheets_that_touch_are_not_joined_unasked():
    points = np.array([*SQUARE, *SQUARE], float)
    points[4:, 0] += 1
    points = np.concatenate([points, [(0.5, 2, 0), (1.5, 2, 0)]])
    faces = [[0, 1, 2, 3], [4, 5, 6, 7], [3, 2, 8], [7, 6, 9]]
    mesh, surface = cleaned(points, faces)
    assert surface.component_count == 2 and len(mesh.warnings) == 1
    mesh, surface = cleaned(points, faces, weld_distance=1e-3)
    assert surface.component_count == 1
    assert mesh.warnings == ["2 vertices were merged into one within the welding distance."]
    assert mesh.weld_target.tolist() == [0, 1, 2, 3, 1, 5, 6, 2, 8, 9]


def test_welding_distance_is_in_the_users_lengths():
    gap = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1.01, 0, 0), (0.01, 1, 0), (1, 1, 0)]
    faces = [[0, 1, 2], [3, 5, 4]]
    for scale in (1e-7, 1, 1e7):
        points = scale * np.array(gap) + 3 * scale
        assert cleaned(points, faces, weld_distance=0.02 * scale)[1].component_count == 1
        assert cleaned(points, faces, weld_distance=0.002 * scale)[1].component_count == 2


def test_welding_everything_is_refused():
    surface = octant(12)
    with pytest.raises(InputError, match="no area"):
        clean(surface.points, surface.triangles, weld_distance=10)


def test_edges_without_length_are_closed():
    points = [*SQUARE, (1, 0, 0), (2, 0, 0), (2, 1, 0)]
    # Vertex 4 lies on vertex 1; the two are the ends of an edge.
    mesh, surface = cleaned(points, [[0, 1, 4, 2, 3], [4, 5, 6, 2]])
    assert surface.component_count == 1 and surface.face_count == 4
    assert mesh.weld_target[4] == 1
    assert "end of an edge without length" in mesh.warnings[0]


# Faces that are no faces


def test_repeated_corners_are_removed():
    mesh, surface = cleaned(SQUARE, [[0, 1, 1, 2, 2, 2, 3, 0]])
    assert surface.face_count == 2
    assert mesh.warnings == ["1 face lost corners that it passed twice."]


def test_spikes_are_removed():
    points = [*SQUARE, (5, 5, 0), (6, 6, 0)]
    _, surface = cleaned(points, [[0, 1, 2, 4, 5, 4, 2, 3]])
    assert surface.face_area.sum() == pytest.approx(1)


def test_bridge_to_a_hole():
    """A polygon that walks to the hole in its middle, round it and back on the same bridge."""
    hole = [(1, 1, 0), (1, 2, 0), (2, 2, 0), (2, 1, 0)]
    points = [*(3 * np.array(SQUARE)), *hole]
    _, surface = cleaned(points, [[0, 1, 2, 3, 0, 4, 5, 6, 7, 4]])
    assert surface.face_area.sum() == pytest.approx(8)
    assert (surface.euler_characteristic, surface.loop_count) == (0, 2)
    assert surface.face_normal[:, 2] == pytest.approx(np.ones(surface.face_count))


@pytest.mark.parametrize("again", [[0, 1, 2], [1, 2, 0], [2, 1, 0]])
def test_repeated_faces_are_left_out(again):
    mesh, surface = cleaned(SQUARE, [[0, 1, 2], [0, 2, 3], again])
    assert mesh.face_origin.tolist() == [0, 1]
    assert mesh.warnings == ["1 repeated face was left out."]
    assert surface.component_count == 1


def test_faces_of_one_or_two_corners_are_left_out():
    mesh, _ = cleaned(SQUARE, [[0], [0, 1, 2], [], [2, 3], [0, 2, 3], [1, 1, 2]])
    assert mesh.face_origin.tolist() == [1, 4]
    assert mesh.warnings == ["4 faces with fewer than three different corners were left out."]


@pytest.mark.parametrize(
    "points, polygon",
    [
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [0, 1, 2]),
        ([(0, 0, 0), (0, 0, 0), (1, 0, 0)], [0, 1, 2]),
        ([(1, 1, 1)] * 3, [0, 1, 2]),
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)], [0, 1, 2, 3]),
    ],
)
def test_faces_without_area_are_left_out(points, polygon):
    good = [(5, 0, 0), (6, 0, 0), (5, 1, 0)]
    mesh, _ = cleaned(good + points, [[0, 1, 2], [v + 3 for v in polygon]])
    assert mesh.face_origin.tolist() == [0]
    with pytest.raises(InputError, match="no area"):
        clean(points, [polygon])


def test_flat_face_between_others_leaves_no_slit():
    """A corner in the middle of a neighbour's edge, with a flat triangle to fill the crack."""
    points = [(0, 0, 0), (2, 0, 0), (1, -1, 0), (1, 0, 0), (1, 1, 0)]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 4], [3, 1, 4]]
    mesh, surface = cleaned(points, faces)
    assert (surface.component_count, surface.loop_count) == (1, 1)
    assert surface.face_area.sum() == pytest.approx(2)
    assert mesh.face_origin.tolist() == [0, 0, 2, 3]
    assert mesh.warnings == ["1 face without area was left out."]


def test_row_of_flat_faces_between_others():
    k = 7
    line = [(x / k, 0, 0) for x in range(k + 1)]
    points = [*line, (0.5, 1, 0), (0.5, -1, 0)]
    upper = [[x, x + 1, k + 1] for x in range(k)]
    flat = [[0, x + 1, x] for x in range(1, k)]
    _, surface = cleaned(points, [*upper, *flat, [0, k + 2, k]])
    assert (surface.component_count, surface.loop_count) == (1, 1)
    assert surface.face_area.sum() == pytest.approx(1)


# Cutting apart


def test_edge_of_three_faces_is_cut():
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0.1), (0, 0, 1)]
    mesh, surface = cleaned(points, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    assert surface.component_count == 2 and surface.loop_count == 2
    # The pair that bends least stays together.
    assert surface.component.tolist() == [0, 0, 1]
    assert mesh.vertex_origin.tolist() == [0, 0, 1, 1, 2, 3, 4]
    assert mesh.warnings == ["The surface was cut apart along 1 edge of more than two faces."]


def box(corner):
    x, y, z = np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")
    points = np.c_[x.ravel(), y.ravel(), z.ravel()] + np.array(corner)
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    return points.astype(float), quads


def merged(parts):
    points = np.concatenate([p for p, _ in parts])
    offset = np.cumsum([0] + [len(p) for p, _ in parts])
    quads = np.concatenate([q + o for (_, q), o in zip(parts, offset)])
    points, number = np.unique(points, axis=0, return_inverse=True)
    return points, number.ravel()[quads]


@pytest.mark.parametrize("corners", [[(0, 0, 0), (1, 1, 0)], [(1, 0, 0), (0, 1, 0), (5, 5, 5)]])
def test_boxes_that_share_an_edge_become_closed_boxes(corners):
    mesh, surface = cleaned(*merged([box(c) for c in corners]))
    assert surface.component_count == len(corners) and surface.loop_count == 0
    assert surface.euler_characteristic == 2 * len(corners)
    assert mesh.warnings == ["The surface was cut apart along 1 edge of more than two faces."]
    centre = surface.points[surface.triangles].mean(1)
    for k in range(len(corners)):
        own = surface.component == k
        out = centre[own] - centre[own].mean(0)
        assert (out * surface.face_normal[own]).sum(1).min() > 0


def test_boxes_that_share_a_corner():
    mesh, surface = cleaned(*merged([box((0, 0, 0)), box((1, 1, 1))]))
    assert surface.component_count == 2 and surface.loop_count == 0
    assert mesh.warnings == ["1 vertex in which parts of the surface only touched was split."]


def test_crossing_planes_stay_planes():
    """Two planes that cross along a row of edges: each stays in one piece, and flat."""
    n = 6
    grid = np.stack(np.meshgrid(np.arange(n + 1), np.arange(-3, 4), indexing="ij"), -1)
    flat = np.c_[grid.reshape(-1, 2), np.zeros(7 * (n + 1))]
    number = np.arange(7 * (n + 1)).reshape(n + 1, 7)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], -1)
    upright = flat[:, [0, 2, 1]]
    _, surface = cleaned(*merged([(flat, quads.reshape(-1, 4)), (upright, quads.reshape(-1, 4))]))
    assert (surface.component_count, surface.loop_count) == (2, 2)
    for k in range(2):
        normal = surface.face_normal[surface.component == k]
        assert normal == pytest.approx(np.broadcast_to(normal[0], normal.shape))


@pytest.mark.parametrize("sheets", [3, 4, 5, 40])
def test_sheets_that_meet_in_a_line(sheets):
    points, quads = [(0, 0, z) for z in range(6)], []
    for k in range(sheets):
        x, y = np.cos(2 * np.pi * k / sheets), np.sin(2 * np.pi * k / sheets)
        first = len(points)
        points += [(x, y, z) for z in range(6)]
        quads += [[z, first + z, first + z + 1, z + 1] for z in range(5)]
    _, surface = cleaned(points, quads)
    assert surface.face_count == 10 * sheets
    pieces = (sheets + 1) // 2 if sheets < 30 else sheets
    assert surface.component_count == pieces == surface.loop_count


# Orientation


@pytest.mark.parametrize("surface", [sphere(5), torus(), octant(6), plate_with_holes()])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_mixed_orientation_is_made_one(surface, share):
    turned = np.random.default_rng(2).random(surface.face_count) < share
    faces = np.where(turned[:, None], surface.triangles[:, ::-1], surface.triangles)
    mesh, again = cleaned(surface.points, faces)
    same_surface(again, surface)
    outward = surface.loop_count == 0 or turned.sum() < 0.45 * surface.face_count
    if outward:
        assert np.array_equal(np.sort(mesh.triangles), np.sort(surface.triangles))
        assert (again.face_normal * surface.face_normal).sum(1).min() > 0.99
        assert mesh.warnings[0].startswith(f"{turned.sum():,} faces were turned over so that")


def test_a_surface_turned_inside_out_is_the_users_wish():
    surface = sphere(3)
    mesh, _ = cleaned(surface.points, surface.triangles[:, ::-1])
    assert np.array_equal(mesh.triangles, surface.triangles[:, ::-1])


def strip_of_half_turns(around, across, turns):
    """A band with so many half turns: a Möbius band where they are odd."""
    u = 2 * np.pi * np.arange(around) / around
    v = np.linspace(-0.3, 0.3, across + 1)
    tilt = 0.5 * turns * u
    radius = 1 + v[None] * np.cos(tilt)[:, None]
    points = np.stack(
        [
            radius * np.cos(u)[:, None],
            radius * np.sin(u)[:, None],
            np.broadcast_to(v * np.sin(tilt)[:, None], radius.shape),
        ],
        -1,
    )
    quads = []
    for i in range(around):
        for j in range(across):
            row, last = i * (across + 1), i == around - 1
            a, b = row + j, row + j + 1
            flip = last and turns % 2
            c = (across - j if flip else j) if last else a + across + 1
            d = (across - j - 1 if flip else j + 1) if last else b + across + 1
            quads.append([a, b, d, c])
    return points.reshape(-1, 3), quads


@pytest.mark.parametrize("around, across", [(12, 1), (30, 4), (40, 9)])
def test_moebius_band_is_cut_across(around, across):
    points, quads = strip_of_half_turns(around, across, 1)
    mesh, surface = cleaned(points, quads)
    assert (surface.euler_characteristic, surface.loop_count) == (1, 1)
    assert surface.face_count == 2 * len(quads)
    across = f"{across} edge" + "s" * (across > 1)
    assert f"The one-sided surface was cut open along {across}." in mesh.warnings
    assert cleaned(*strip_of_half_turns(30, 4, 2))[1].euler_characteristic == 0


def test_klein_bottle_is_cut():
    """The torus with its ends glued the other way round: closed and one-sided."""
    m, n = 16, 10
    u, v = np.meshgrid(np.arange(m), np.arange(n), indexing="ij")
    a, b = 2 * np.pi * u / m, 2 * np.pi * v / n
    points = np.stack(
        [
            (2 + np.cos(a / 2) * np.sin(b) - np.sin(a / 2) * np.sin(2 * b)) * np.cos(a),
            (2 + np.cos(a / 2) * np.sin(b) - np.sin(a / 2) * np.sin(2 * b)) * np.sin(a),
            np.sin(a / 2) * np.sin(b) + np.cos(a / 2) * np.sin(2 * b),
        ],
        -1,
    ).reshape(-1, 3)
    number = lambda i, j: i * n + j % n if i < m else (-j) % n
    quads = [
        [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)]
        for i in range(m)
        for j in range(n)
    ]
    _, surface = cleaned(points, quads)
    assert surface.face_count == 2 * m * n
    assert surface.component_count == 1 and surface.loop_count >= 1


def test_projective_plane_of_six_vertices():
    faces = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5), (0, 5, 1)]
    faces += [(1, 2, 4), (2, 3, 5), (3, 4, 1), (4, 5, 2), (5, 1, 3)]
    points = np.random.default_rng(5).random((6, 3))
    _, surface = cleaned(points, faces)
    assert surface.face_count == 10 and surface.component_count == 1
    assert (surface.euler_characteristic, surface.loop_count) == (1, 1)


def test_moebius_bands_joined_with_holes_and_others():
    band, quads = strip_of_half_turns(24, 5, 1)
    quads = [q for k, q in enumerate(quads) if k not in (22, 57)]
    _, surface = cleaned(band, quads)
    assert surface.component_count == 1
    two = np.concatenate([band, band + [4, 0, 0]])
    _, surface = cleaned(two, quads + [[v + len(band) for v in q] for q in quads])
    assert surface.component_count == 2


# The way back


def test_edges_are_found_again():
    surface = lshape(3)
    edge = np.stack([surface.tail, surface.head], 1)[::5]
    mesh, again = cleaned(surface.points, surface.triangles)
    found = mesh.find_edges(edge[:, ::-1])
    ends = np.sort(np.stack([again.tail, again.head], 1), axis=1)
    assert np.array_equal(ends[found >= 0], np.sort(edge, axis=1)[found[found >= 0]])
    assert len(np.unique(found[found >= 0])) == len(np.unique(np.sort(edge, axis=1), axis=0))
    assert (mesh.find_edges(np.zeros((0, 2), int)) == -1).all()


def test_edges_are_found_after_welding_and_cutting():
    points, number = soup(octant(3))
    mesh, surface = cleaned(points, number.reshape(-1, 3))
    found = mesh.find_edges([[4, 5]])
    assert np.count_nonzero(found == 0) in (1, 2)
    ends = surface.points[[surface.tail[found == 0][0], surface.head[found == 0][0]]]
    assert np.abs(np.sort(ends, 0) - np.sort(points[4:6], 0)).max() == 0
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)]
    mesh, _ = cleaned(points, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    assert np.count_nonzero(mesh.find_edges([[1, 0]]) == 0) == 3


# Anything at all


@st.composite
def broken_meshes(draw):
    """A surface, with random faults of all kinds put in."""
    random = np.random.default_rng(draw(st.integers(0, 10**6)))
    surface = draw(st.sampled_from([octant(4), sphere(3), lshape(2), torus(6, 5)]))
    points, faces = surface.points, surface.triangles.tolist()
    pick = lambda n: random.choice(len(faces), n, replace=False).tolist()
    for fault in draw(st.lists(st.sampled_from(["turn", "repeat", "drop", "flat", "weld", "fin", "loose", "unused"]))):
        if fault == "turn":
            faces = [f[::-1] if random.random() < 0.3 else f for f in faces]
        elif fault == "repeat":
            faces += [np.roll(faces[k], 1).tolist() for k in pick(3)]
        elif fault == "drop":
            faces = np.delete(np.array(faces), pick(2), 0).tolist()
        elif fault == "flat":
            faces += [[f[0], f[1], f[0]] for f in (faces[k] for k in pick(2))]
            f = faces[pick(1)[0]]
            points = np.concatenate([points, [points[f[:2]].mean(0)]])
            faces.append([f[0], f[1], len(points) - 1])
        elif fault == "weld":
            one, two = random.choice(np.unique(faces), 2, replace=False)
            faces = [[one if v == two else v for v in f] for f in faces]
        elif fault == "fin":
            f = faces[pick(1)[0]]
            points = np.concatenate([points, [points[f[0]] + random.random(3)]])
            faces.append([f[1], f[0], len(points) - 1])
        elif fault == "loose":
            k = pick(3)
            new = np.array([faces[n] for n in k])
            points = np.concatenate([points, points[new].reshape(-1, 3)])
            for row, n in enumerate(k):
                faces[n] = [len(points) - 9 + 3 * row + c for c in range(3)]
        else:
            points = np.concatenate([points, np.full((1, 3), np.nan), random.random((1, 3))])
    return points, faces, random


@settings(deadline=None, max_examples=120, derandomize=True)
@given(broken_meshes())
def test_broken_meshes_become_surfaces(broken):
    points, faces, random = broken
    mesh = clean(points, faces)
    surface = build_surface(mesh.points, mesh.triangles)
    assert np.array_equal(mesh.points, points[mesh.vertex_origin])
    # A face of the result is the face of the user that it says it comes from.
    corner = np.sort(mesh.vertex_origin[mesh.triangles], axis=1)
    target = mesh.weld_target[np.array(faces)[mesh.face_origin]]
    kept = (corner == np.sort(target, axis=1)).all(1)
    assert kept.mean() > 0.5
    # A clean mesh has nothing left to repair.
    again = clean(mesh.points, mesh.triangles, repair=False)
    assert np.array_equal(again.triangles, mesh.triangles)
    # New numbers for vertices and faces: the same surface.
    vertex, face = random.permutation(len(points)), random.permutation(len(faces))
    renumbered = np.argsort(vertex)[np.array(faces)[face]]
    other = clean(points[vertex], renumbered)
    same = build_surface(other.points, other.triangles)
    assert same.face_count == surface.face_count
    assert same.face_area.sum() == pytest.approx(surface.face_area.sum())


@settings(deadline=None, max_examples=200, derandomize=True)
@given(st.data())
def test_any_polygons_become_a_surface_or_have_no_area(data):
    count = data.draw(st.integers(3, 9))
    coordinate = st.sampled_from([0.0, 1.0, 2.0, 0.5, -1.0, 1e-300, 1e9])
    points = data.draw(
        st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=count, max_size=count)
        | st.just(np.random.default_rng(count).random((count, 3)).tolist())
    )
    polygons = data.draw(
        st.lists(st.lists(st.integers(0, count - 1), min_size=0, max_size=7), max_size=8)
    )
    try:
        cleaned(points, polygons)
    except InputError as error:
        assert "no faces" in str(error) or "no area" in str(error)


@pytest.mark.skipif(not MESHES.is_dir(), reason="the shared meshes are not here")
def test_shared_meshes_all_become_surfaces():
    from core.mesh_files import read_mesh

    seen = 0
    for path in sorted(MESHES.glob("*/*.obj")):
        _, surface = cleaned(*read_mesh(path))
        assert surface.face_count > 0
        seen += 1
    assert seen > 40
