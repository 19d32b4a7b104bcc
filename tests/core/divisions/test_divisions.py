"""Dividing blocks anew: locks, sizes, grading; what every new grid must satisfy."""

import re
from dataclasses import replace

import numpy as np
import pytest

from core.blocks.blocks import verify_blocks
from core.blocks.chords import divisions, find_chords
from core.divisions.divisions import redivide
from core.divisions.regridding import block_grid
from core.divisions.wall_spacing import Grading, edge_loops, turned_grid
from core.errors import SettingsError
from core.pipeline import decompose
from core.quads.quality import scaled_jacobian
from core.sentences import missed_count
from core.settings import Settings
from core.surface.boundary import build_loops
from tests.core import creased, surfaces

MAKERS = {
    "disc": lambda: surfaces.disc(9),
    "lshape": lambda: surfaces.lshape(8),
    "octant": lambda: surfaces.octant(12),
    "annulus": lambda: surfaces.annulus(36, 8),
    "holes": lambda: surfaces.plate_with_holes(24),
    "half cylinder": lambda: surfaces.cylinder(20, 16, share=0.5),
}


@pytest.fixture(scope="module")
def results():
    made = {}

    def result(name):
        if name not in made:
            surface = _LOCKED[name]()
            made[name] = decompose(surface.points, surface.triangles, Settings(quad_count=900))
        return made[name]

    return result


def demand_valid(before, after):
    """The same blocks, conforming, upright, on the surface and its boundary."""
    verify_blocks(after.blocks, after.quads.quads)
    assert np.array_equal(after.blocks.block_edge, before.blocks.block_edge)
    points = after.quads.points
    assert np.allclose(
        points[after.blocks.corner], before.quads.points[before.blocks.corner], atol=1e-12
    )
    assert after.quads.scaled_jacobian.min() > 0
    assert scaled_jacobian(points, after.quads.quads).min() > 0
    loops, placement = build_loops(before.whole), after.placement
    edge = np.flatnonzero(after.quads.on_boundary)
    on_loop, _ = loops.point(placement.loop[edge], placement.loop_position[edge])
    assert np.abs(on_loop - points[edge]).max(initial=0.0) < 1e-9 * before.whole.diameter
    assert len(after.quads.valence) == len(points)
    assert np.array_equal(np.bincount(after.quads.quads.ravel()), after.quads.valence)


@pytest.mark.parametrize("name", MAKERS)
def test_nothing_asked_changes_nothing(results, name):
    before = results(name)
    after = redivide(before, edge_length=None, quad_count=len(before.quads.quads))
    demand_valid(before, after)
    assert len(after.quads.quads) == len(before.quads.quads)
    for block in range(before.blocks.count):
        old = before.quads.points[block_grid(before.blocks, block)]
        new = after.quads.points[block_grid(after.blocks, block)]
        assert np.abs(old - new).max() < 1e-9


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("wanted", [400, 4000])
def test_the_wanted_number_comes_within_a_tenth(results, name, wanted):
    before = results(name)
    after = redivide(before, quad_count=wanted)
    demand_valid(before, after)
    assert abs(len(after.quads.quads) / wanted - 1) <= 0.1
    assert after.quads.scaled_jacobian.min() > 0.25


@pytest.mark.parametrize("name", MAKERS)
def test_an_edge_length_is_met_on_average(results, name):
    before = results(name)
    area = before.whole.face_area.sum()
    after = redivide(before, edge_length=np.sqrt(area / 2500))
    demand_valid(before, after)
    assert abs(len(after.quads.quads) / 2500 - 1) <= 0.2


@pytest.mark.parametrize("name", MAKERS)
def test_locks_are_met_and_their_chord_follows(results, name):
    before = results(name)
    chord = find_chords(before.blocks).edge_chord
    after = redivide(before, {0: 13})
    demand_valid(before, after)
    count = divisions(after.blocks)
    assert (count[chord == chord[0]] == 13).all()


def test_contradictory_locks_are_refused_with_the_edges(results):
    before = results("lshape")
    first, _, other, _ = before.blocks.block_edge[0].tolist()
    with pytest.raises(SettingsError, match=f"{other}.*{first}|{first}.*{other}"):
        redivide(before, [(first, 5), (other, 6)])


_LOCKED = {**MAKERS, "torus": surfaces.torus}


def _random_locks(chord, rng):
    """Pairs (block edge, divisions): mostly sound ones, and every way to be wrong."""
    edges = rng.integers(0, len(chord), rng.integers(1, 5)).tolist()
    if rng.random() < 0.5:
        edges.append(int(rng.choice(np.flatnonzero(chord == chord[edges[0]]))))
    locks = [[edge, int(rng.integers(1, 25))] for edge in edges]
    if rng.random() < 0.5:
        by_chord = dict(zip(chord[edges].tolist(), (count for _, count in locks)))
        locks = [[edge, by_chord[chord[edge]]] for edge in edges]
    if rng.random() < 0.3:
        locks[0][1] = [0, -3, 2.5, float("nan"), 100_001, 10**6, 10**30][rng.integers(7)]
    if rng.random() < 0.1:
        locks[-1][0] = [-1, len(chord), 10**9][rng.integers(3)]
    return [tuple(lock) for lock in locks]


def _sound(locks, chord):
    """May these locks be met?"""
    wanted = {}
    for edge, count in locks:
        if not (0 <= edge < len(chord) and 1 <= count <= 100_000 and count == int(count)):
            return False
        if wanted.setdefault(chord[edge], count) != count:
            return False
    return True


@pytest.mark.parametrize("name", _LOCKED)
def test_random_locks_are_met_or_refused(results, name):
    before = results(name)
    chord, rng = find_chords(before.blocks).edge_chord, np.random.default_rng(len(name))
    met = refused = 0
    for _ in range(25):
        locks = _random_locks(chord, rng)
        sound = _sound(locks, chord)
        try:
            after = redivide(before, locks)
        except SettingsError as error:
            assert not sound, (locks, error)
            assert str(error).endswith(".") and str(error).count("\n") == 0
            refused += 1
            continue
        assert sound, locks
        demand_valid(before, after)
        for edge, count in locks:
            assert (divisions(after.blocks)[chord == chord[edge]] == count).all()
        met += 1
    assert met and refused


def test_locks_that_make_too_many_quads_are_refused(results):
    before = results("octant")
    with pytest.raises(SettingsError, match="quads, more than 5,000,000"):
        redivide(before, dict.fromkeys(before.blocks.block_edge.ravel().tolist(), 20_000))


def test_kinks_of_the_boundary_stay_vertices():
    surface = surfaces.disc(12)
    points = surface.points.copy()
    # A regular polygon of twelve sides: its corners turn by 30 degrees.
    radius = np.linalg.norm(points[:, :2], axis=1)
    turn = np.mod(np.arctan2(points[:, 1], points[:, 0]), np.pi / 6) - np.pi / 12
    factor = np.cos(np.pi / 12) / np.cos(turn)
    points[:, :2] *= np.where(radius > 0, factor, 1.0)[:, None]
    before = decompose(points, surface.triangles, Settings(quad_count=600))
    kept = before.quads.points[before.placement.fixed]
    assert len(kept) >= 6
    for wanted in (500, 2000):
        after = redivide(before, quad_count=wanted)
        distance = np.linalg.norm(after.quads.points[:, None] - kept, axis=2).min(0)
        assert distance.max() < 1e-9


def first_heights(after, walls):
    """Distances of the first nodes off the walls, from the wall, where they are not on a boundary."""
    loops = build_loops(after.whole)
    edge_loop = edge_loops(after.blocks, after.placement.loop)
    found = []
    for block, side in np.argwhere(np.isin(edge_loop[after.blocks.block_edge], walls)):
        foot, first = turned_grid(after.blocks, block, side)[:2]
        inside = ~after.quads.on_boundary[first]
        point, loop = after.quads.points[first[inside]], after.placement.loop[foot[inside]]
        wall, _ = loops.point(loop, loops.closest(loop, point))
        found.append(np.linalg.norm(point - wall, axis=1))
    return np.concatenate(found)


@pytest.mark.parametrize("name", ["annulus", "octant", "half cylinder", "disc"])
@pytest.mark.parametrize("height", [1e-4, 2e-3])
def test_the_first_height_is_met_all_along_the_wall(results, name, height):
    before = results(name)
    after = redivide(before, grading=Grading(height, 1.2))
    demand_valid(before, after)
    heights = first_heights(after, [0, 1])
    assert len(heights) > 20 and np.abs(heights / height - 1).max() < 0.05


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("height", [1e-4, 2e-3])
def test_graded_cells_keep_their_angles(results, name, height):
    after = redivide(results(name), grading=Grading(height, 1.2))
    assert after.quads.scaled_jacobian.min() > 0.25
    assert scaled_jacobian(after.quads.points, after.quads.quads).min() > 0.25


def test_walls_of_a_folded_plate_are_graded_and_its_crease_stays():
    surface = creased.roof()
    before = decompose(surface.points, surface.triangles, Settings(quad_count=600))
    assert len(before.quads.crease)
    after = redivide(before, grading=Grading(1e-3, 1.2))
    demand_valid(before, after)
    assert np.abs(first_heights(after, [0]) / 1e-3 - 1).max() < 0.05
    on_crease = after.quads.points[np.unique(after.quads.crease)]
    assert np.abs(on_crease[:, 0] - surface.points[:, 0].mean()).max() < 1e-9
    assert after.quads.scaled_jacobian.min() > 0.3


def test_cells_grow_by_the_ratio_until_they_are_regular(results):
    before = results("annulus")
    after = redivide(before, grading=Grading(1e-3, 1.3, (0,)))
    demand_valid(before, after)
    blocks, points = after.blocks, after.quads.points
    edge_loop = edge_loops(blocks, after.placement.loop)
    for block, side in np.argwhere(edge_loop[blocks.block_edge] == 0):
        line = points[turned_grid(blocks, block, side)]
        cell = np.linalg.norm(np.diff(line, axis=0), axis=2)
        ratio = cell[1:] / cell[:-1]
        assert ratio.max() < 1.3 * 1.05 and np.abs(ratio[:3] / 1.3 - 1).max() < 0.05
        assert np.abs(ratio[-2:] - 1).max() < 0.05


def test_only_the_chosen_wall_is_graded(results):
    before = results("annulus")
    after = redivide(before, grading=Grading(1e-3, 1.3, (1,)))
    assert np.abs(first_heights(after, [1]) / 1e-3 - 1).max() < 0.05
    assert first_heights(after, [0]).min() > 1e-2


def test_gradings_that_cannot_be_are_refused(results):
    before = results("annulus")
    with pytest.raises(SettingsError, match="no boundary loop 7"):
        redivide(before, grading=Grading(1e-3, 1.2, (7,)))
    with pytest.raises(SettingsError, match="above the regular spacing"):
        redivide(before, grading=Grading(5.0))
    for wrong in ((0.0, 1.2), (float("nan"), 1.2), (1e-3, 1.0), (1e-3, 99.0)):
        with pytest.raises(SettingsError):
            Grading(*wrong)
    blocks, edge_loop = before.blocks, edge_loops(before.blocks, before.placement.loop)
    block, side = np.argwhere(edge_loop[blocks.block_edge] == 0)[0]
    leaving = int(blocks.block_edge[block, (side + 1) % 4])
    with pytest.raises(SettingsError, match="locked to 5 divisions"):
        redivide(before, {leaving: 5}, Grading(1e-4, 1.2))


def edges_off_walls(blocks, edge_loop):
    """The first edge of each chord of those that leave a wall."""
    block, side = np.nonzero(edge_loop[blocks.block_edge] >= 0)
    edge = np.unique(blocks.block_edge[block, (side + 1) % 4])
    return edge[np.unique(find_chords(blocks).edge_chord[edge], return_index=True)[1]]


@pytest.mark.parametrize("name", ["annulus", "disc", "holes"])
def test_locks_on_lines_from_graded_walls_are_met_or_the_refusal_says_what_would_be(results, name):
    before, grading = results(name), Grading(2e-3, 1.25)
    natural = divisions(redivide(before, grading=grading).blocks)
    walls = edge_loops(before.blocks, before.placement.loop)
    for edge in edges_off_walls(before.blocks, walls)[:3]:
        for count in (natural[edge] + 4, natural[edge], natural[edge] // 3):
            try:
                after = redivide(before, {edge: count}, grading)
            except SettingsError as error:
                assert count < natural[edge]
                advised = int(re.search(r"needs (\d+)", str(error))[1])
                assert count < advised <= natural[edge]
                after = redivide(before, {edge: advised}, grading)
                count = advised
            assert divisions(after.blocks)[edge] == count
            demand_valid(before, after)
            assert np.abs(first_heights(after, range(before.whole.loop_count)) / 2e-3 - 1).max() < 0.05


def test_locks_with_too_many_cells_for_a_first_height_are_refused(results):
    before = results("annulus")
    edge = int(edges_off_walls(before.blocks, edge_loops(before.blocks, before.placement.loop))[0])
    with pytest.raises(SettingsError, match="leaves room for") as refusal:
        redivide(before, {edge: 400}, Grading(1e-2))
    room = int(re.search(r"room for (\d+)", str(refusal.value))[1])
    after = redivide(before, {edge: room}, Grading(1e-2))
    assert divisions(after.blocks)[edge] == room


def test_a_closed_surface_has_no_walls():
    surface = surfaces.sphere(8)
    before = decompose(surface.points, surface.triangles, Settings(quad_count=400))
    with pytest.raises(SettingsError, match="no boundary"):
        redivide(before, grading=Grading(1e-3))
    after = redivide(before, quad_count=1200)
    assert abs(len(after.quads.quads) / 1200 - 1) <= 0.1
    assert after.quads.scaled_jacobian.min() > 0 and not after.quads.on_boundary.any()


def test_without_blocks_there_is_nothing_to_divide():
    surface = MAKERS["lshape"]()
    lines = decompose(surface.points, surface.triangles, Settings(stop_after="lines"))
    with pytest.raises(SettingsError, match="no blocks"):
        redivide(lines, {0: 3})


def test_what_was_said_of_the_number_of_quads_is_not_said_again():
    surface = surfaces.disc(5)
    result = decompose(surface.points, surface.triangles, Settings(quad_count=300))
    missed = missed_count(len(result.quads.quads)) + "7: the nearest number."
    divided = redivide(replace(result, warnings=["Other.", missed]), quad_count=700)
    assert divided.warnings == ["Other."]
