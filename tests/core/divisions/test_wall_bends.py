"""Nodes at bends of walls: found by arc length, met by the nearest nodes, never crowded."""

import numpy as np

from core.divisions.regridding import edge_arcs, edge_directions
from core.divisions.wall_bends import edge_bends, moved_to_bends
from core.pipeline import decompose
from core.settings import Settings
from core.surface.boundary import build_loops


def test_the_nearest_node_moves_to_a_bend_and_the_others_share():
    place, kept = np.linspace(0, 1, 6), np.zeros(6, bool)
    moved = moved_to_bends(place, np.array([0.43]), kept)
    assert np.allclose(moved, [0, 0.215, 0.43, 0.62, 0.81, 1])


def test_kept_nodes_and_ends_stay():
    place, kept = np.linspace(0, 1, 6), np.arange(6) == 2
    assert np.array_equal(moved_to_bends(place, np.array([0.43, 0.01]), kept), place)


def test_nodes_are_not_crowded_by_bends_close_to_each_other():
    place, kept = np.linspace(0, 1, 11), np.zeros(11, bool)
    bends = np.sort(np.random.default_rng(5).random(40))
    moved = moved_to_bends(place, bends, kept)
    assert np.diff(moved).min() > 0.03 and np.isin(moved[1:-1], bends).sum() >= 3


def test_bends_of_a_polygon_are_its_corners():
    count = 12
    angle = 2 * np.pi * np.arange(count) / count
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    points = np.concatenate([rim, [[0, 0, 0]]])
    fan = [[k, (k + 1) % count, count] for k in range(count)]
    result = decompose(points, fan, Settings(quad_count=300, kink_angle=np.radians(60)))
    blocks, placement, surface = result.blocks, result.placement, result.whole
    arcs, loops = edge_arcs(surface, placement, blocks), build_loops(surface)
    direction = edge_directions(blocks)
    bends = edge_bends(loops, placement, blocks, arcs, direction)
    found = []
    for edge in np.flatnonzero(blocks.edge_on_boundary):
        arc, start = arcs[edge], blocks.edge_vertex[blocks.edge_offset[edge]]
        at = np.interp(bends[edge], np.linspace(0, 1, len(arc)), arc)
        along = placement.loop_position[start] + direction[edge] * at
        found.append(loops.point(np.full(len(at), placement.loop[start]), along)[0])
    found = np.concatenate(found)
    distance = np.linalg.norm(found[:, None] - rim, axis=2).min(1)
    assert len(found) >= count - 4 and np.allclose(distance, 0, atol=1e-9)
    assert all(len(b) == 0 for b, on in zip(bends, blocks.edge_on_boundary) if not on)
