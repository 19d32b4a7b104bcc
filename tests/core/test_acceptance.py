"""Acceptance on the shared meshes: every promise of the main job, judged by the shared metrics tool.

The folder of meshes lies beside the checkout; without it these tests are skipped.
"""

import importlib.util
import pathlib

import numpy as np
import pytest

from core.blocks.blocks import verify_blocks
from core.files.mesh_files import read_mesh
from core.pipeline import decompose
from core.settings import Settings
from core.surface.boundary import build_loops
from core.surface.surface import build_surface

SHARED = pathlib.Path(__file__).resolve().parents[2].parent / "shared"
PEERS = sorted((SHARED / "meshes" / "peers").glob("*.obj"))
GENERATED = sorted((SHARED / "meshes" / "generated").glob("g_*.obj"))
QUADS = 5000

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not PEERS, reason="the shared meshes are not beside the checkout"),
]


@pytest.fixture(scope="module")
def metrics():
    spec = importlib.util.spec_from_file_location("quadmetrics", SHARED / "tools" / "quadmetrics.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.metrics


def with_boundary():
    meshes = [*PEERS, *GENERATED]
    return [m for m in meshes if m.stem != "g_cad_block"]


@pytest.fixture(scope="module")
def results():
    """Each mesh is decomposed once for all tests."""
    known = {}

    def result(name, **settings):
        key = name, tuple(sorted(settings.items()))
        if key not in known:
            path = next(p for p in [*PEERS, *GENERATED] if p.stem == name)
            points, polygons = read_mesh(path)
            known[key] = points, polygons, decompose(points, polygons, Settings(quad_count=QUADS, **settings))
        return known[key]

    return result


@pytest.mark.parametrize("name", [m.stem for m in with_boundary()])
def test_every_mesh_with_boundary_gives_a_valid_quad_mesh(name, results, metrics):
    points, triangles, result = results(name)
    report = result.report()
    quads = result.quads
    m = metrics(quads.points, quads.quads, (points, np.asarray(triangles)))
    assert m["pct_quads"] == 100 and m["nonmanifold_edges"] == 0
    assert m["euler"] == m["ref_euler"] and m["boundary_loops"] == m["ref_boundary_loops"]
    assert m["components"] == report["input"]["components"]
    assert m["sj_nonpositive"] == 0
    assert m["sj_min"] == pytest.approx(report["quads"]["min_scaled_jacobian"], abs=1e-9)
    assert m["boundary_dev_max_per_edge"] <= 0.25
    assert m["irregular_interior"] == len(report["singularities"])
    assert m["irregular_boundary"] <= 2
    assert m["quads"] == report["quads"]["count"] and abs(m["quads"] / QUADS - 1) <= 0.15
    assert report["index_sum"] == report["expected_index_sum"]
    assert report["blocks"]["conforming"] and m["blocks"] <= report["blocks"]["count"]
    verify_blocks(result.blocks, quads.quads)
    assert _distance_to_boundary(points, triangles, quads) < 1e-9


def _distance_to_boundary(points, triangles, quads):
    """Largest distance of a boundary vertex from the input's boundary, in diagonals."""
    surface = build_surface(points, triangles)
    loops = build_loops(surface)
    own = quads.points[quads.on_boundary]
    nearest = np.full(len(own), np.inf)
    for number in range(surface.loop_count):
        loop = np.full(len(own), number)
        on_loop, _ = loops.point(loop, loops.closest(loop, own))
        nearest = np.minimum(nearest, np.linalg.norm(on_loop - own, axis=1))
    return nearest.max() / surface.diameter


@pytest.mark.parametrize("name", ["plate_25k", "aerofoil_25k", "octant_25k", "halfcyl_25k"])
def test_shape_on_the_inputs_of_the_rivals(name, results):
    _, _, result = results(name)
    assert result.quads.scaled_jacobian.min() >= 0.7
    assert result.quads.scaled_jacobian.mean() >= 0.97


KNOWN = {
    "g_disc": (4, 3), "g_triangle": (1, 3), "g_pentagon": (1, 5), "g_lshape": (0, None),
    "g_sphere_octant": (1, 3), "octant_25k": (1, 3), "halfcyl_25k": (0, None),
    "g_annulus": (0, None),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_singularities(name, results):
    count, valence = KNOWN[name]
    singular = results(name)[2].singularities
    assert len(singular) == count and np.all(singular.valence == valence)


@pytest.mark.parametrize(
    "name, least, most",
    [("g_lshape", 3, 3), ("octant_25k", 3, 3), ("g_sphere_octant", 3, 3), ("halfcyl_25k", 1, 1),
     ("g_annulus", 3, 3), ("plate_25k", 1, 220), ("aerofoil_25k", 1, 180)],
)
def test_known_blocks(name, least, most, results):
    assert least <= results(name)[2].blocks.count <= most


def test_plate_and_aerofoil_have_about_as_many_singularities_as_others_find(results):
    assert 8 <= len(results("plate_25k")[2].singularities) <= 12
    assert 6 <= len(results("aerofoil_25k")[2].singularities) <= 12
