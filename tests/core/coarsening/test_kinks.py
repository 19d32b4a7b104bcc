"""Kinks in coarse layouts: circles of few segments, known numbers of blocks, what must hold."""

from dataclasses import replace

import numpy as np
import pytest

from core.cells.cells import NodeKind
from core.cells.layout import trace_layout
from core.coarsening.kinks import Kinks, snap_to_kinks, without_kinks
from core.features.charts import cut_along, share_nodes
from core.features.features import detect_features
from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field
from core.field.distance import arrival_distance
from core.field.propagation import propagate
from core.pipeline import decompose
from core.quads.placement import Placement
from core.settings import Settings
from core.surface.boundary import build_loops
from tests.core import creased, surfaces


def rims(surface, height=2.0):
    """The vertices of a capped cylinder where its wall meets the caps."""
    points = surface.points
    outside = np.isclose(np.hypot(points[:, 0], points[:, 1]), 1)
    return points[outside & (np.isclose(points[:, 2], 0) | np.isclose(points[:, 2], height))]


@pytest.mark.parametrize("around", [12, 16])
def test_a_capped_cylinder_has_fourteen_blocks_and_all_its_kinks(around):
    """Five blocks for each cap, four for the wall: a square in a circle on both sides of each rim."""
    surface = creased.capped_cylinder(around=around)
    result = decompose(surface.points, surface.triangles, Settings(quad_count=900))
    assert result.blocks.count == 14
    assert result.quads.scaled_jacobian.min() > 0.8
    gap = np.linalg.norm(result.quads.points - rims(surface)[:, None], axis=2).min(1)
    assert gap.max() < 1e-9


def test_a_polygon_of_many_sides_is_a_disc():
    surface = surfaces.regular_polygon(16, 8)
    result = decompose(surface.points, surface.triangles, Settings(quad_count=900))
    assert result.blocks.count == 5
    corner = surface.points[surface.on_boundary]
    corner = corner[np.linalg.norm(corner, axis=1) > 0.999 * np.linalg.norm(corner, axis=1).max()]
    assert len(corner) == 16
    gap = np.linalg.norm(result.quads.points - corner[:, None], axis=2).min(1)
    assert gap.max() < 1e-9


def layout_on_charts(surface):
    charts, _ = cut_along(surface, detect_features(surface, np.radians(40), np.radians(20)))
    constraints = share_nodes(charts, boundary_constraints(charts.surface, np.radians(20)))
    arrival = arrival_distance(charts.surface, constraints.fixed)
    field = build_cross_field(
        charts.surface, propagate(charts.surface, constraints, arrival), constraints
    )
    return charts.surface, trace_layout(charts.surface, constraints, field, charts=charts)


def test_kinks_of_smooth_rims_are_let_go_on_all_charts():
    surface, layout = layout_on_charts(creased.capped_cylinder(around=16))
    kind = layout.gluing.complex.node_kind
    freed, kinks = without_kinks(layout)
    # Each of the 32 places lies on the wall and on a cap; the wall itself is straight there.
    assert len(kinks.loop) == (kind == NodeKind.KINK).sum() == 64
    assert not (freed.complex.node_kind == NodeKind.KINK).any()
    assert not (freed.gluing.complex.node_kind == NodeKind.KINK).any()
    place, _ = build_loops(surface).point(kinks.loop, kinks.position)
    expected = rims(creased.capped_cylinder(around=16))
    gap = np.linalg.norm(place - expected[:, None], axis=2)
    assert gap.min(1).max() < 1e-12 and gap.min(0).max() < 1e-12


def test_corners_are_not_let_go():
    _, layout = layout_on_charts(creased.cube(3))
    freed, kinks = without_kinks(layout)
    assert len(kinks.loop) == 0
    assert np.array_equal(freed.complex.node_kind, layout.complex.node_kind)


def on_circle(count, corners=64):
    """A disc and vertices spread evenly along its boundary."""
    surface = surfaces.regular_polygon(corners, 2)
    loops = build_loops(surface)
    loop = np.zeros(count, np.int64)
    position = (np.arange(count) + 0.3) / count * loops.length[0]
    point, face = loops.point(loop, position)
    return surface, Placement(point, face, loop, position, np.zeros(count, bool))


@pytest.mark.parametrize("seed", range(3))
def test_no_vertex_overtakes_another(seed):
    surface, placement = on_circle(40)
    loops = build_loops(surface)
    position = np.random.default_rng(seed).uniform(0, loops.length[0], 20)
    snapped = snap_to_kinks(surface, placement, Kinks(np.zeros(20, np.int64), position))
    moved = snapped.loop_position - placement.loop_position
    half = 0.5 * loops.length[0]
    moved = np.mod(moved + half, 2 * half) - half
    assert np.abs(moved).max() <= half / 40 * (1 + 1e-9)
    order = np.diff(placement.loop_position + moved)
    assert (order > 0).all()
    assert 0 < snapped.fixed.sum() <= 20
    assert np.isin(snapped.loop_position[snapped.fixed], position).all()
    assert (moved[~snapped.fixed] == 0).all()


def test_too_few_vertices_stay_where_they_are():
    surface, placement = on_circle(15)
    kinks = Kinks(np.zeros(8, np.int64), np.linspace(0, 1, 8))
    assert np.array_equal(snap_to_kinks(surface, placement, kinks).point, placement.point)


def test_fixed_vertices_stay():
    surface, placement = on_circle(40)
    placement = replace(placement, fixed=np.ones(40, bool))
    kinks = Kinks(np.zeros(1, np.int64), np.array([1.0]))
    assert np.array_equal(snap_to_kinks(surface, placement, kinks).point, placement.point)


def test_both_copies_on_a_cut_are_fixed():
    surface, placement = on_circle(40)
    across = np.full(40, -1)
    across[[3, 30]] = 30, 3
    kinks = Kinks(np.zeros(1, np.int64), placement.loop_position[[3]])
    assert np.array_equal(
        np.flatnonzero(snap_to_kinks(surface, placement, kinks, across).fixed), [3, 30]
    )
