"""Quads across feature edges: conforming, creases kept as edge chains, known answers."""

from functools import cache

import numpy as np
import pytest

from core.blocks.blocks import verify_blocks
from core.divisions.divisions import redivide
from core.errors import InputError
from core.pipeline import decompose
from core.settings import Settings
from core.surface.boundary import build_loops
from tests.core import creased, surfaces
from tests.core.creased import edges_on

SLIT = {
    "slit plate": (
        lambda: surfaces.plate(np.ones((12, 12)), 1 / 12),
        lambda p: np.isclose(p[:, 0], 0.5) & (p[:, 1] > 0.3) & (p[:, 1] < 0.7),
    ),
    "slit from the boundary": (
        lambda: surfaces.plate(np.ones((12, 12)), 1 / 12),
        lambda p: np.isclose(p[:, 1], 0.5) & (p[:, 0] < 0.6),
    ),
    "cross": (
        lambda: surfaces.plate(np.ones((12, 12)), 1 / 12),
        lambda p: (np.isclose(p[:, 0], 0.5) | np.isclose(p[:, 1], 0.5))
        & (np.abs(p[:, :2] - 0.5) < 0.3).all(1),
    ),
    "slit cube": (
        lambda: creased.cube(6),
        lambda p: np.isclose(p[:, 2], 1) & np.isclose(p[:, 0], 0.5) & (np.abs(p[:, 1] - 0.5) < 0.2),
    ),
    "equator": (lambda: surfaces.sphere(8), lambda p: np.isclose(p[:, 2], 0)),
}
CREASED = {
    "cube": lambda: creased.cube(1),
    "fine cube": lambda: creased.cube(5),
    "block": lambda: creased.block(3),
    "capped cylinder": creased.capped_cylinder,
    "roof": creased.roof,
    "fading crease": creased.fading_crease,
    "frame": lambda: creased.solid([[[1], [1], [1]], [[1], [0], [1]], [[1], [1], [1]]], 2),
}


@cache
def run(name, quad_count=700, **settings):
    marked = None
    if name in SLIT:
        make, on_line = SLIT[name]
        surface = make()
        marked = edges_on(surface, on_line)
    else:
        surface = CREASED[name]()
    settings = Settings(quad_count=quad_count, **settings)
    return surface, decompose(surface.points, surface.triangles, settings, marked_edges=marked)


def edge_counts(quads):
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], 2).reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0, return_counts=True)


def segment_distance(points, first, second):
    """(n, s) distances of points to segments."""
    step = second - first
    along = ((points[:, None] - first) * step).sum(2) / (step**2).sum(1)
    foot = first + np.clip(along, 0, 1)[:, :, None] * step
    return np.linalg.norm(points[:, None] - foot, axis=2)


@pytest.mark.parametrize("name", [*CREASED, *SLIT])
def test_quads_conform_and_keep_the_topology_of_the_uncut_surface(name):
    surface, result = run(name)
    quads = result.quads.quads
    assert not [w for w in result.warnings if "feature" in w]
    edge, count = edge_counts(quads)
    assert count.max() == 2
    assert len(result.quads.points) - len(edge) + len(quads) == surface.euler_characteristic
    boundary = np.unique(edge[count == 1])
    assert np.array_equal(boundary, np.flatnonzero(result.quads.on_boundary))
    assert result.singularities.index_sum == result.singularities.expected_index_sum
    assert result.quads.scaled_jacobian.min() > 0.5
    assert abs(len(quads) / 700 - 1) < 0.2
    verify_blocks(result.blocks, quads)
    report = result.report()
    assert report["input"]["euler_characteristic"] == surface.euler_characteristic
    assert report["input"]["boundary_loops"] == surface.loop_count


@pytest.mark.parametrize("name", [*CREASED, *SLIT])
def test_creases_are_chains_of_edges_that_lie_on_the_input_creases(name):
    _, result = run(name)
    charts, crease = result.charts, result.quads.crease
    cut = np.flatnonzero(charts.across > np.arange(len(charts.across)))
    first = charts.surface.points[charts.surface.tail[cut]]
    second = charts.surface.points[charts.surface.head[cut]]
    used = np.unique(crease)
    distance = segment_distance(result.quads.points[used], first, second)
    assert distance.min(1).max() < 1e-9 * charts.surface.diameter
    edge, _ = edge_counts(result.quads.quads)
    pairs = np.sort(crease, axis=1)
    assert len(np.unique(pairs, axis=0)) == len(pairs)
    assert np.isin(pairs @ [10**6, 1], edge @ [10**6, 1]).all()
    length = np.linalg.norm(np.subtract(*result.quads.points[crease.T]), axis=1).sum()
    assert np.isclose(length, np.linalg.norm(second - first, axis=1).sum(), rtol=0.01)
    # The ends of every input crease are vertices, and all of it is near the chains.
    chain = result.quads.points[crease]
    middle = np.concatenate([first, 0.5 * (first + second)])
    off = segment_distance(middle, chain[:, 0], chain[:, 1]).min(1)
    assert off.mean() < 0.1 * np.sqrt(charts.whole.face_area.sum() / len(result.quads.quads))


@pytest.mark.parametrize("name", [*CREASED, *SLIT])
def test_no_block_straddles_a_crease(name):
    _, result = run(name)
    blocks, size = result.blocks, np.array([10**6, 1])
    inner = []
    for block in range(blocks.count):
        m, n = blocks.shape[block]
        begin, end = blocks.grid_offset[block : block + 2]
        grid = blocks.grid_vertex[begin:end].reshape(n + 1, m + 1)
        inner.append(np.stack([grid[1:-1, :-1], grid[1:-1, 1:]], 2).reshape(-1, 2))
        inner.append(np.stack([grid[:-1, 1:-1], grid[1:, 1:-1]], 2).reshape(-1, 2))
    inner = np.sort(np.concatenate(inner), axis=1)
    assert not np.isin(np.sort(result.quads.crease, axis=1) @ size, inner @ size).any()


@pytest.mark.parametrize(
    "name, valences, blocks",
    [
        ("cube", [3] * 8, 6),
        ("fine cube", [3] * 8, 6),
        ("block", [3] * 10 + [5] * 2, 14),
        ("capped cylinder", [3] * 8, None),
        ("roof", [], 2),
        ("slit plate", [], None),
        ("frame", [3] * 8 + [5] * 8, None),
    ],
)
def test_known_answers(name, valences, blocks):
    _, result = run(name)
    quads = result.quads
    irregular = quads.valence[~quads.on_boundary & (quads.valence != 4)]
    assert sorted(irregular) == valences
    if blocks is not None:
        assert result.blocks.count == blocks


def test_the_cube_is_a_perfect_cube():
    _, result = run("cube", 600)
    assert len(result.quads.quads) == 600
    assert np.allclose(result.quads.scaled_jacobian, 1)
    assert np.allclose(np.rint(result.quads.points * 10), result.quads.points * 10)


def test_the_placement_lies_on_the_whole_surface():
    for name in ("fading crease", "cross", "slit from the boundary"):
        _, result = run(name)
        placement, whole = result.placement, result.whole
        corner = whole.points[whole.triangles[placement.face]]
        normal = whole.face_normal[placement.face]
        height = ((placement.point - corner[:, 0]) * normal).sum(1)
        assert np.abs(height).max() < 1e-9
        assert np.array_equal(placement.loop >= 0, result.quads.on_boundary)
        loops = build_loops(whole)
        wall = np.flatnonzero(placement.loop >= 0)
        on_loop, _ = loops.point(placement.loop[wall], placement.loop_position[wall])
        assert np.allclose(on_loop, placement.point[wall], atol=1e-9)


def test_without_features_nothing_is_cut():
    _, result = run("cube", feature_angle=None)
    assert result.charts is None and not len(result.quads.crease)
    assert result.whole is result.surface


@pytest.mark.parametrize("seed", range(8))
def test_random_solids_keep_their_creases(seed):
    random = np.random.default_rng(seed)
    mask = np.ones(random.integers(1, 4, 3))
    mask[tuple(random.integers(0, mask.shape))] = mask.size == 1
    try:
        surface = creased.solid(mask, 1 + seed % 3, seed)
    except InputError:
        pytest.skip("voxels that touch along an edge only")
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    points = surface.points @ turn.T * 10.0 ** random.integers(-3, 4)
    result = decompose(points, surface.triangles, Settings(quad_count=500))
    assert not [w for w in result.warnings if "feature" in w]
    edge, count = edge_counts(result.quads.quads)
    assert (count == 2).all()
    assert (
        len(result.quads.points) - len(edge) + len(result.quads.quads)
        == surface.euler_characteristic
    )
    assert result.quads.scaled_jacobian.min() > 0.5


@pytest.mark.parametrize("name", ["block", "capped cylinder", "fading crease", "cross"])
def test_new_divisions_keep_the_creases(name):
    _, result = run(name)
    fresh = redivide(result, quad_count=1500)
    assert abs(len(fresh.quads.quads) / 1500 - 1) < 0.2
    edge, _ = edge_counts(fresh.quads.quads)
    assert np.isin(np.sort(fresh.quads.crease, axis=1) @ [10**6, 1], edge @ [10**6, 1]).all()
    before, after = (
        np.linalg.norm(np.subtract(*mesh.points[mesh.crease.T]), axis=1).sum()
        for mesh in (result.quads, fresh.quads)
    )
    assert np.isclose(before, after, rtol=0.01)
