"""The surface cut along feature edges: copies of vertices, slits, shared nodes."""

import numpy as np
import pytest

from core.features.charts import cut_along, share_nodes
from core.features.features import detect_features, marked_features
from core.field.constraints import boundary_constraints
from core.surface.surface import build_surface
from tests.core import creased
from tests.core.surfaces import plate, sphere

KINK = np.radians(20)


def cut(surface, pairs=None):
    if pairs is None:
        crease = detect_features(surface, np.radians(40), np.radians(20))
    else:
        crease = marked_features(surface, np.arange(surface.vertex_count), pairs)
    return cut_along(surface, crease)


def random_marks(surface, seed):
    """Some edges of a surface, chosen at random."""
    edge = surface.edges
    chosen = edge[np.random.default_rng(seed).random(len(edge)) < 0.1]
    return np.stack([surface.tail[chosen], surface.head[chosen]], 1)


def blocks_round(charts, constraints):
    """Sum of n_b over the copies of each vertex, and number of copies, by first copy."""
    count = len(charts.first_copy)
    return (
        np.bincount(charts.first_copy, constraints.block_count, count),
        np.bincount(charts.first_copy, charts.surface.on_boundary, count),
    )


@pytest.mark.parametrize("refine", [1, 3])
def test_a_cube_falls_into_six_squares(refine):
    surface = creased.cube(refine)
    charts, _ = cut(surface)
    assert charts.surface.component_count == charts.surface.loop_count == 6
    assert charts.surface.euler_characteristic == 6
    assert charts.whole.euler_characteristic == 2
    total, copies = blocks_round(
        charts, share_nodes(charts, boundary_constraints(charts.surface, KINK))
    )
    assert sorted(total[copies == 3]) == [3] * 8
    assert (total[copies == 2] == 4).all() and (copies == 2).sum() == 12 * (refine - 1)


@pytest.mark.parametrize("seed", range(12))
def test_both_surfaces_are_the_same_but_for_the_cut(seed):
    surface = [plate(np.ones((7, 5))), sphere(4), creased.block(2)][seed % 3]
    charts, origin = cut(surface, random_marks(surface, seed))
    cut_surface, whole = charts.surface, charts.whole
    assert np.array_equal(cut_surface.points[: surface.vertex_count], surface.points)
    assert np.allclose(
        cut_surface.points[cut_surface.triangles], whole.points[whole.triangles], atol=0
    )
    copy = charts.first_copy
    assert np.array_equal(cut_surface.points[copy], cut_surface.points)
    assert np.array_equal(copy[copy], copy) and (copy <= np.arange(len(copy))).all()
    assert whole.euler_characteristic == surface.euler_characteristic
    assert whole.loop_count == surface.loop_count
    assert np.isclose(whole.face_area.sum(), surface.face_area.sum())
    assert (np.diff(origin) >= 0).all() and origin[-1] == surface.face_count - 1
    across = charts.across
    on_cut = np.flatnonzero(across >= 0)
    assert np.array_equal(across[across[on_cut]], on_cut)
    assert np.array_equal(copy[cut_surface.tail[on_cut]], copy[cut_surface.head[across[on_cut]]])
    assert (cut_surface.twin[on_cut] < 0).all()


def test_a_slit_has_single_ends_where_four_blocks_meet():
    surface = plate(np.ones((8, 8)))
    pairs = creased.edges_on(
        surface, lambda p: np.isclose(p[:, 0], 4) & (p[:, 1] > 1.5) & (p[:, 1] < 6.5)
    )
    charts, _ = cut(surface, pairs)
    constraints = share_nodes(charts, boundary_constraints(charts.surface, KINK))
    assert charts.surface.loop_count == 2 and charts.surface.component_count == 1
    assert charts.surface.vertex_count == charts.whole.vertex_count + 3
    ends = np.flatnonzero(constraints.block_count == 4)
    assert np.allclose(charts.surface.angle_sum[ends], 2 * np.pi)
    assert sorted(charts.surface.points[ends, 1]) == [2, 6]
    total, copies = blocks_round(charts, constraints)
    assert (total[(copies == 2)] == 4).all()


def test_a_single_marked_edge_is_split_so_that_it_opens():
    surface = plate(np.ones((6, 6)))
    pairs = creased.edges_on(
        surface, lambda p: np.isclose(p[:, 0], 3) & np.isclose(np.abs(p[:, 1] - 2.5), 0.5)
    )
    assert len(pairs) == 1
    charts, origin = cut(surface, pairs)
    assert charts.surface.loop_count == 2
    assert (charts.across >= 0).sum() == 4
    assert len(origin) >= surface.face_count + 2


def test_nodes_are_nodes_on_all_copies():
    charts, _ = cut(creased.block(3))
    constraints = share_nodes(charts, boundary_constraints(charts.surface, KINK))
    total, copies = blocks_round(charts, constraints)
    assert sorted(total[copies == 3]) == [3] * 10 + [5] * 2
    node = constraints.corner | constraints.kink
    assert np.array_equal(node, np.isin(charts.first_copy, charts.first_copy[node]) & (
        charts.surface.on_boundary
    ))
    # Three flat sectors still meet in a node.
    surface = plate(np.ones((8, 8)))
    pairs = creased.edges_on(
        surface, lambda p: np.isclose(p[:, 0], 4) | np.isclose(p[:, 1], 4) & (p[:, 0] > 3.5)
    )
    charts, _ = cut(surface, pairs)
    constraints = share_nodes(charts, boundary_constraints(charts.surface, KINK))
    centre = np.isclose(charts.surface.points, [4, 4, 0]).all(1)
    assert sorted(constraints.block_count[centre]) == [1, 1, 2]
    assert constraints.kink[centre].sum() == 1


def test_at_least_three_blocks_meet_inside():
    # A double cone with its rim as crease and the crease again over both tips.
    angle = 2 * np.pi * np.arange(6) / 6
    rim = np.c_[np.cos(angle), np.sin(angle), np.zeros(6)]
    points = np.concatenate([rim, [[0, 0, 1.2], [0, 0, -1.2]]])
    after = np.roll(np.arange(6), -1)
    triangles = np.concatenate(
        [np.stack([np.arange(6), after, np.full(6, 6)], 1),
         np.stack([after, np.arange(6), np.full(6, 7)], 1)]
    )
    surface = build_surface(points, triangles)
    charts, _ = cut(surface, [(6, 0), (6, 3)])
    constraints = share_nodes(charts, boundary_constraints(charts.surface, KINK))
    tip = charts.first_copy == 6
    assert (charts.surface.angle_sum[tip] > np.pi / 2).all()
    assert sorted(constraints.block_count[tip]) == [1, 2]
