"""The chain of ways to a valid mesh: what fails is answered, and the report says how."""

from dataclasses import replace

import numpy as np
import pytest

from core import attempts, stages
from core.blocks.blocks import verify_blocks
from core.errors import LayoutError
from core.features.creases import Creases
from core.features.features import dihedral_angle
from core.pipeline import decompose
from core.run import Run
from core.settings import RELAXATIONS, Settings
from core.ways import FEWER_CREASES, MIDPOINT_SPLIT, ways
from tests.core import creased, surfaces

MAKERS = {
    "disc": lambda: surfaces.disc(5),
    "annulus": lambda: surfaces.annulus(20, 4),
    "voxels": lambda: surfaces.voxel_shell(np.ones((3, 2), bool)),
    "two": lambda: surfaces.together(surfaces.disc(5), surfaces.lshape(4)),
}


def failing(times):
    """A stand-in for fill_cells that fails so many times."""
    fill, left = stages.fill_cells, [times]

    def fill_or_fail(*arguments):
        if left[0]:
            left[0] -= 1
            raise LayoutError("This test allows no layout.")
        return fill(*arguments)

    return fill_or_fail


def run(name, **settings):
    surface = MAKERS[name]()
    return decompose(surface.points, surface.triangles, Settings(quad_count=300, **settings))


@pytest.mark.parametrize("name", MAKERS)
def test_where_no_layout_is_found_every_triangle_is_split(name, monkeypatch):
    monkeypatch.setattr(stages, "fill_cells", failing(99))
    result = run(name)
    assert result.way == result.report()["way"] == MIDPOINT_SPLIT
    quads = result.quads
    assert quads.scaled_jacobian.min() > 0
    verify_blocks(result.blocks, quads.quads)
    edges = np.sort(np.stack([quads.quads, np.roll(quads.quads, -1, 1)], 2).reshape(-1, 2), axis=1)
    euler = len(quads.points) - len(np.unique(edges, axis=0)) + len(quads.quads)
    assert euler == result.whole.euler_characteristic
    assert any("failed" in warning for warning in result.warnings)
    assert result.singularities.index_sum == result.singularities.expected_index_sum


@pytest.mark.parametrize("times, way", [(0, "direct"), (1, "finer field"), (3, "other field")])
def test_the_first_way_that_works_is_taken_and_named(times, way, monkeypatch):
    monkeypatch.setattr(stages, "fill_cells", failing(times))
    result = run("disc")
    assert result.way == way
    assert sum("failed" in warning for warning in result.warnings) == times
    assert result.quads.scaled_jacobian.min() > 0


def test_creases_survive_the_midpoint_split(monkeypatch):
    monkeypatch.setattr(stages, "fill_cells", failing(99))
    result = run("voxels")
    ends = result.quads.points[result.quads.crease]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    assert length == pytest.approx(4 * (3 + 2 + 1))
    inside = np.abs(ends - np.rint(ends)).max(2)
    # Every crease edge keeps two of its coordinates whole: it lies on an edge of the box.
    assert np.all((np.abs(ends - np.rint(ends)) < 1e-9).sum(2) >= 2), inside.max()


def test_without_quads_a_failure_is_a_sentence(monkeypatch):
    def no_layout(*arguments):
        raise LayoutError("No layout.")

    monkeypatch.setattr(stages, "trace_layout", no_layout)
    with pytest.raises(LayoutError):
        run("disc", stop_after="lines")
    assert run("disc").way == MIDPOINT_SPLIT


def test_ways_try_every_relaxation_and_all_creases():
    creases = [np.ones(6, bool), np.zeros(6, bool)]
    for mode in RELAXATIONS:
        tried = ways(creases, Settings(relaxation=mode))
        assert tried[0].name == "direct" and tried[0].settings.relaxation == mode
        assert {way.settings.relaxation for way in tried} == set(RELAXATIONS)
        assert any(not way.crease.any() for way in tried)


def test_large_surfaces_are_not_halved():
    creases = [np.zeros(6, bool)]
    assert any(way.halved for way in ways(creases, Settings()))
    assert not any(way.halved for way in ways(creases, Settings(), may_halve=False))


def test_teeth_two_triangles_wide_get_a_finer_field():
    """A gear: the field between its teeth needs more triangles than the teeth are wide."""
    sides = np.arange(84)
    angle = 2 * np.pi * (sides // 4 + np.array([0, 0.2, 0.6, 0.8])[sides % 4]) / 21
    rim = np.array([0.8, 1, 1, 0.8])[sides % 4] * np.exp(1j * angle)
    place = np.concatenate([rim, 0.2 * np.exp(-2j * np.pi * np.arange(33) / 33)])
    polygon = [*range(84), 0, *range(84, 117), 84]  # to the hole, round it and back
    points = np.stack([place.real, place.imag, 0 * place.real], 1)
    result = decompose(points, [polygon], Settings(quad_count=1000))
    assert result.way in ("direct", "finer field")
    assert len(result.singularities) == 0 and result.quads.scaled_jacobian.min() > 0.5


def test_a_way_that_takes_too_long_is_given_up_for_the_last_one(monkeypatch):
    monkeypatch.setattr(attempts, "PATIENCE", 0.0)
    result = run("voxels")
    assert result.way == MIDPOINT_SPLIT and result.quads.scaled_jacobian.min() > 0
    assert any("longer than" in warning for warning in result.warnings)


def test_creases_beside_inverted_quads_go_first(monkeypatch):
    """One corner of a box is said to be inverted: only the three edges that meet there are lost."""
    fill, left = stages.fill_cells, [1]

    def fold(*arguments):
        filling = fill(*arguments)
        if not left[0]:
            return filling
        left[0] = 0
        jacobian = filling.quads.scaled_jacobian.copy()
        corner = filling.quads.points.sum(1).argmax()
        jacobian[(filling.quads.quads == corner).any(1)] = -1.0
        return replace(filling, quads=replace(filling.quads, scaled_jacobian=jacobian))

    monkeypatch.setattr(stages, "fill_cells", fold)
    surface = surfaces.voxel_shell(np.ones((3, 2), bool))
    result = decompose(surface.points, surface.triangles, Settings(quad_count=300))
    assert result.way == FEWER_CREASES
    ends = result.quads.points[result.quads.crease]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    assert length == pytest.approx(3 * (3 + 2 + 1))


def test_creases_go_first_where_the_layout_failed(monkeypatch):
    fill, left = stages.fill_cells, [1]

    def fail(surface, *arguments):
        if left[0]:
            left[0] = 0
            corner = surface.points[surface.points.sum(1).argmax()]
            raise LayoutError("No quad fits here.", corner[None])
        return fill(surface, *arguments)

    monkeypatch.setattr(stages, "fill_cells", fail)
    surface = surfaces.voxel_shell(np.ones((3, 2), bool))
    result = decompose(surface.points, surface.triangles, Settings(quad_count=300))
    assert result.way == FEWER_CREASES
    ends = result.quads.points[result.quads.crease]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()
    assert length == pytest.approx(3 * (3 + 2 + 1))


def test_marked_edges_are_kept_longer_than_others():
    cube = creased.cube(4)
    mask = dihedral_angle(cube) > 1
    marked = np.zeros_like(mask)
    marked[[edge := np.flatnonzero(mask)[0], cube.twin[edge]]] = True
    masks = Creases(cube, mask, marked).masks()
    assert [int(each.sum()) for each in masks] == [96, 2, 0]


@pytest.mark.parametrize("worst, way", [([1e-9, 0.5], "finer field"), ([1e-9, 3e-9, 2e-9], "finer field")])
def test_a_quad_without_area_makes_way_for_a_better_mesh(worst, way, monkeypatch):
    fill, left = stages.fill_cells, list(worst)

    def fill_badly(*arguments):
        filling = fill(*arguments)
        jacobian = filling.quads.scaled_jacobian.copy()
        jacobian[0] = left.pop(0)
        return replace(filling, quads=replace(filling.quads, scaled_jacobian=jacobian))

    monkeypatch.setattr(stages, "fill_cells", fill_badly)
    result = run("disc")
    assert result.way == way and not left
    assert result.quads.scaled_jacobian[0] == max(worst)


def test_the_time_of_a_failed_stage_counts():
    clock = Run()
    with pytest.raises(LayoutError), clock.stage("lines"):
        raise LayoutError("No layout.")
    assert "lines" in clock.seconds


def test_a_fault_of_the_program_is_told_and_another_way_taken(monkeypatch):
    fill, left = stages.fill_cells, [1]

    def slip(*arguments):
        if left[0]:
            left[0] -= 1
            raise IndexError("index 7 is out of bounds")
        return fill(*arguments)

    monkeypatch.setattr(stages, "fill_cells", slip)
    result = run("disc")
    assert result.way == "finer field" and np.all(result.quads.scaled_jacobian > 0)
    assert any("fault in the program (IndexError" in warning for warning in result.warnings)


def test_a_fault_in_the_last_way_is_one_sentence(monkeypatch):
    def slip(*_):
        raise IndexError("slip")

    monkeypatch.setattr(stages, "fill_cells", slip)
    monkeypatch.setattr(stages, "split_at_midpoints", slip)
    with pytest.raises(LayoutError, match="a fault in the program .*please report it"):
        run("disc")
