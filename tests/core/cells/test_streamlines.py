"""Lines on surfaces where their course is known, and what must hold of them everywhere."""

import numpy as np
import pytest

from core.cells.cells import NodeKind
from core.cells.layout import trace_layout
from core.cells.line_field import build_line_field, corner_ports
from core.cells.streamlines import LineGraph
from core.errors import Cancelled
from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field
from tests.core import surfaces
from tests.core.fields import smooth_field


def traced(surface, limits=None, noise=0.0):
    constraints, field = smooth_field(surface, noise)
    return trace_layout(surface, constraints, field, limits).complex


def inner_arcs(complex_):
    return [complex_.polyline(a) for a in np.flatnonzero(complex_.arc_loop < 0)]


def test_lines_of_an_l_shape_run_straight_to_the_opposite_walls():
    complex_ = traced(surfaces.lshape(8))
    for line in inner_arcs(complex_):
        across = np.ptp(line, axis=0).min()
        assert len(line) > 5 and across < 0.03
    ends = complex_.node_position[complex_.node_kind == NodeKind.WALL]
    assert np.allclose(np.sort(ends[:, :2], axis=1), [[0, 1], [0, 1]], atol=0.03)


def test_lines_of_an_octant_meet_the_sides_in_their_middles():
    complex_ = traced(surfaces.octant(16))
    ends = complex_.node_position[complex_.node_kind == NodeKind.WALL]
    middles = np.array([[0, 1, 1], [1, 0, 1], [1, 1, 0]]) / np.sqrt(2)
    distance = np.linalg.norm(ends[:, None] - middles, axis=2)
    assert len(ends) == 3 and np.array_equal(np.sort(distance.argmin(1)), [0, 1, 2])
    assert distance.min(1).max() < 0.1


def test_lines_stay_on_the_surface():
    complex_ = traced(surfaces.octant(12))
    surface = surfaces.octant(12)
    corner = surface.points[surface.triangles[complex_.arc_point_face]]
    normal = surface.face_normal[complex_.arc_point_face]
    height = ((complex_.arc_point - corner[:, 0]) * normal).sum(1)
    assert np.abs(height).max() < 1e-12


def test_full_streamlines_cross_and_end_on_the_boundary():
    mask = np.ones((18, 18), bool)
    mask[4:8, 4:8] = mask[10:14, 9:13] = False
    surface = surfaces.plate(mask, 1 / 18, 0.1)
    short = traced(surface)
    full = traced(surface, (100.0, 100.0))
    assert not np.any(short.node_kind == NodeKind.CROSSING)
    assert np.any(full.node_kind == NodeKind.CROSSING)
    assert not np.any(full.node_kind == NodeKind.JUNCTION)
    assert full.cell_count > short.cell_count


def test_a_full_streamline_over_its_limit_ends_at_the_next_line():
    mask = np.ones((18, 18), bool)
    mask[4:8, 4:8] = mask[10:14, 9:13] = False
    surface = surfaces.plate(mask, 1 / 18, 0.1)
    short, limited = traced(surface), traced(surface, (1e-9, 100.0))
    assert limited.cell_count == short.cell_count
    assert not np.any(limited.node_kind == NodeKind.CROSSING)


def test_lines_do_not_depend_on_scale_and_place():
    surface = surfaces.disc(10)
    moved = surfaces.build_surface(1000 * surface.points + [3e4, -5e4, 1e3], surface.triangles)
    constraints, field = smooth_field(surface)
    first = trace_layout(surface, constraints, field).complex
    again = boundary_constraints(moved, np.radians(20))
    same_field = build_cross_field(moved, field.angle, again)
    second = trace_layout(moved, again, same_field).complex
    assert first.cell_count == second.cell_count
    back = (second.node_position - [3e4, -5e4, 1e3]) / 1000
    distance = np.linalg.norm(first.node_position[:, None] - back, axis=2)
    assert distance.min(0).max() < 1e-7 and distance.min(1).max() < 1e-7


def test_cancelling_stops_the_lines():
    surface = surfaces.plate_with_holes(24)
    constraints, field = smooth_field(surface)
    lines = build_line_field(surface, field, np.flatnonzero(field.index))
    graph = LineGraph(lines, cancelled=lambda: True)
    for vertex in np.flatnonzero(constraints.block_count > 2).tolist():
        for port in corner_ports(surface, lines, float(field.angle[vertex]), vertex, 3):
            graph.start_at_port(port)
    with pytest.raises(Cancelled):
        graph.run()
