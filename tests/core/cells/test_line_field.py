"""The field on halfedges: consistent branch numbers, and the right number of ports."""

import numpy as np
import pytest

from core.cells.line_field import QUARTER, build_line_field, corner_ports, inserted_ports
from core.surface.surface import next_halfedge
from tests.core import surfaces
from tests.core.fields import smooth_field

MAKERS = {
    "disc": lambda: surfaces.disc(9),
    "octant": lambda: surfaces.octant(10),
    "holes": lambda: surfaces.plate_with_holes(24),
    "sphere": lambda: surfaces.sphere(5),
    "torus": lambda: surfaces.torus(16, 10),
    "crumpled": lambda: surfaces.crumpled(surfaces.annulus(30, 8), 0.15),
}


def line_field(name, noise, seed=1):
    surface = MAKERS[name]()
    constraints, field = smooth_field(surface, noise, seed)
    return surface, constraints, field, build_line_field(surface, field, np.flatnonzero(field.index))


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("noise", [0.0, 0.3, 1.6])
def test_branches_return_to_themselves_round_every_triangle(name, noise):
    _, _, _, lines = line_field(name, noise)
    assert np.all(lines.next_branch.reshape(-1, 3).sum(1) % 4 == 0)


@pytest.mark.parametrize("name", MAKERS)
def test_branches_return_to_themselves_across_every_edge(name):
    _, _, _, lines = line_field(name, 1.6)
    inner = np.flatnonzero(lines.twin >= 0)
    there_and_back = lines.twin_branch[inner] + lines.twin_branch[lines.twin[inner]]
    assert np.all(there_and_back % 4 == 0)


@pytest.mark.parametrize("name", MAKERS)
def test_both_sides_of_an_edge_read_the_same_direction(name):
    _, _, _, lines = line_field(name, 0.5)
    h = np.flatnonzero(lines.twin >= 0)
    twin = lines.twin[h]
    for t in (0.0, 0.3, 1.0):
        here = lines.relative_angle[h] + t * lines.rotation[h]
        there = lines.relative_angle[twin] + (1 - t) * lines.rotation[twin]
        difference = here - np.pi - there - lines.twin_branch[h] * QUARTER
        assert np.abs((difference + np.pi) % (2 * np.pi) - np.pi).max() < 1e-9


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("noise", [0.0, 0.6, 1.6])
def test_a_singularity_sends_out_four_minus_index_lines(name, noise):
    _, _, field, lines = line_field(name, noise)
    assert sorted(lines.inserted_index.tolist()) == sorted(field.index[field.index != 0].tolist())
    for number, index in enumerate(lines.inserted_index):
        ports = inserted_ports(lines, number)
        assert len(ports) == 4 - index
        assert all(p.vertex == lines.inserted[number] for p in ports)
        assert all(0 <= p.angle <= lines.corner_angle[p.halfedge] + 1e-12 for p in ports)


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_ports_are_spread_evenly_round_a_singularity_of_the_plane(noise):
    _, _, _, lines = line_field("disc", noise)
    for number, index in enumerate(lines.inserted_index):
        ports = inserted_ports(lines, number)
        spokes = sorted({p.halfedge for p in ports})
        reach = {}
        total, spoke = 0.0, ports[0].halfedge
        for _ in range(3):
            reach[spoke] = total
            total += lines.corner_angle[spoke]
            spoke = int(lines.twin[next_halfedge(next_halfedge(spoke))])
        assert set(spokes) <= set(reach)
        angles = np.sort([reach[p.halfedge] + p.angle for p in ports])
        gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi))
        # The cross turns by at most 45 degrees in each sector of 90 degrees or more.
        assert gaps.min() > 0.5 * np.pi / 2 and gaps.sum() == pytest.approx(2 * np.pi)


def test_a_regular_point_sends_out_two_perpendicular_lines():
    surface = surfaces.lshape(6, jitter=0.0)
    constraints, field = smooth_field(surface)
    lines = build_line_field(surface, field, [20])
    ports = inserted_ports(lines, 0)
    ends = []
    for port in ports:
        a = lines.point[lines.triangle.ravel()[next_halfedge(port.halfedge)]] - lines.point[port.vertex]
        angle = np.arctan2(a[1], a[0]) + port.angle
        ends.append([np.cos(angle), np.sin(angle)])
    # The field of the L is that of its sides.
    assert np.allclose(np.sort(np.abs(ends), axis=1), [[0, 1]] * 4, atol=1e-9)
    assert len(np.unique(np.rint(ends).astype(int), axis=0)) == 4
    assert constraints.corner.sum() == 6


def test_corner_ports_divide_the_corner_evenly():
    surface = surfaces.lshape(6, jitter=0.0)
    constraints, field = smooth_field(surface)
    lines = build_line_field(surface, field, [])
    vertex = int(np.flatnonzero(constraints.block_count == 3)[0])
    ports = corner_ports(surface, lines, float(field.angle[vertex]), vertex, 3)
    directions = []
    for port in ports:
        along = lines.point[lines.triangle.ravel()[next_halfedge(port.halfedge)]] - lines.point[vertex]
        angle = np.arctan2(along[1], along[0]) + port.angle
        directions.append([np.cos(angle), np.sin(angle)])
        branch = lines.relative_angle[port.halfedge] + port.branch * QUARTER
        assert (branch - port.angle + np.pi) % (2 * np.pi) - np.pi == pytest.approx(0, abs=1e-9)
    assert np.allclose(np.sort(np.abs(directions), axis=1), [[0, 1]] * 2, atol=1e-9)


def test_inserting_points_keeps_the_area_and_knows_the_origin():
    surface, _, field, lines = line_field("holes", 1.6)
    corner = lines.point[lines.triangle]
    area = 0.5 * np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    by_origin = np.bincount(lines.origin_face, area, surface.face_count)
    assert np.allclose(by_origin, surface.face_area)
    tail = lines.triangle.ravel()[lines.halfedge_number]
    assert np.array_equal(tail, surface.tail)
    assert np.count_nonzero(field.index) == len(lines.inserted)


def test_only_a_line_against_the_wall_starts_in_a_sector_that_ends_there():
    """Singularities of every kind in the triangles along the boundary of a wild field."""
    seen = 0
    for seed in range(8):
        _, _, field, lines = line_field("crumpled", 1.6, seed)
        for number in range(len(lines.inserted)):
            ports = inserted_ports(lines, number)
            assert len(ports) == 4 - lines.inserted_index[number]
            branches = []
            for port in ports:
                outer = next_halfedge(port.halfedge)
                if lines.twin[outer] >= 0:
                    continue
                quarter = port.branch + lines.next_branch[port.halfedge] - lines.wall[outer]
                branches.append(int(quarter) % 4)
            assert branches in ([], [3])
            seen += len(branches)
    assert seen > 0
