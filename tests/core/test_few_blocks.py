"""Coarse layouts on the shared meshes: as few blocks and as good shapes as are promised.

The folder of meshes lies beside the checkout; without it these tests are skipped.
"""

from functools import cache

import numpy as np
import pytest

from core.blocks.blocks import verify_blocks
from core.blocks.thin_blocks import edge_lengths
from core.files.mesh_files import read_mesh
from core.pipeline import decompose
from core.settings import Settings
from tests.core.test_acceptance import QUADS, SHARED

MESHES = {path.stem: path for path in sorted((SHARED / "meshes").glob("*/*.obj"))}
# Most blocks and the least worst scaled Jacobian, by default and with the fewest blocks.
DEFAULT = {
    "plate_25k": (60, 0.7), "aerofoil_25k": (80, 0.6), "g_multielement": (45, 0.6),
    "g_plate_holes": (70, 0.7), "g_seedfig3_like": (70, 0.6), "g_disc": (5, 0.7),
    "octant_25k": (3, 0.7), "halfcyl_25k": (1, 0.7), "g_lshape": (3, 0.7), "g_annulus": (3, 0.7),
    "spot": (180, 0.55), "g_cad_block": (60, 0.7), "three_holes_genus3": (100, 0.6),
    "g_misaligned_slots": (20, 0.7), "spot_control_quads": (400, 0.2), "goathead": (200, 0.5),
}
FEWEST = {"plate_25k": (41, 0.5), "aerofoil_25k": (60, 0.4), "g_multielement": (45, 0.4)}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not MESHES, reason="the shared meshes are not beside the checkout"),
]


@cache
def result(name, coarseness="balanced"):
    return decompose(*read_mesh(MESHES[name]), Settings(quad_count=QUADS, coarseness=coarseness))


@pytest.mark.parametrize("name", DEFAULT)
def test_few_blocks_by_default(name):
    _assert_kept(result(name), *DEFAULT[name])


@pytest.mark.parametrize("name", FEWEST)
def test_fewest_blocks(name):
    _assert_kept(result(name, "fewest"), *FEWEST[name])
    assert result(name, "fewest").blocks.count <= result(name).blocks.count


def _assert_kept(found, most, least):
    assert found.way == "direct" and found.blocks.count <= most
    assert found.quads.scaled_jacobian.min() >= least
    assert abs(len(found.quads.quads) / QUADS - 1) <= 0.1
    verify_blocks(found.blocks, found.quads.quads)
    report = found.report()
    assert report["index_sum"] == report["expected_index_sum"]


@pytest.mark.parametrize("name", [*DEFAULT, "wingnut_cad", "g_wedge15"])
def test_thin_blocks_are_told_with_the_nodes_that_keep_them(name):
    found = result(name)
    corner = found.quads.points[found.quads.quads]
    diagonals = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    area = 0.5 * np.linalg.norm(np.cross(*diagonals), axis=1).sum()
    length = edge_lengths(found.quads.points, found.blocks)
    # Quads span a little less than the curved surface: edges near the limit may count or not.
    surely, maybe = ((length < 0.5 * share * np.sqrt(area / QUADS)).sum() for share in (0.98, 1.02))
    told = [w for w in found.warnings if "shorter than half the wanted edge length" in w]
    counts = [int(w.split()[0].replace(",", "")) for w in told]
    assert len(told) <= 1 and surely <= sum(counts) <= maybe
    rows = found.report()["thin_rows"]
    assert sum(len(row["edges"]) for row in rows) == sum(counts)
    for row in rows:
        assert row["kept_by"] and np.array(row["between"]).shape == (2, 3)
    assert all(f"the {what} at (" in told[0] for row in rows for what in row["kept_by"])
