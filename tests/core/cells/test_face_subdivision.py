"""Triangles cut by chords: convex pieces, no area lost, no chord crossed the wrong way."""

import numpy as np
import pytest

from core.cells.face_subdivision import (
    MARGIN,
    Polygon,
    SplitFace,
    aim,
    chord_tag,
    split_polygon,
    tag_line,
)
from core.cells.line_field import build_line_field
from tests.core import surfaces
from tests.core.fields import smooth_field


@pytest.fixture
def split():
    surface = surfaces.octant(4)
    _, field = smooth_field(surface)
    return SplitFace(build_line_field(surface, field, np.flatnonzero(field.index)), 5)


def signed_area(split, polygon):
    x, y = np.array([split.place[p] for p in polygon.points]).T
    return 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)


def random_cuts(split, rng, count):
    point = 10_000
    for line in range(count):
        polygon = split.polygons[rng.integers(len(split.polygons))]
        n = len(polygon.points)
        side, share = int(rng.integers(n)), rng.uniform(MARGIN, 1 - MARGIN)
        a, b = polygon.points[side], polygon.points[(side + 1) % n]
        split.place[point] = tuple(
            (1 - share) * np.array(split.place[a]) + share * np.array(split.place[b])
        )
        polygon.insert(side, point)
        start = polygon.points.index(point)
        target, share, _ = aim(split, polygon, start, rng.uniform(-np.pi, np.pi))
        c = polygon.points[(start + target) % (n + 1)]
        d = polygon.points[(start + target + 1) % (n + 1)]
        split.place[point + 1] = tuple(
            (1 - share) * np.array(split.place[c]) + share * np.array(split.place[d])
        )
        split_polygon(split, polygon, start, target, point + 1, line, int(rng.integers(4)))
        point += 2


@pytest.mark.parametrize("seed", range(5))
def test_pieces_are_convex_and_fill_the_triangle(split, seed):
    whole = signed_area(split, split.polygons[0])
    random_cuts(split, np.random.default_rng(seed), 12)
    assert len(split.polygons) == 13
    assert sum(signed_area(split, p) for p in split.polygons) == pytest.approx(whole, rel=1e-12)
    for polygon in split.polygons:
        place = np.array([split.place[p] for p in polygon.points])
        edge = np.roll(place, -1, axis=0) - place
        turn = edge[:, 0] * np.roll(edge, -1, axis=0)[:, 1] - edge[:, 1] * np.roll(edge, -1, axis=0)[:, 0]
        assert turn.min() > -1e-12 and len(polygon.tags) == len(polygon.points)


def test_the_two_sides_of_a_chord_admit_opposite_branches(split):
    random_cuts(split, np.random.default_rng(3), 8)
    exits = {}
    for polygon in split.polygons:
        for tag in polygon.tags:
            if tag >= 3:
                exits.setdefault(tag_line(tag), set()).add(split.exit_branch(tag))
    assert len(exits) == 8
    assert all(len(e) == 2 and (max(e) - min(e)) == 2 for e in exits.values())


def test_lifting_a_flat_point_is_an_isometry(split):
    lifted = np.array([split.lift(c) for c in split.corner])
    flat = np.array(split.corner)
    for k in range(3):
        assert np.linalg.norm(lifted[k] - lifted[k - 1]) == pytest.approx(
            np.linalg.norm(flat[k] - flat[k - 1]), rel=1e-12
        )


def test_a_ray_leaves_through_the_side_that_it_meets(split):
    start = split.on_side(0, 0.4)
    for side in (1, 2):
        goal = split.on_side(side, 0.3)
        angle = np.arctan2(goal[1] - start[1], goal[0] - start[0])
        found, parameter = split.ray_exit(start, angle, 0)
        assert found == side and parameter == pytest.approx(0.3)


def test_an_outward_ray_is_turned_into_the_polygon(split):
    polygon = split.polygons[0]
    vertex = polygon.points[0]
    toward = np.arctan2(*np.subtract(split.place[polygon.points[1]], split.place[vertex])[::-1])
    side, share, angle = aim(split, polygon, 0, toward - 1.0)
    assert side == 1 and share == MARGIN and toward < angle < toward + 0.1


def test_tags_hold_line_and_exit():
    assert [tag_line(chord_tag(7, e)) for e in range(-4, 4)] == [7] * 8
    assert chord_tag(7, -1) == chord_tag(7, 3) != chord_tag(7, 0)


def test_a_missing_side_is_reported(split):
    with pytest.raises(KeyError):
        split.polygon_with_side(-5, -6, on_line=True)
    assert Polygon([1, 2, 3], [0, 1, 2]).side_from(2, 1, on_line=False) == -1


@pytest.mark.parametrize("name", ["octant", "torus"])
def test_a_branch_leaves_a_triangle_where_the_field_points_out(name):
    surface = surfaces.octant(4) if name == "octant" else surfaces.torus(12, 8)
    _, field = smooth_field(surface, 1.0)
    lines = build_line_field(surface, field, np.flatnonzero(field.index))
    share = np.linspace(0.005, 0.995, 100)
    for face in range(0, len(lines.triangle), 7):
        split = SplitFace(lines, face)
        for side in np.flatnonzero(lines.twin[3 * face : 3 * face + 3] >= 0):
            for branch in range(-5, 4):
                angle = [split.field_angle(side, t, branch) - split.edge_angle[side] for t in share]
                outward = np.sin(angle) < 0
                low, high = split.outward(side, branch) or (2.0, 2.0)
                sure = np.abs(np.sin(angle)) > 1e-3
                assert np.array_equal(outward[sure], ((share > low) & (share < high))[sure])
