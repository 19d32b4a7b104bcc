"""Quad connectivity of cell complexes against analytic topology and hostile lengths."""

from time import process_time

import numpy as np
import pytest

from core.cells.cells import NodeKind
from core.errors import CoarseLayoutError, LayoutError
from core.quads.lengths import count_quads, solve_lengths
from core.quads.quad_connectivity import connect_quads, opposite_side, vertex_fans
from core.quads.quads import arcs_to_lengthen, build_quads, verify_lengths, verify_topology
from tests.core.complexes import (
    build_complex,
    disc,
    forced_zero,
    from_rectangles,
    lshape,
    random_rectangles,
    ring,
    torus,
)


def random_mesh(seed, cells=30):
    complex = from_rectangles(random_rectangles(np.random.default_rng(seed), cells))
    return complex, solve_lengths(complex, complex.arc_length / 4)


def node_positions_of_grids(complex, layout):
    """Vertices of the four grid corners of each cell that has kept its width."""
    for cell in np.flatnonzero(layout.cell_shape.prod(1) > 0):
        m, n = layout.cell_shape[cell]
        begin, end = layout.grid_offset[cell : cell + 2]
        grid = layout.grid_vertex[begin:end].reshape(n + 1, m + 1)
        yield cell, grid


@pytest.mark.parametrize("seed", range(5))
def test_random_t_meshes_are_squares(seed):
    complex, length = random_mesh(seed)
    layout = build_quads(complex, length)
    verify_topology(layout, complex, 1, 1, 1)
    assert len(layout.quad) == count_quads(complex, length)
    assert layout.vertex_fixed.sum() == 4
    mesh = connect_quads(layout.quad, layout.vertex_count)
    assert np.array_equal(layout.vertex_loop >= 0, mesh.on_boundary)


@pytest.mark.parametrize("seed", range(3))
def test_grids_follow_arcs(seed):
    complex, length = random_mesh(seed, 15)
    layout = build_quads(complex, length)
    first = 0
    for cell, grid in node_positions_of_grids(complex, layout):
        sides = [grid[0], grid[:, -1], grid[-1, ::-1], grid[::-1, 0]]
        for k, side in enumerate(sides):
            slots = range(complex.side_offset[4 * cell + k], complex.side_offset[4 * cell + k + 1])
            chain = []
            for halfarc in complex.side_halfarc[slots.start : slots.stop]:
                arc = halfarc // 2
                path = layout.arc_vertex[
                    layout.arc_vertex_offset[arc] : layout.arc_vertex_offset[arc + 1]
                ]
                chain += (path[::-1] if halfarc % 2 else path).tolist()[1 if chain else 0 :]
            assert chain == side.tolist()
        quads = np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], -1)
        count = quads.shape[0] * quads.shape[1]
        assert np.array_equal(quads.reshape(-1, 4), layout.quad[first : first + count])
        assert (layout.quad_cell[first : first + count] == cell).all()
        first += count
    ends = layout.arc_vertex[layout.arc_vertex_offset[:-1]]
    assert np.array_equal(ends, layout.node_vertex[complex.arc_node[:, 0]])


@pytest.mark.parametrize(
    "complex, expected",
    [(lshape(), (1, 1, 1)), (disc(), (1, 1, 1)), (ring(3), (0, 2, 1)), (torus(3, 3), (0, 0, 1))],
)
@pytest.mark.parametrize("size", [1, 2, 5])
def test_plain_layouts(complex, expected, size):
    layout = build_quads(complex, np.full(complex.arc_count, size))
    verify_topology(layout, complex, *expected)
    mesh = connect_quads(layout.quad, layout.vertex_count)
    assert (vertex_fans(mesh) == 1).all()
    euler = layout.vertex_count - mesh.edge_count + len(layout.quad)
    assert euler == expected[0]
    irregular = mesh.face_count[mesh.irregular & ~mesh.on_boundary]
    nodes = complex.node_valence[~complex.node_on_boundary & (complex.node_valence != 4)]
    assert sorted(irregular) == sorted(nodes)


def test_wrong_expectations_are_refused():
    layout, complex = build_quads(disc(), np.full(12, 2)), disc()
    for expected in ((0, 1, 1), (1, 2, 1), (1, 1, 2)):
        with pytest.raises(LayoutError, match="instead of"):
            verify_topology(layout, complex, *expected)
    complex.node_valence[0] = 5
    with pytest.raises(LayoutError, match="3 instead of 5"):
        verify_topology(layout, complex, 1, 1, 1)


def test_singularities_of_valence_two_are_refused():
    complex = disc()
    complex.node_valence[1] = 2
    with pytest.raises(LayoutError, match="too pointed"):
        verify_lengths(complex, np.full(12, 2), 1, 1, 1)


def test_unbalanced_lengths_are_refused():
    complex = lshape()
    length = np.ones(complex.arc_count, np.int64)
    length[0] = 2
    with pytest.raises(LayoutError, match="opposite sides"):
        build_quads(complex, length)
    with pytest.raises(LayoutError, match="no quad"):
        verify_topology(build_quads(complex, 0 * length), complex, 1, 1, 1)


def test_vanished_cell_joins_its_sides():
    complex = from_rectangles([(0, 0, 2, 3), (2, 0, 3, 3), (3, 0, 5, 3)])
    length = np.round(complex.arc_length).astype(int)
    length[length == 1] = 0
    layout = build_quads(complex, length)
    assert len(layout.quad) == 4 * 3 and (layout.cell_shape.prod(1) == 0).sum() == 1
    verify_topology(layout, complex, 1, 1, 1)
    assert layout.vertex_count == 5 * 4


def test_zero_arc_of_an_offset_ring():
    complex = forced_zero()
    length = solve_lengths(complex, np.full(4, 4.0))
    verify_topology(build_quads(complex, length), complex, 0, 2, 1)
    assert np.count_nonzero(length == 0) == 1


def test_singularities_may_not_merge():
    complex = disc()
    length = np.ones(12, np.int64)
    length[[0, 2, 4, 6]] = 0
    with pytest.raises(LayoutError, match="one vertex"):
        verify_topology(build_quads(complex, length), complex, 1, 1, 1)
    with pytest.raises(LayoutError, match="one vertex"):
        verify_lengths(complex, length, 1, 1, 1)


def test_boundary_loops_may_not_touch():
    complex = ring(3)
    length = np.where(complex.arc_loop < 0, 0, 2)
    with pytest.raises(LayoutError):
        verify_topology(build_quads(complex, length), complex, 0, 2, 1)
    complex = from_rectangles([
        (0, 0, 9, 1), (0, 1, 1, 5), (1, 1, 4, 2), (4, 1, 9, 2), (1, 2, 2, 5), (3, 2, 4, 5),
        (4, 2, 9, 5), (0, 5, 2, 9), (2, 5, 9, 9),
    ])
    assert complex.arc_loop.max() == 1


@pytest.mark.parametrize("around, fits", [(1, False), (2, False), (3, True)])
def test_narrow_ring_asks_for_length(around, fits):
    complex = ring(1)
    length = np.where(complex.arc_loop >= 0, around, 2)
    layout, longer = verify_lengths(complex, length, 0, 2, 1)
    assert len(layout.quad) == 2 * around
    assert longer.any() != fits
    assert not longer[complex.arc_loop < 0].any() or around == 1
    if not fits:
        assert longer[complex.arc_loop >= 0].any()


def test_arcs_to_lengthen_lie_along_the_edge():
    complex = from_rectangles([(0, 0, 4, 3)])
    across = np.isclose(complex.arc_length, 4)
    layout = build_quads(complex, np.round(complex.arc_length).astype(int))
    grid = layout.grid_vertex.reshape(4, 5)
    chosen = arcs_to_lengthen(complex, layout, [[grid[2, 2], grid[2, 1]]])
    assert chosen.sum() == 1 and across[chosen].all()
    chosen = arcs_to_lengthen(complex, layout, [[grid[2, 2], grid[1, 2]]])
    assert chosen.sum() == 1 and not across[chosen].any()


def test_one_vertex_between_two_parts_is_refused():
    quad = np.array([[0, 1, 2, 3], [2, 4, 5, 6]])
    assert vertex_fans(connect_quads(quad, 7)).tolist() == [1, 1, 2, 1, 1, 1, 1]
    ends = {"a": (0, 1), "b": (1, 2), "c": (2, 3), "d": (3, 0)}
    ends |= {"e": (2, 4), "f": (4, 5), "g": (5, 6), "h": (6, 2)}
    cells = [[["a"], ["b"], ["c"], ["d"]], [["e"], ["f"], ["g"], ["h"]]]
    complex = build_complex(ends, cells, [1, 1, 2, 1, 1, 1, 1], [NodeKind.CORNER] * 7)
    with pytest.raises(CoarseLayoutError, match="touch only there"):
        verify_topology(build_quads(complex, np.ones(8, int)), complex, 1, 1, 1)


@pytest.mark.parametrize(
    "quad, match",
    [
        ([[0, 1, 0, 2]], "vertex twice"),
        ([[0, 1, 2, 3], [0, 1, 4, 5]], "two edges"),
    ],
)
def test_degenerate_quads_are_refused(quad, match):
    with pytest.raises(CoarseLayoutError, match=match) as caught:
        connect_quads(np.array(quad), 6)
    assert caught.value.edge.shape[1] == 2 and len(caught.value.edge)


def test_connectivity_of_random_meshes():
    complex, length = random_mesh(9)
    layout = build_quads(complex, length)
    mesh = connect_quads(layout.quad, layout.vertex_count)
    inner = np.flatnonzero(mesh.twin >= 0)
    assert np.array_equal(mesh.twin[mesh.twin[inner]], inner)
    assert np.array_equal(mesh.tail[inner], mesh.head[mesh.twin[inner]])
    assert np.array_equal(mesh.edge[inner], mesh.edge[mesh.twin[inner]])
    every = np.arange(len(mesh.tail))
    assert np.array_equal(opposite_side(opposite_side(every)), every)
    straight = np.flatnonzero(mesh.straight >= 0)
    assert np.array_equal(mesh.tail[mesh.straight[straight]], mesh.head[straight])
    # The way back is straight as well.
    back = mesh.twin[mesh.straight[straight]]
    known = (back >= 0) & (mesh.twin[straight] >= 0)
    known[known] &= mesh.straight[back[known]] >= 0
    assert np.array_equal(mesh.straight[back[known]], mesh.twin[straight[known]])


def test_twenty_thousand_quads_in_a_blink():
    complex = from_rectangles(random_rectangles(np.random.default_rng(4), 100))
    length = solve_lengths(complex, complex.arc_length * 2.3)
    begin = process_time()
    layout = build_quads(complex, length)
    verify_topology(layout, complex, 1, 1, 1)
    assert len(layout.quad) > 15000 and process_time() - begin < 1
