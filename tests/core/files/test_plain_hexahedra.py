"""Hexahedra between the corners of blocks: known depths, and blocks that wind round are cut."""

import numpy as np
import pytest

from core.blocks.blocks import find_blocks, verify_blocks
from core.files.plain_hexahedra import cut_to_plain_hexahedra, hexahedron_depth
from core.pipeline import decompose
from core.settings import Settings
from tests.core import creased

SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
UP = np.array([0, 0, 1.0])


def depth(corners, height=1.0):
    points = np.asarray(corners, float)
    return hexahedron_depth(points, points + height * UP, np.arange(4)[None])[0]


def polar_grid(degrees, along=12, through=3):
    """A block that winds round a circle: points and quads."""
    angle = np.radians(np.linspace(0, degrees, along + 1))
    radius = np.linspace(2, 1, through + 1)[:, None]
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    points = np.stack([x, y, 0 * x], axis=2).reshape(-1, 3)
    number = np.arange(len(points)).reshape(through + 1, along + 1)
    quads = np.stack(
        [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=2
    ).reshape(-1, 4)
    return points, quads


def test_the_centre_of_a_cube_is_half_its_width_inside():
    assert depth(SQUARE) == pytest.approx(0.5)
    assert depth(7 * SQUARE, 7) == pytest.approx(0.5)


def test_turning_a_hexahedron_changes_nothing():
    turned = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turned *= np.linalg.det(turned)
    points = SQUARE * (3, 1, 1) + np.array([[0.2, 0, 0], [0, 0.1, 0], [0, 0, 0.3], [0, 0, 0]])
    both = np.array([points, points + UP])
    wanted = hexahedron_depth(*both, np.arange(4)[None])
    assert np.allclose(hexahedron_depth(*(both @ turned.T), np.arange(4)[None]), wanted)


def test_inside_out():
    assert depth(SQUARE[::-1]) == pytest.approx(-0.5)
    assert depth([(0, 0, 0), (1, 0, 0), (0.4, 0.4, 0), (0, 1, 0)]) > 0
    assert depth([(0, 0, 0), (1, 0, 0), (0.1, 0.1, 0), (0, 1, 0)]) < 0
    assert depth([(0, 0, 0), (1, 1, 0), (0.2, 0, 0), (1, -1, 0)][::-1]) < 0


def test_blocks_in_shape_stay_as_they_are():
    points, quads = polar_grid(60)
    blocks = find_blocks(quads, len(points), np.zeros(len(points), bool))
    parts, owner = cut_to_plain_hexahedra(points, points + UP, quads, blocks)
    assert parts is blocks and owner.tolist() == [0]


@pytest.mark.parametrize("degrees", [200, 270, 350])
def test_blocks_that_wind_round_are_cut(degrees):
    points, quads = polar_grid(degrees)
    blocks = find_blocks(quads, len(points), np.zeros(len(points), bool))
    assert blocks.count == 1
    parts, owner = cut_to_plain_hexahedra(points, points + UP, quads, blocks)
    verify_blocks(parts, quads)
    assert 2 <= parts.count <= 4 and (owner == 0).all()
    assert (hexahedron_depth(points, points + UP, parts.corner) > 0).all()


def test_cuts_go_on_through_the_blocks_beside():
    """Two blocks, one on top of the other, of which only the inner one is too bent."""
    points, quads = polar_grid(175, along=8, through=4)
    blocks = find_blocks(quads, len(points), np.arange(len(points)) == 2 * 9)
    assert blocks.count == 2
    bent = points.copy()
    bent[::9, 1] -= np.repeat([0.0, 1.5], [3, 2])
    parts, owner = cut_to_plain_hexahedra(bent, bent + UP, quads, blocks)
    verify_blocks(parts, quads)
    assert parts.count > 2 and set(owner) == {0, 1}
    assert np.array_equal(owner[parts.quad_block], blocks.quad_block)


@pytest.mark.parametrize("make", [creased.cube, creased.capped_cylinder])
def test_lines_through_the_corners_are_those_between_the_blocks(make):
    """Along creases, too: the parts are cut from the corners, and must not straddle two blocks."""
    surface = make()
    result = decompose(surface.points, surface.triangles, Settings(quad_count=400))
    quads, blocks = result.quads.quads, result.blocks
    corner = np.isin(np.arange(len(result.quads.points)), blocks.corner)
    again = find_blocks(quads, len(corner), corner)
    assert np.array_equal(again.quad_block, blocks.quad_block)


def test_a_single_quad_is_never_cut():
    points = np.array([(0, 0, 0), (1, 1, 0), (0.2, 0, 0), (1, -1, 0)], float)[::-1]
    quads = np.arange(4)[None]
    blocks = find_blocks(quads, 4, np.ones(4, bool))
    parts, _ = cut_to_plain_hexahedra(points, points + UP, quads, blocks)
    assert parts is blocks
