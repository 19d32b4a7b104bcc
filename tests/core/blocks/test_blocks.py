"""Blocks of quad meshes whose base complex is known, of rings and tori, and of random layouts."""

import importlib.util
import pathlib
from dataclasses import replace
from time import process_time

import numpy as np
import pytest

from core.blocks.blocks import find_blocks, verify_blocks
from core.errors import LayoutError
from core.quads.lengths import solve_lengths
from core.quads.quad_connectivity import connect_quads
from core.quads.quads import build_quads
from tests.core.complexes import disc, from_rectangles, lshape, random_rectangles

METRICS = pathlib.Path(__file__).resolve().parents[3].parent / "shared" / "tools" / "quadmetrics.py"


def grid(m, n, wrap=(False, False), twist=0):
    """(quads, vertex count) of an m x n grid, closed in the wrapped directions.

    twist  shift of the columns where the rows close
    """
    columns, rows = m + (not wrap[0]), n + (not wrap[1])
    i, j = (a.ravel() for a in np.meshgrid(np.arange(m), np.arange(n)))

    def vertex(i, j):
        return (i + twist * (j >= rows)) % columns + j % rows * columns

    quad = np.stack([vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)], 1)
    return quad, columns * rows


def cube(n):
    """(quads, vertex count) of the surface of a cube, n x n quads on each side."""
    number, quads = {}, []
    for axis in range(3):
        for level in (0, n):
            for a in range(n):
                for b in range(n):
                    square = []
                    for da, db in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        point = tuple(np.roll([level, a + da, b + db], axis).tolist())
                        square.append(number.setdefault(point, len(number)))
                    quads.append(square if level else square[::-1])
    return np.array(quads), len(number)


def blocks_of(quad, count, source=None):
    source = np.zeros(count, bool) if source is None else source
    blocks = find_blocks(quad, count, source)
    verify_blocks(blocks, quad)
    return blocks


def mesh_of(complex, size=None):
    target = complex.arc_length if size is None else np.full(complex.arc_count, float(size))
    length = solve_lengths(complex, target)
    layout = build_quads(complex, length)
    return layout.quad, layout.vertex_count


@pytest.mark.parametrize("m, n", [(1, 1), (1, 7), (20, 10)])
def test_rectangle_is_one_block(m, n):
    blocks = blocks_of(*grid(m, n))
    assert blocks.count == 1 and sorted(blocks.shape[0]) == sorted((m, n))
    assert blocks.edge_on_boundary.all() and len(blocks.edge_offset) == 5
    corner = {0, m, (m + 1) * n, (m + 1) * (n + 1) - 1}
    assert set(blocks.corner[0].tolist()) == corner


@pytest.mark.parametrize("quads, count", [
    (mesh_of(lshape()), 3), (mesh_of(disc(), 1), 5), (mesh_of(disc(), 4), 5), (cube(1), 6),
    (cube(5), 6),
])
def test_known_base_complexes(quads, count):
    blocks = blocks_of(*quads)
    assert blocks.count == count
    assert np.array_equal(np.bincount(blocks.quad_block), blocks.shape.prod(1))


@pytest.mark.parametrize("m, n", [(3, 1), (4, 1), (5, 3), (12, 8), (31, 2)])
def test_annulus_is_a_ring_of_three(m, n):
    blocks = blocks_of(*grid(m, n, (True, False)))
    assert blocks.count == 3
    assert np.ptp(np.bincount(blocks.quad_block)) <= n
    assert blocks.edge_on_boundary.sum() == 6 and (~blocks.edge_on_boundary).sum() == 3


@pytest.mark.parametrize("m, n", [(3, 3), (4, 3), (12, 8)])
def test_torus_is_nine_blocks(m, n):
    blocks = blocks_of(*grid(m, n, (True, True)))
    assert blocks.count == 9
    assert len(blocks.edge_offset) - 1 == 18 and not blocks.edge_on_boundary.any()


@pytest.mark.parametrize("twist", [1, 2, 4, 5])
def test_twisted_torus(twist):
    # A simple quadrangulation of the torus has five vertices at least, and so five quads.
    assert blocks_of(*grid(12, 8, (True, True), twist)).count >= 5


def test_parts_are_cut_each_for_itself():
    flat, first = grid(4, 4)
    closed, second = grid(6, 5, (True, True))
    rings, third = grid(9, 2, (True, False))
    quad = np.concatenate([flat, closed + first, rings + first + second])
    blocks = blocks_of(quad, first + second + third)
    assert blocks.count == 1 + 9 + 3


def test_annulus_with_one_source_and_with_two():
    quad, count = grid(12, 4, (True, False))
    source = np.zeros(count, bool)
    source[0] = True
    blocks = blocks_of(quad, count, source)
    assert blocks.count == 3 and 0 in blocks.corner
    source[6] = True
    blocks = blocks_of(quad, count, source)
    assert blocks.count == 3 and {0, 6} <= set(blocks.corner.ravel().tolist())


def test_inner_source_cuts_both_lines():
    quad, count = grid(6, 4)
    source = np.zeros(count, bool)
    source[2 * 7 + 2] = True
    blocks = blocks_of(quad, count, source)
    assert sorted(np.sort(blocks.shape, axis=1).tolist()) == [[2, 2], [2, 2], [2, 4], [2, 4]]


@pytest.mark.parametrize("seed", range(4))
def test_renumbering_changes_nothing(seed):
    generator = np.random.default_rng(seed)
    quad, count = mesh_of(disc(), 3)
    number = generator.permutation(count)
    turned = np.stack([np.roll(q, generator.integers(4)) for q in number[quad]])
    turned = turned[generator.permutation(len(quad))]
    assert blocks_of(turned, count).count == 5


def plates():
    yield "rectangle", mesh_of(from_rectangles([(0, 0, 5, 3)]))
    yield "lshape", mesh_of(lshape())
    yield "disc", mesh_of(disc(), 3)
    yield "cube", cube(4)
    generator = np.random.default_rng(0)
    for seed in range(6):
        mask = generator.random((9, 9)) < 0.9
        yield f"holes {seed}", holes(mask)


def holes(mask):
    """Squares of a grid where the mask is true, those that touch only in a corner filled up."""
    mask = np.pad(mask, 1)
    mask[1], mask[-2], mask[1:-1, 1], mask[1:-1, -2] = True, True, True, True
    mask[0], mask[-1], mask[:, 0], mask[:, -1] = False, False, False, False
    while True:
        a, b, c, d = mask[:-1, :-1], mask[1:, :-1], mask[:-1, 1:], mask[1:, 1:]
        touch = (a & d & ~b & ~c) | (b & c & ~a & ~d)
        if not touch.any():
            break
        i, j = np.argwhere(touch)[0]
        mask[i : i + 2, j : j + 2] = True
    quad = grid(*mask.shape[::-1])[0][mask.ravel()]
    used, number = np.unique(quad, return_inverse=True)
    return number.reshape(-1, 4), len(used)


@pytest.mark.skipif(not METRICS.exists(), reason="the metrics are not beside the checkout")
@pytest.mark.parametrize("mesh", [pytest.param(mesh, id=name) for name, mesh in plates()])
def test_agrees_with_independent_count(mesh):
    spec = importlib.util.spec_from_file_location("quadmetrics", METRICS)
    metrics = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(metrics)
    quad, count = mesh
    sides = np.full(len(quad), 4)
    topology = metrics.Topo(quad.ravel(), 4 * np.arange(len(quad)), sides, count)
    figures, _, _ = metrics.base_complex(topology)
    assert figures["blocks_not_4cornered"] == 0
    blocks = blocks_of(quad, count)
    assert blocks.count == figures["blocks"]


@pytest.mark.parametrize("seed", range(4))
def test_random_layouts_conform(seed):
    complex = from_rectangles(random_rectangles(np.random.default_rng(seed), 20))
    quad, count = mesh_of(complex)
    assert blocks_of(quad, count).count == 1
    source = np.random.default_rng(seed).random(count) < 0.01
    assert blocks_of(quad, count, source).count >= 1


def test_every_quad_may_be_a_block():
    quad, count = grid(6, 5, (True, True))
    blocks = blocks_of(quad, count, np.ones(count, bool))
    assert blocks.count == 30 and (blocks.shape == 1).all()


def test_defects_are_noticed():
    quad, count = mesh_of(disc(), 3)
    blocks = blocks_of(quad, count)
    swapped = blocks.grid_vertex.copy()
    swapped[[0, 1]] = swapped[[1, 0]]
    edges = blocks.block_edge.copy()
    edges[0] = np.roll(edges[0], 1)
    corner = blocks.corner.copy()
    corner[0, 1] = corner[0, 0]
    for wrong in (
        replace(blocks, grid_vertex=swapped),
        replace(blocks, block_edge=edges),
        replace(blocks, corner=corner),
        replace(blocks, edge_on_boundary=~blocks.edge_on_boundary),
    ):
        with pytest.raises(LayoutError, match="conform"):
            verify_blocks(wrong, quad)


def test_large_ring_is_fast():
    quad, count = grid(4000, 5, (True, False))
    begin = process_time()
    blocks = find_blocks(quad, count, np.zeros(count, bool))
    assert process_time() - begin < 2 and blocks.count == 3
    assert connect_quads(quad, count).edge_count == 4000 * 11
