"""T-layouts: numbers of blocks that are known, invariants on random meshes, a whole run."""

from dataclasses import replace

import numpy as np
import pytest

from core import pipeline
from core.blocks.blocks import find_blocks
from core.blocks.t_layout import build_t_layout, find_t_edges, verify_t_layout
from core.divisions.divisions import redivide
from core.divisions.regridding import edge_chain
from core.errors import LayoutError
from core.filling.midpoint import split_at_midpoints
from core.pipeline import decompose
from core.quads.quad_connectivity import connect_quads
from core.settings import Settings
from tests.core import creased, surfaces
from tests.core.blocks.test_blocks import cube, grid, mesh_of
from tests.core.complexes import disc, from_rectangles, lshape, random_rectangles
from tests.core.rectilinear import fewest_rectangles, plate_quads, random_mask, slab_quads


def layouts(quad, count, crease=(), points=None):
    """The conforming blocks and the T-layout, verified; without places no line is too long."""
    if points is None:
        points = 1e-3 * np.random.default_rng(0).random((count, 3))
        points[0] = 1.0
    ends = np.bincount(np.asarray(crease, np.int64).ravel(), minlength=count)
    blocks = find_blocks(quad, count, (ends > 0) & (ends != 2), crease)
    layout = build_t_layout(quad, blocks, find_t_edges(points, blocks, crease))
    verify_t_layout(layout, quad, crease)
    return blocks, layout


def square_ring(first, last, width):
    """(n, 2) edges round the squares first <= i, j < last of a grid of `width` vertices a row."""
    line = np.arange(first, last)
    horizontal = [np.stack([line, line + 1], 1) + width * j for j in (first, last)]
    vertical = [np.stack([line, line + 1], 1) * width + i for i in (first, last)]
    return np.concatenate(horizontal + vertical)


@pytest.mark.parametrize("mesh, conforming, fewest, junctions", [
    (grid(5, 3), 1, 1, 0),
    (mesh_of(lshape()), 3, 2, 1),
    (mesh_of(disc(), 1), 5, 5, 0),
    (mesh_of(disc(), 4), 5, 5, 0),
    (cube(4), 6, 6, 0),
    (grid(12, 4, (True, False)), 3, 1, 0),
    (grid(12, 8, (True, True)), 9, 1, 0),
    (grid(12, 8, (True, True), 5), 12, 1, 2),
], ids=["rectangle", "L", "disc of 5", "disc", "cube", "ring", "torus", "twisted torus"])
def test_known_numbers_of_blocks(mesh, conforming, fewest, junctions):
    blocks, layout = layouts(*mesh)
    assert (blocks.count, layout.count) == (conforming, fewest)
    assert layout.junction_count == junctions


def test_a_ring_is_one_block_that_closes_upon_itself():
    quad, count = grid(12, 4, (True, False))
    _, layout = layouts(quad, count)
    assert sorted(layout.shape[0].tolist()) == [4, 12]
    assert len(set(layout.corner[0].tolist())) == 2
    assert layout.edge_on_boundary.tolist().count(True) == 2 and len(layout.edge_on_boundary) == 3


@pytest.mark.parametrize("shape, fewest", [
    (["111", "010"], 2),  # T
    (["101", "111"], 3),  # U
    (["010", "111", "010"], 3),  # plus
    (["100", "110", "111"], 3),  # stairs
    (["111", "101", "111"], 4),  # frame
    (["110", "011"], 2),  # Z
])
def test_few_squares(shape, fewest):
    mask = np.kron([[int(c) for c in row] for row in shape], np.ones((3, 3), int))
    assert fewest_rectangles(mask) == fewest
    assert layouts(*plate_quads(mask))[1].count == fewest


@pytest.mark.parametrize("seed", range(12))
def test_rectilinear_plates_have_the_fewest_rectangles(seed):
    generator = np.random.default_rng(seed)
    mask = random_mask(generator, int(generator.integers(5, 13)))
    assert layouts(*plate_quads(mask))[1].count == fewest_rectangles(mask)


def test_a_sieve_has_the_fewest_rectangles():
    mask = random_mask(np.random.default_rng(1), 60, 0.9)
    assert layouts(*plate_quads(mask))[1].count == fewest_rectangles(mask) == 266


@pytest.mark.parametrize("seed", range(6))
def test_slabs_with_sharp_edges(seed):
    generator = np.random.default_rng(seed)
    mask = random_mask(generator, int(generator.integers(5, 11)))
    quads, count, crease, walls = slab_quads(mask)
    blocks, layout = layouts(quads, count, crease)
    assert layout.count == 2 * fewest_rectangles(mask) + walls <= blocks.count
    blocks, layout = layouts(quads, count)
    assert layout.count <= blocks.count


@pytest.mark.parametrize("seed", range(4))
def test_random_domains_without_irregular_vertices_inside(seed):
    generator = np.random.default_rng(seed)
    rectangles = random_rectangles(generator, 12)
    left = [rectangles[k] for k in generator.permutation(12)[:11]]
    quads, count = mesh_of(from_rectangles(left))
    try:
        blocks, layout = layouts(quads, count)
    except LayoutError as error:
        pytest.skip(str(error))
    assert 1 <= layout.count <= blocks.count


def test_feature_edges_part_blocks():
    quad, count = grid(6, 4)
    line = np.stack([np.arange(7 * 4).reshape(4, 7)[:, 3], np.arange(7, 7 * 5).reshape(4, 7)[:, 3]], 1)
    assert layouts(quad, count, line)[1].count == 2
    # One that ends inside goes on straight from there.
    assert layouts(quad, count, line[:2])[1].count == 2
    assert layouts(quad, count)[1].count == 1


def test_a_closed_feature_line_with_corners():
    quad, count = grid(9, 9)
    _, layout = layouts(quad, count, square_ring(3, 6, 10))
    # Inside one; outside no two of the four reflex corners lie on one line: a pinwheel of four.
    assert layout.count == 5 and layout.junction_count == 4


@pytest.mark.parametrize("seed", range(8))
def test_random_feature_edges(seed):
    generator = np.random.default_rng(seed)
    meshes = [slab_quads(random_mask(generator, 6))[:2], grid(7, 5, (True, seed % 2 == 0), seed % 3)]
    for quad, count in meshes:
        edges = connect_quads(quad, count).edge_vertex
        blocks, layout = layouts(quad, count, edges[generator.random(len(edges)) < 0.05])
        assert layout.count <= blocks.count


def test_parts_are_laid_out_each_for_itself():
    meshes = [grid(4, 4), mesh_of(lshape()), grid(9, 2, (True, False)), cube(2)]
    shift = np.cumsum([0, *(count for _, count in meshes)])
    quad = np.concatenate([q + s for (q, _), s in zip(meshes, shift)])
    assert layouts(quad, int(shift[-1]))[1].count == 1 + 2 + 1 + 6


@pytest.mark.parametrize("seed", range(4))
def test_renumbering_keeps_the_count(seed):
    generator = np.random.default_rng(seed)
    quad, count = plate_quads(random_mask(np.random.default_rng(7), 8))
    points = 1e-3 * generator.random((count, 3))
    points[0] = 1.0
    before = layouts(quad, count, points=points)[1].count
    number = generator.permutation(count)
    turned = np.stack([np.roll(q, generator.integers(4)) for q in number[quad]])
    moved = np.empty_like(points)
    moved[number] = points
    after = layouts(turned[generator.permutation(len(quad))], count, points=moved)[1]
    assert after.count == before


def test_defects_are_noticed():
    quad, count, crease, _ = slab_quads(random_mask(np.random.default_rng(1), 6))
    _, layout = layouts(quad, count, crease)
    swapped = layout.grid_vertex.copy()
    swapped[[0, 1]] = swapped[[1, 0]]
    shifted = layout.side_start.copy()
    shifted[-1] += 1
    corner = np.roll(layout.corner, 1, axis=1)
    owner = layout.quad_block.copy()
    owner[0] += 1
    for wrong in (
        replace(layout, grid_vertex=swapped),
        replace(layout, side_start=shifted),
        replace(layout, corner=corner),
        replace(layout, quad_block=owner),
        replace(layout, side_forward=~layout.side_forward),
        replace(layout, edge_on_boundary=~layout.edge_on_boundary),
        replace(layout, side_edge=layout.side_edge[::-1]),
    ):
        with pytest.raises(LayoutError, match="not valid"):
            verify_t_layout(wrong, quad, crease)
    with pytest.raises(LayoutError, match="feature"):
        verify_t_layout(layout, quad, quad[:, [0, 1]])


def test_an_irregular_vertex_must_be_a_corner():
    quad, count = mesh_of(disc(), 4)
    blocks = find_blocks(quad, count, np.zeros(count, bool))
    kept = find_t_edges(np.random.default_rng(0).random((count, 3)), blocks)
    inner = np.flatnonzero(kept & ~blocks.edge_on_boundary)
    with pytest.raises(LayoutError):
        for edge in inner:
            fewer = kept.copy()
            fewer[edge] = False
            verify_t_layout(build_t_layout(quad, blocks, fewer), quad)


@pytest.fixture(scope="module")
def runs():
    """Decompositions of one surface, with conforming blocks and with T-junctions."""
    surface = surfaces.plate_with_holes(12)
    return [
        decompose(surface.points, surface.triangles, Settings(quad_count=600, t_junctions=wanted))
        for wanted in (False, True)
    ]


def test_a_run_hands_out_the_same_quads_in_fewer_blocks(runs):
    conforming, joined = runs
    assert np.array_equal(conforming.quads.quads, joined.quads.quads)
    assert np.array_equal(conforming.quads.points, joined.quads.points)
    assert conforming.layout is conforming.blocks
    assert joined.layout.count < joined.blocks.count == conforming.blocks.count
    assert set(np.unique(joined.polygon_block)) <= set(range(-1, joined.layout.count))
    assert "T-junctions" in joined.sentence() and "T-junctions" not in conforming.sentence()


def test_the_report_says_that_blocks_do_not_conform(runs):
    conforming, joined = (run.report()["blocks"] for run in runs)
    assert conforming == {"count": conforming["count"], "conforming": True}
    assert joined["conforming"] is False and joined["conforming_count"] == conforming["count"]
    assert len(joined["divisions"]) == joined["count"]
    assert sum(m * n for m, n in joined["divisions"]) == len(runs[1].quads.quads)


def test_the_report_names_the_conforming_edges_along_each_edge(runs):
    result = runs[1]
    layout, blocks, found = result.layout, result.blocks, []
    for edge, join in enumerate(result.report()["blocks"]["interfaces"]):
        chain = edge_chain(layout, edge).tolist()
        pieces = [edge_chain(blocks, piece).tolist() for piece in join["conforming_edges"]]
        walk = chain[:1]
        for piece in pieces:
            walk += piece[1:] if piece[0] == walk[-1] else piece[-2::-1]
        assert walk == chain
        found += join["conforming_edges"]
    assert sorted(found) == np.flatnonzero(result.t_edges).tolist()


def test_conforming_blocks_stand_in_for_a_layout_that_is_not_valid(monkeypatch):
    def refuse(*_):
        raise LayoutError("The T-layout is not valid (a reason): the blocks conform instead.")

    monkeypatch.setattr(pipeline, "verify_t_layout", refuse)
    surface = surfaces.lshape(6)
    result = decompose(surface.points, surface.triangles, Settings(quad_count=60, t_junctions=True))
    assert result.layout is result.blocks and result.report()["blocks"]["conforming"]
    assert any("a reason" in warning for warning in result.warnings)
    assert result.polygon_block.max() == result.blocks.count - 1


@pytest.mark.parametrize("seed", range(3))
def test_three_quads_in_every_triangle(seed):
    """The midpoint split: nearly every vertex is irregular, blocks are as small as quads."""
    surface = surfaces.crumpled(surfaces.regular_polygon(7, 4, seed=seed), 0.1)
    result = split_at_midpoints(
        surface, np.zeros(len(surface.twin), bool), np.zeros(surface.vertex_count, bool), Settings()
    )
    blocks, layout = layouts(result.quads.quads, len(result.quads.points))
    assert 1 <= layout.count <= blocks.count


def test_new_divisions_keep_the_t_layout(runs):
    joined = runs[1]
    finer = redivide(joined, quad_count=2400)
    assert len(finer.quads.quads) > 1800
    verify_t_layout(finer.layout, finer.quads.quads, finer.quads.crease)
    assert finer.layout.count == joined.layout.count
    assert np.array_equal(np.diff(finer.layout.side_offset), np.diff(joined.layout.side_offset))


def test_a_solid_with_creases():
    surface = creased.block()
    result = decompose(surface.points, surface.triangles, Settings(quad_count=300, t_junctions=True))
    verify_t_layout(result.layout, result.quads.quads, result.quads.crease)
    # Two L-shaped faces of two blocks each, six walls.
    assert result.layout.count == 10 < result.blocks.count
