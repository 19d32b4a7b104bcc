"""Cleaning: any polygons become a surface, with the way back to the user."""

import pathlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.cleaning.cleaning import clean
from core.errors import InputError
from core.surface.surface import build_surface
from tests.core.cleaned import SQUARE, cleaned, soup
from tests.core.surfaces import crumpled, lshape, octant, plate_with_holes, sphere, torus

MESHES = pathlib.Path(__file__).resolve().parents[3].parent / "shared" / "meshes"


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
    from core.files.mesh_files import read_mesh

    seen = 0
    for path in sorted(MESHES.glob("*/*.obj")):
        _, surface = cleaned(*read_mesh(path))
        assert surface.face_count > 0
        seen += 1
    assert seen > 40
