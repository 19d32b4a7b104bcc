"""Boundary layers on the shared aerofoils: the first height is met along all walls.

The folder of meshes lies beside the checkout; without it these tests are skipped.
"""

import numpy as np
import pytest

from core.divisions.divisions import redivide
from core.divisions.wall_spacing import Grading
from core.files.mesh_files import read_mesh
from core.pipeline import decompose
from core.settings import Settings
from tests.core.divisions.test_divisions import demand_valid, first_heights
from tests.core.test_acceptance import SHARED

MESHES = {name: SHARED / "meshes" / f"{name}.obj" for name in (
    "peers/aerofoil_25k", "generated/g_naca0012", "generated/g_multielement",
)}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not SHARED.exists(), reason="the shared meshes are not beside the checkout"
    ),
]


@pytest.mark.parametrize("name", MESHES)
def test_a_first_height_of_a_ten_thousandth_is_met_within_five_percent(name):
    before = decompose(*read_mesh(MESHES[name]), Settings(quad_count=5000))
    after = redivide(before, grading=Grading(1e-4, 1.2))
    demand_valid(before, after)
    missed = np.abs(first_heights(after, range(before.whole.loop_count)) / 1e-4 - 1) > 0.05
    assert missed.mean() < 0.002
