"""How sides of blocks join: node by node, every side covered once."""

import numpy as np
import pytest

from core.blocks.interfaces import interfaces
from core.divisions.regridding import block_grid
from tests.core.blocks.test_blocks import grid, mesh_of
from tests.core.blocks.test_t_layout import layouts
from tests.core.complexes import disc
from tests.core.rectilinear import plate_quads, random_mask, slab_quads

MESHES = {
    "plate": plate_quads(random_mask(np.random.default_rng(3), 9)),
    "slab": slab_quads(random_mask(np.random.default_rng(4), 7))[:3],
    "disc": mesh_of(disc(), 3),
    "ring": grid(9, 3, (True, False)),
    "torus": grid(8, 6, (True, True), 2),
}


def side_vertices(blocks, block, side):
    """Vertices along a side, counter-clockwise."""
    vertex = block_grid(blocks, block)
    return [vertex[0], vertex[:, -1], vertex[-1, ::-1], vertex[::-1, 0]][side]


@pytest.mark.parametrize("joined", [False, True], ids=["conforming", "t-junctions"])
@pytest.mark.parametrize("mesh", MESHES)
def test_sides_join_node_by_node(mesh, joined):
    blocks = layouts(*MESHES[mesh])[joined]
    covered = {(b, k): [] for b in range(blocks.count) for k in range(4)}
    for number, join in enumerate(interfaces(blocks)):
        assert join["edge"] == number
        assert len(join["sides"]) == (1 if blocks.edge_on_boundary[number] else 2)
        chains = []
        for side in join["sides"]:
            begin, end = side["nodes"]
            covered[side["block"], side["side"]].append((min(begin, end), max(begin, end)))
            along = side_vertices(blocks, side["block"], side["side"])
            step = 1 if end > begin else -1
            chains.append(along[np.arange(begin, end + step, step)].tolist())
        assert all(chain == chains[0] for chain in chains)
    for (block, side), ranges in covered.items():
        ranges = sorted(ranges)
        ends = [0] + [end for _, end in ranges]
        assert [begin for begin, _ in ranges] == ends[:-1]
        assert ends[-1] == blocks.shape[block, side % 2]
