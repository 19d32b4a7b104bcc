"""Coarse layouts: known numbers of blocks, what must never happen, hostile settings."""

import numpy as np
import pytest

from core.blocks.blocks import find_blocks, verify_blocks
from core.cells.cells import NodeKind
from core.cells.layout import trace_layout
from core.coarsening.coarse_divisions import chord_widths, divide, thin_out
from core.coarsening.coarse_lengths import solve_coarse_lengths
from core.coarsening.coarsening import coarsen, remove_rows
from core.coarsening.drafts import DraftBoard
from core.coarsening.layout_chords import find_layout_chords, rows_of_blocks
from core.errors import Cancelled, LayoutError, SettingsError
from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field
from core.field.distance import arrival_distance
from core.field.propagation import propagate
from core.field.relaxation import relax
from core.filling.filling import fill_cells
from core.quads.cell_maps import map_to_squares
from core.quads.covering import quads_over_faces
from core.quads.lengths import count_quads, solve_lengths
from core.quads.quads import build_quads, verify_topology
from core.settings import Settings
from core.surface.boundary import build_loops
from core.surface.projection import barycentric
from core.surface.refinement import split_boundary_chords
from tests.core import surfaces
from tests.core.complexes import from_rectangles, random_rectangles

MAKERS = {
    "disc": lambda: surfaces.disc(9),
    "lshape": lambda: surfaces.lshape(8),
    "octant": lambda: surfaces.octant(12),
    "annulus": lambda: surfaces.annulus(36, 8),
    "half cylinder": lambda: surfaces.cylinder(20, 16, share=0.5),
    "holes": lambda: surfaces.plate_with_holes(24),
    "hexagon": lambda: surfaces.regular_polygon(6, 9),
    "sphere": lambda: surfaces.sphere(8),
    "handle": lambda: surfaces.voxel_shell(np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]])),
}
_LAYOUTS = {}


def layout_of(name):
    if name not in _LAYOUTS:
        surface, _ = split_boundary_chords(MAKERS[name]())
        constraints = boundary_constraints(surface, np.radians(20))
        angle = propagate(surface, constraints, arrival_distance(surface, constraints.fixed))
        angle = relax(surface, constraints, angle, "diffused")
        field = build_cross_field(surface, angle, constraints)
        _LAYOUTS[name] = surface, trace_layout(surface, constraints, field)
    return _LAYOUTS[name]


def fill(name, **settings):
    surface, layout = layout_of(name)
    return surface, layout, fill_cells(surface, layout, Settings(**settings))


def blocks_of(filling):
    quads = filling.quads
    return find_blocks(quads.quads, len(quads.points), filling.source)


@pytest.mark.parametrize("coarseness", ["balanced", "fewest"])
@pytest.mark.parametrize(
    "name, count",
    [("disc", 5), ("lshape", 3), ("octant", 3), ("annulus", 3), ("half cylinder", 1), ("sphere", 6)],
)
def test_known_numbers_of_blocks(name, count, coarseness):
    _, _, filling = fill(name, quad_count=900, coarseness=coarseness)
    assert blocks_of(filling).count == count
    assert filling.quads.scaled_jacobian.min() > 0.6


@pytest.mark.parametrize(
    "name, coarseness",
    [(name, "balanced") for name in MAKERS] + [("holes", "fewest"), ("hexagon", "fewest")],
)
def test_invariants(name, coarseness):
    surface, layout, filling = fill(name, quad_count=900, coarseness=coarseness)
    verify_topology(filling.layout, layout.complex, *layout.topology)
    mesh, placement = filling.quads, filling.placement
    assert mesh.scaled_jacobian.min() > 0.3
    assert abs(len(mesh.quads) / 900 - 1) < 0.1
    weight = barycentric(surface, placement.face, placement.point)
    assert weight.min() > -1e-9
    on_plane = (surface.points[surface.triangles[placement.face]] * weight[:, :, None]).sum(1)
    assert np.abs(on_plane - mesh.points).max() < 1e-12 * max(surface.diameter, 1)
    loops, wall = build_loops(surface), np.flatnonzero(mesh.on_boundary)
    exact, _ = loops.point(placement.loop[wall], placement.loop_position[wall])
    assert np.abs(exact - mesh.points[wall]).max(initial=0) < 1e-12 * surface.diameter
    verify_blocks(blocks_of(filling), mesh.quads)
    direct = fill_cells(surface, layout, Settings(quad_count=900, coarseness="direct"))
    assert blocks_of(filling).count <= blocks_of(direct).count
    assert np.array_equal(
        np.sort(mesh.valence[~mesh.on_boundary & (mesh.valence != 4)]),
        np.sort(direct.quads.valence[~direct.quads.on_boundary & (direct.quads.valence != 4)]),
    )


@pytest.mark.parametrize("name", ["hexagon", "holes", "sphere", "handle"])
def test_fewest_balanced_direct(name):
    counts = [
        blocks_of(fill(name, quad_count=600, coarseness=coarseness)[2]).count
        for coarseness in ("fewest", "balanced", "direct")
    ]
    assert counts == sorted(counts)


def test_corners_stay_where_they_are():
    _, layout, filling = fill("holes", quad_count=900, coarseness="fewest")
    complex = layout.complex
    fixed = np.isin(complex.node_kind, (NodeKind.CORNER, NodeKind.KINK))
    vertex = filling.layout.node_vertex[fixed]
    assert len(np.unique(vertex)) == fixed.sum() >= 24
    assert np.array_equal(filling.quads.points[vertex], complex.node_position[fixed])


def test_every_triangle_has_a_quad_nearby():
    surface, _, filling = fill("octant", quad_count=500)
    quads = filling.quads
    middle = quads.points[quads.quads].mean(1)
    triangle = surface.points[surface.triangles].mean(1)
    assert filling.face_quad.min() >= 0
    gap = np.linalg.norm(middle[filling.face_quad] - triangle, axis=1)
    nearest = np.linalg.norm(triangle[:, None] - middle, axis=2).min(1)
    assert (gap <= nearest + 0.5 * np.sqrt(surface.face_area.sum() / 500)).all()


def test_faces_of_a_part_without_quads_are_unknown():
    surface, _, filling = fill("lshape", quad_count=200)
    both = surfaces.together(surface, surfaces.lshape(4))
    face_quad = quads_over_faces(both, filling.placement, filling.layout.quad)
    assert (face_quad[: surface.face_count] == filling.face_quad).all()
    assert (face_quad[surface.face_count :] == -1).all()


def test_two_runs_are_equal():
    _, _, first = fill("holes", quad_count=700)
    _, _, second = fill("holes", quad_count=700)
    assert np.array_equal(first.quads.points, second.quads.points)
    assert np.array_equal(first.quads.quads, second.quads.quads)


@pytest.mark.parametrize("size", [0.05, 0.5, 5.0, 1e6])
@pytest.mark.parametrize("name", ["disc", "holes", "annulus", "handle"])
def test_no_size_joins_what_must_stay_apart(name, size):
    _, layout = layout_of(name)
    length = solve_coarse_lengths(layout, size)
    quads = build_quads(layout.complex, 3 * length)
    verify_topology(quads, layout.complex, *layout.topology)
    wall = layout.complex.arc_loop >= 0
    along = np.bincount(layout.complex.arc_loop[wall], length[wall])
    assert (along >= 3).all()


@pytest.mark.parametrize("coarseness", ["balanced", "fewest"])
@pytest.mark.parametrize("quad_count", [1, 30, 200])
def test_hostile_numbers_of_quads(coarseness, quad_count):
    try:
        _, layout, filling = fill("holes", quad_count=quad_count, coarseness=coarseness)
    except LayoutError as error:
        assert "quads" in str(error)
    else:
        verify_topology(filling.layout, layout.complex, *layout.topology)
        assert filling.quads.scaled_jacobian.min() > 0


def test_edge_length_is_met():
    _, _, filling = fill("lshape", edge_length=0.1)
    points, quads = filling.quads.points, filling.quads.quads
    corner = points[quads]
    length = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)
    assert abs(length.mean() / 0.1 - 1) < 0.05


def test_unknown_coarseness_is_refused():
    with pytest.raises(SettingsError, match="coarseness"):
        Settings(coarseness="coarsest")


def test_cancel():
    surface, layout = layout_of("holes")
    with pytest.raises(Cancelled):
        coarsen(surface, layout, Settings(), cancelled=lambda: True)


def test_rows_go_only_while_the_shape_is_kept():
    surface, layout = layout_of("holes")
    square = map_to_squares(layout.complex, layout.cell_mesh)
    length = solve_lengths(layout.complex, layout.complex.arc_length * 12)
    board = DraftBoard(surface, layout, square, length)
    division = np.ones(board.chords.count, np.int64)
    start = board.place(board.connect(division))
    end = remove_rows(board, start, 0.05, "balanced")
    assert end.blocks.count < start.blocks.count
    assert end.worst >= min(0.62, 0.85 * start.worst)
    assert (end.division <= start.division).all()


@pytest.mark.parametrize("seed", range(4))
def test_chords_carry_the_lengths(seed):
    complex = from_rectangles(random_rectangles(np.random.default_rng(seed), 20))
    length = solve_lengths(complex, complex.arc_length / 5)
    chords = find_layout_chords(complex, length)
    generator = np.random.default_rng(seed)
    assert np.array_equal(chords.lengths(np.ones(chords.count, np.int64), complex.arc_count), length)
    division = generator.integers(1, 4, chords.count)
    layout = build_quads(complex, chords.lengths(division, complex.arc_count))
    verify_topology(layout, complex, 1, 1, 1)
    pairs = chords.quad_chords(division)
    assert len(pairs) == len(layout.quad)
    # A chord of a rectangle cut into rectangles runs straight through: so many quads lie on it.
    across = [division[pairs[pairs[:, k] == c][:, 1 - k]] for c in range(chords.count) for k in (0, 1)]
    assert sum(map(len, across)) == 2 * len(pairs)


def test_rows_of_one_block_are_all_chords_of_a_direction():
    complex = from_rectangles([(0, 0, 2, 3), (2, 0, 5, 3)])
    length = np.rint(complex.arc_length).astype(np.int64)
    chords = find_layout_chords(complex, length)
    layout = build_quads(complex, length)
    blocks = find_blocks(layout.quad, layout.vertex_count, layout.vertex_fixed)
    pairs = chords.quad_chords(np.ones(chords.count, np.int64))
    row = rows_of_blocks(layout, pairs, chords.count, blocks)
    assert chords.count == 8
    assert sorted(np.bincount(row)) == [3, 5]


def test_divisions_of_a_row_add_up():
    width = np.array([0.3, 0.3, 0.3, 2.0, 0.1])
    row = np.array([0, 0, 0, 1, 2])
    division = divide(width, 0.5, row, np.ones(5, bool))
    assert division[:3].sum() == 2 and division[3] == 4 and division[4] == 1
    dead = divide(width, 0.5, row, np.array([True, False, True, True, False]))
    assert dead[1] == 0 and dead[4] == 0 and dead[:3].sum() == 1


def test_widths_are_geometric_means():
    width = chord_widths(np.array([1.0, 4.0, 3.0]), np.array([0, 0, 1]), np.array([2, 1, 5]))
    assert np.allclose(width, [4.0, 3.0, 0.0])


def test_thinning_out_keeps_small_divisions():
    complex = from_rectangles([(0, 0, 2, 2), (2, 0, 4, 2), (4, 0, 6, 2)])
    chords = find_layout_chords(complex, np.ones(complex.arc_count, np.int64))
    division = np.full(chords.count, 20)
    division[0] = 1
    result = thin_out(complex, chords, division, 200, np.arange(chords.count))
    assert chords.count == 4 and result[0] == 1 and (result[1:] >= 2).all()
    count = count_quads(complex, chords.lengths(result, complex.arc_count))
    assert count <= 200 < count_quads(complex, chords.lengths(division, complex.arc_count))


def test_rows_of_many_chords_are_thinned_as_one():
    complex = from_rectangles([(0, 0, 9, 4)])
    chords = find_layout_chords(complex, np.rint(complex.arc_length))
    row = np.zeros(chords.count, np.int64)
    row[chords.axis_chord[chords.axis_offset[1] :]] = 1
    result = thin_out(complex, chords, np.ones(13, np.int64), 10, row)
    assert result.max() == 1 and 6 <= np.bincount(row, result).prod() <= 10
