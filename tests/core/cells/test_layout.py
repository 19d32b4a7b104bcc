"""Cells of whole surfaces: known answers, and invariants on smooth and on noisy fields."""

import numpy as np
import pytest

from core.cells import layout as layout_module
from core.cells.cells import NodeKind
from core.cells.layout import trace_layout
from core.cells.streamlines import LineTrapped
from core.errors import LayoutError
from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field
from core.surface.surface import build_surface
from tests.core import surfaces
from tests.core.fields import smooth_field

MAKERS = {
    "disc": lambda: surfaces.disc(9),
    "triangle": lambda: surfaces.regular_polygon(3, 9),
    "pentagon": lambda: surfaces.regular_polygon(5, 8),
    "hexagon": lambda: surfaces.regular_polygon(6, 8),
    "lshape": lambda: surfaces.lshape(7),
    "octant": lambda: surfaces.octant(10),
    "annulus": lambda: surfaces.annulus(30, 6),
    "cylinder": lambda: surfaces.cylinder(24, 8),
    "holes": lambda: surfaces.plate_with_holes(24),
    "crumpled": lambda: surfaces.crumpled(surfaces.plate(np.ones((12, 12), bool), 0.1), 0.02),
    "two": lambda: surfaces.together(surfaces.disc(7), surfaces.annulus(24, 5)),
}


def layout(name, noise=0.0, seed=0, limits=None):
    surface = MAKERS[name]()
    constraints, field = smooth_field(surface, noise, seed)
    return surface, field, trace_layout(surface, constraints, field, limits)


@pytest.mark.parametrize(
    "name, cells, singular",
    [("triangle", 3, 1), ("pentagon", 5, 1), ("lshape", 3, 0), ("octant", 3, 1), ("annulus", 3, 0),
     ("cylinder", 3, 0), ("crumpled", 1, 0)],
)
def test_known_layouts(name, cells, singular):
    _, _, result = layout(name)
    assert result.complex.cell_count == cells
    assert np.count_nonzero(result.complex.node_kind == NodeKind.SINGULARITY) == singular


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("noise", [0.0, 0.2])
@pytest.mark.parametrize("limits", [None, (30.0, 50.0)])
def test_cells_form_a_complex_of_the_same_topology(name, noise, limits):
    surface, field, result = layout(name, noise, 5, limits)
    c = result.complex
    assert c.node_count - c.arc_count + c.cell_count == surface.euler_characteristic
    assert np.all(np.diff(c.side_offset) > 0)
    # Every halfarc on just one side, those outside the boundary on none.
    inside = np.repeat(c.arc_loop < 0, 2)
    inside[0::2] = True
    assert np.array_equal(np.sort(c.side_halfarc), np.flatnonzero(inside))
    singular = c.node_valence[c.node_kind == NodeKind.SINGULARITY]
    assert sorted(singular) == sorted(4 - field.index[field.index != 0])


@pytest.mark.parametrize("name", MAKERS)
def test_sides_are_chains_of_arcs(name):
    _, _, result = layout(name)
    c = result.complex
    arc, backward = np.divmod(c.side_halfarc, 2)
    first, last = c.arc_node[arc, backward], c.arc_node[arc, 1 - backward]
    cell = c.slot_cell
    follows = np.arange(len(cell)) + 1
    start = np.searchsorted(cell, np.arange(c.cell_count))
    ends = np.searchsorted(cell, np.arange(c.cell_count), side="right") - 1
    follows[ends] = start
    assert np.array_equal(last, first[follows])


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_the_cut_surface_is_a_disc_for_each_cell(name, noise):
    surface, _, result = layout(name, noise, 3)
    mesh, c = result.cell_mesh, result.complex
    corner = mesh.point[mesh.triangle]
    vector = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2
    area = np.linalg.norm(vector, axis=1)
    assert area.sum() == pytest.approx(surface.face_area.sum(), rel=1e-9)
    assert np.all((vector * surface.face_normal[mesh.triangle_face]).sum(1) > 0)
    for cell in range(c.cell_count):
        triangle = mesh.triangle[mesh.triangle_cell == cell]
        edges = np.sort(np.concatenate([triangle[:, [0, 1]], triangle[:, [1, 2]], triangle[:, [2, 0]]]))
        edge, count = np.unique(edges, axis=0, return_counts=True)
        assert len(np.unique(triangle)) - len(edge) + len(triangle) == 1
        wall = np.unique(edge[count == 1])
        assert np.array_equal(wall, np.unique(mesh.wall_point[c.slot_cell[mesh.wall_slot] == cell]))


@pytest.mark.parametrize("name", ["disc", "holes", "octant"])
def test_wall_points_lie_where_their_arc_length_says(name):
    _, _, result = layout(name)
    mesh, c = result.cell_mesh, result.complex
    for slot, halfarc in enumerate(c.side_halfarc):
        line = c.polyline(halfarc // 2)
        line = line[::-1] if halfarc % 2 else line
        reach = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        here = mesh.wall_slot == slot
        assert np.allclose(mesh.wall_distance[here], reach[:-1])
        assert np.allclose(mesh.point[mesh.wall_point[here]], line[:-1])


@pytest.mark.parametrize("name", ["holes", "annulus"])
def test_boundary_arcs_know_their_place_on_the_loop(name):
    surface, _, result = layout(name)
    c = result.complex
    for loop in range(surface.loop_count):
        arcs = np.flatnonzero(c.arc_loop == loop)
        halfedges = surface.loop_halfedges[surface.loop_offset[loop] : surface.loop_offset[loop + 1]]
        whole = surface.edge_length[halfedges].sum()
        assert c.arc_length[arcs].sum() == pytest.approx(whole)
        order = arcs[np.argsort(c.arc_loop_start[arcs])]
        gaps = np.diff(np.append(c.arc_loop_start[order], c.arc_loop_start[order[0]] + whole))
        assert np.allclose(gaps, c.arc_length[order])


def field_along_the_torus(around, along):
    """Crosses along the circles of a torus: no singularity, no boundary, nothing to start from."""
    surface = surfaces.torus(around, along)
    row, column = np.divmod(np.arange(surface.vertex_count), around)
    onward = row * around + (column + 1) % around
    pair = {(t, h): k for k, (t, h) in enumerate(zip(surface.tail.tolist(), surface.head.tolist()))}
    halfedge = [pair[v, w] for v, w in enumerate(onward.tolist())]
    constraints = boundary_constraints(surface, 0.3)
    return surface, constraints, build_cross_field(surface, surface.polar_angle[halfedge], constraints)


def test_a_closed_surface_without_singularity_starts_from_a_regular_point():
    surface, constraints, field = field_along_the_torus(24, 16)
    assert not np.any(field.index)
    result = trace_layout(surface, constraints, field)
    c = result.complex
    assert len(result.regular_faces) >= 1 and c.cell_count >= 1
    assert c.node_count - c.arc_count + c.cell_count == 0


@pytest.mark.parametrize("name", ["disc", "octant", "annulus", "holes", "cylinder", "two"])
@pytest.mark.parametrize("noise", [0.8, 1.6])
def test_lines_of_wild_fields_never_wind_round_a_vertex(name, noise):
    """Noise over the whole circle: singularities side by side, and still no line is trapped."""
    surface = MAKERS[name]()
    for seed in range(3):
        constraints, field = smooth_field(surface, noise, seed)
        result = trace_layout(surface, constraints, field)
        c = result.complex
        assert c.node_count - c.arc_count + c.cell_count == surface.euler_characteristic
        assert len(result.regular_faces) <= 1


def trapped_first(monkeypatch, rounds):
    """Stand in for tracing: in each of the rounds lines are trapped in so many triangles."""
    trace, calls = layout_module._trace_all, []

    def trace_or_trap(surface, constraints, field, faces, *rest):
        calls.append(len(faces))
        if len(calls) <= len(rounds):
            raise LineTrapped(range(rounds[len(calls) - 1]))
        return trace(surface, constraints, field, faces, *rest)

    monkeypatch.setattr(layout_module, "_trace_all", trace_or_trap)
    return calls


def test_every_trapped_line_gets_a_barrier_at_once(monkeypatch):
    calls = trapped_first(monkeypatch, [3, 2])
    _, _, found = layout("disc")
    assert np.diff(calls).tolist() == [3, 2]
    assert len(set(found.regular_faces)) == 5


def test_barriers_that_free_no_line_are_given_up_soon(monkeypatch):
    calls = trapped_first(monkeypatch, [4] * 99)
    with pytest.raises(LayoutError, match="barriers"):
        layout("disc")
    assert len(calls) == layout_module.FUTILE_ROUNDS + 1


def test_lines_that_wind_round_for_ever_end_at_their_limits():
    """On a torus with one small hole full lines meet next to nothing; motorcycles meet each other."""
    whole = surfaces.torus(36, 20)
    middle = whole.points[whole.triangles].mean(1)
    outermost = np.array([whole.points[:, 0].max(), 0.0, 0.1])
    kept = whole.triangles[np.linalg.norm(middle - outermost, axis=1) > 0.35]
    used, triangles = np.unique(kept, return_inverse=True)
    surface = build_surface(whole.points[used], triangles.reshape(-1, 3))
    constraints, field = smooth_field(surface, 0.0, 0)
    cells, drawn = [], []
    for limits in (None, (1.0, 50.0), (5.0, 50.0)):
        complex = trace_layout(surface, constraints, field, limits).complex
        assert complex.node_count - complex.arc_count + complex.cell_count == -1
        cells.append(complex.cell_count)
        drawn.append(complex.arc_length[complex.arc_loop < 0].sum())
    lines = complex.node_valence[complex.node_kind == NodeKind.SINGULARITY].sum()
    assert cells[0] < cells[1] < cells[2] < 20 * cells[0]
    # Each line runs on no farther than its limit and then to the next line only.
    assert drawn[0] < drawn[2] < lines * 6.0 * surface.diameter
