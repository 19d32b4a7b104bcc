"""The lines of T-layouts: few of them, and every part between them four-sided."""

import numpy as np
import pytest

from core.blocks.cutting import edges_between, find_grids
from core.blocks.separatrices import find_sectors, find_separatrices
from core.blocks.t_lines import t_lines
from core.quads.quad_connectivity import connect_quads
from tests.core.blocks.test_blocks import cube, grid, mesh_of
from tests.core.complexes import disc
from tests.core.rectilinear import plate_quads, random_mask, slab_quads


def lines_of(quad, count, longest=np.inf, seed=0):
    """(mesh, (E,) bool lines, number of parts between them)."""
    mesh = connect_quads(quad, count)
    length = np.random.default_rng(seed).uniform(0.5, 2, mesh.edge_count)
    kept = t_lines(mesh, np.zeros(mesh.edge_count, bool), length, longest)
    return mesh, kept, len(find_grids(mesh, kept).shape)


@pytest.mark.parametrize("seed", range(4))
def test_lines_work_on_quads_themselves_as_on_blocks(seed):
    generator = np.random.default_rng(seed)
    quad, count, _, _ = slab_quads(random_mask(generator, 6))
    mesh, kept, _ = lines_of(quad, count, seed=seed)
    # All edges at irregular vertices of a closed surface are kept.
    assert kept[mesh.irregular[mesh.edge_vertex].any(1)].all()
    # Elsewhere lines go straight on, end on another one or cross it.
    ends = np.bincount(mesh.edge_vertex[kept].ravel(), minlength=count)[~mesh.irregular]
    assert set(ends) <= {0, 2, 3, 4}


def test_winding_lines_join_nothing():
    more = 0
    for seed in range(6):
        quad, count, _, _ = slab_quads(random_mask(np.random.default_rng(seed), 7))
        fewest = lines_of(quad, count)[2]
        raced = lines_of(quad, count, longest=0.0)[2]
        assert raced >= fewest
        more += raced > fewest
    assert more


@pytest.mark.parametrize("seed", range(3))
def test_rings_side_by_side_are_cut_along_one_line(seed):
    quad, count = grid(12, 6, (True, False))
    mesh = connect_quads(quad, count)
    between = (mesh.edge_vertex // 12 == 3).all(1)
    length = np.random.default_rng(seed).uniform(0.5, 2, mesh.edge_count)
    kept = t_lines(mesh, between, length)
    assert len(find_grids(mesh, kept).shape) == 2
    ends = np.bincount(mesh.edge_vertex[kept].ravel(), minlength=count)[36:48]
    assert sorted(ends) == [2] * 11 + [4]


@pytest.mark.parametrize("mesh, must, may", [
    (cube(3), 24, 0), (grid(4, 4), 0, 0), (mesh_of(disc(), 2), 12, 0),
    (plate_quads(np.array([[1, 1], [1, 0]])), 0, 2),
    (plate_quads(np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]])), 0, 8),
])
def test_ports(mesh, must, may):
    connected = connect_quads(*mesh)
    fixed = np.zeros(connected.edge_count, bool)
    fixed[connected.edge[connected.boundary]] = True
    sectors = find_sectors(connected, fixed)
    lines = find_separatrices(connected, fixed, sectors)
    assert (lines.must.sum(), lines.may.sum()) == (must, may)
    assert (sectors.size[~sectors.round] == connected.face_count[connected.tail[~sectors.round]]).all()


def test_at_the_end_of_a_slit_one_line_goes_straight_on():
    # Four quads lie round the end of the slit: of three ports only the middle one makes two and two.
    quad, count = grid(6, 6)
    mesh = connect_quads(quad, count)
    fixed = np.zeros(mesh.edge_count, bool)
    slit = np.array([[21, 22], [22, 23], [23, 24]])
    fixed[edges_between(mesh, slit)] = True
    walls = fixed.copy()
    walls[mesh.edge[mesh.boundary]] = True
    sectors = find_sectors(mesh, walls)
    lines = find_separatrices(mesh, walls, sectors)
    end = mesh.tail == 24
    assert sectors.size[end].tolist() == [4] * 4
    assert mesh.head[end & lines.may].tolist() == [25]
    kept = t_lines(mesh, fixed, np.ones(mesh.edge_count))
    assert len(find_grids(mesh, kept).shape) == 2
