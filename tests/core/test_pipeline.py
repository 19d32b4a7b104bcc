"""decompose() end to end on own surfaces: what every result must satisfy."""

import json

import numpy as np
import pytest

from core.blocks.blocks import verify_blocks
from core.errors import Cancelled, InputError
from core.pipeline import decompose
from core.settings import Settings
from core.surface.boundary import build_loops
from tests.core import surfaces

MAKERS = {
    "disc": lambda: surfaces.disc(9),
    "lshape": lambda: surfaces.lshape(8),
    "octant": lambda: surfaces.octant(12),
    "annulus": lambda: surfaces.annulus(36, 8),
    "holes": lambda: surfaces.plate_with_holes(24),
    "half cylinder": lambda: surfaces.cylinder(20, 16, share=0.5),
    "two": lambda: surfaces.together(surfaces.disc(8), surfaces.lshape(6)),
}


def run(name, **settings):
    surface = MAKERS[name]()
    return surface, decompose(surface.points, surface.triangles, Settings(**settings))


@pytest.mark.parametrize("relaxation", ["none", "harmonic", "diffused"])
@pytest.mark.parametrize("name", MAKERS)
def test_every_result_is_a_conforming_quad_mesh_of_the_same_topology(name, relaxation):
    surface, result = run(name, quad_count=900, relaxation=relaxation)
    quads = result.quads.quads
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], 2).reshape(-1, 2), axis=1)
    edge, count = np.unique(edges, axis=0, return_counts=True)
    assert count.max() == 2
    assert len(result.quads.points) - len(edge) + len(quads) == surface.euler_characteristic
    boundary = np.unique(edge[count == 1])
    assert np.array_equal(boundary, np.flatnonzero(result.quads.on_boundary))
    assert np.count_nonzero(count == 1) == len(boundary)
    inside = ~result.quads.on_boundary
    irregular = result.quads.valence[inside & (result.quads.valence != 4)]
    assert sorted(irregular) == sorted(result.singularities.valence)
    assert result.singularities.index_sum == result.singularities.expected_index_sum
    assert result.quads.scaled_jacobian.min() > 0
    assert abs(len(quads) / 900 - 1) < 0.15
    verify_blocks(result.blocks, quads)


@pytest.mark.parametrize("name", MAKERS)
def test_boundary_vertices_lie_on_the_input_boundary(name):
    surface, result = run(name, quad_count=600)
    loops = build_loops(surface)
    points = result.quads.points[result.quads.on_boundary]
    nearest = np.full(len(points), np.inf)
    for loop in range(surface.loop_count):
        position = loops.closest(np.full(len(points), loop), points)
        on_loop, _ = loops.point(np.full(len(points), loop), position)
        nearest = np.minimum(nearest, np.linalg.norm(on_loop - points, axis=1))
    assert nearest.max() < 1e-9 * surface.diameter


@pytest.mark.parametrize(
    "name, singular, blocks",
    [("disc", 4, None), ("lshape", 0, 3), ("octant", 1, 3), ("annulus", 0, 3), ("half cylinder", 0, 1)],
)
def test_known_answers(name, singular, blocks):
    _, result = run(name, quad_count=800)
    assert len(result.singularities) == singular
    assert np.all(result.singularities.valence == 3)
    assert blocks is None or result.blocks.count == blocks


def test_full_streamlines_give_a_conforming_mesh_too():
    surface, result = run("holes", quad_count=3000, lines="full")
    assert result.quads.scaled_jacobian.min() > 0
    verify_blocks(result.blocks, result.quads.quads)


def test_an_edge_length_is_met_on_average():
    surface, result = run("octant", edge_length=0.08)
    points, quads = result.quads.points, result.quads.quads
    edge = np.linalg.norm(points[quads] - points[np.roll(quads, -1, axis=1)], axis=2)
    assert edge.mean() == pytest.approx(0.08, rel=0.1)


def test_scale_and_place_do_not_matter():
    surface, first = run("holes", quad_count=900)
    moved = decompose(surface.points * 1e-5 + 40.0, surface.triangles, Settings(quad_count=900))
    assert moved.blocks.count == first.blocks.count
    assert len(moved.singularities) == len(first.singularities)
    assert moved.quads.scaled_jacobian.min() == pytest.approx(
        first.quads.scaled_jacobian.min(), abs=0.05
    )


def test_stages_can_be_had_alone():
    _, field = run("holes", stop_after="field")
    assert field.complex is None and field.quads is None and np.all(field.polygon_block == -1)
    _, lines = run("holes", stop_after="lines")
    assert lines.complex.cell_count > 10 and lines.blocks is None
    assert "four-sided cells" in lines.sentence() and "as topology asks" in field.sentence()


def test_polygons_know_their_singularity_and_their_block():
    surface, result = run("octant", quad_count=800)
    assert np.count_nonzero(result.polygon_index) == 1 and result.polygon_index.sum() == -1
    assert result.polygon_block.min() >= 0
    centre = surface.points[surface.triangles].mean(1)
    middle = result.quads.points[result.quads.quads].mean(1)
    nearest = np.linalg.norm(centre[:, None] - middle, axis=2).argmin(1)
    agree = result.blocks.quad_block[nearest] == result.polygon_block
    assert agree.mean() > 0.9


def test_the_report_is_json_of_the_agreed_shape():
    surface, result = run("holes", quad_count=900)
    report = json.loads(json.dumps(result.report()))
    assert report["input"] == {
        "vertices": surface.vertex_count, "triangles": surface.face_count,
        "euler_characteristic": -4, "boundary_loops": 6, "components": 1,
    }
    assert report["index_sum"] == report["expected_index_sum"] == -16
    assert report["singularities"] == []
    assert report["blocks"]["conforming"] is True and report["blocks"]["count"] > 20
    assert report["quads"]["count"] == len(result.quads.quads)
    assert report["seconds"]["total"] >= report["seconds"]["quads"] > 0
    assert isinstance(report["warnings"], list)


def test_the_report_lists_the_singularities():
    surface, result = run("disc", quad_count=300)
    listed = result.report()["singularities"]
    assert [(s["k"], s["valence"]) for s in listed] == [(-1, 3)] * 4
    assert all(np.linalg.norm(s["position"]) < 1 and len(s["position"]) == 3 for s in listed)


def test_singularities_are_shown_where_the_quads_have_them():
    surface, result = run("disc", quad_count=300)
    position, valence = result.singular_points()
    assert np.all(valence == 3) and len(position) == 4
    distance = np.linalg.norm(position[:, None] - result.quads.points, axis=2)
    assert distance.min(1).max() == 0
    assert np.all(result.quads.valence[distance.argmin(1)] == 3)
    _, field = run("disc", stop_after="field")
    assert np.array_equal(field.singular_points()[0], field.singularities.position)


def test_quads_as_input_give_what_triangles_give():
    columns = 20
    i, j = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(columns)))
    first = j * (columns + 1) + i
    quads = np.stack([first, first + 1, first + columns + 2, first + columns + 1], 1)
    y, x = np.divmod(np.arange((columns + 1) ** 2), columns + 1)
    result = decompose(np.stack([x, y, 0 * x], 1) / columns, quads, Settings(quad_count=400))
    assert result.blocks.count == 1 and len(result.quads.quads) == 400
    assert len(result.polygon_block) == len(quads)
    assert result.quads.scaled_jacobian.min() == pytest.approx(1.0, abs=1e-6)


def test_progress_rises_to_one():
    surface = MAKERS["octant"]()
    seen = []
    decompose(surface.points, surface.triangles, progress=lambda f, name: seen.append((f, name)))
    fractions = [f for f, _ in seen]
    assert fractions == sorted(fractions) and fractions[-1] == 1.0
    assert {"relaxation", "lines", "quads", "blocks"} <= {name for _, name in seen}


@pytest.mark.parametrize("patience", [0, 3, 12, 25])
def test_cancelling_at_any_time_raises(patience):
    surface = MAKERS["holes"]()
    asked = iter(range(10_000))
    with pytest.raises(Cancelled):
        decompose(surface.points, surface.triangles, cancelled=lambda: next(asked) >= patience)


def test_bad_input_is_refused_with_a_sentence():
    with pytest.raises(InputError):
        decompose(np.zeros((0, 3)), np.zeros((0, 3), int))
    with pytest.raises(InputError):
        decompose([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]])
