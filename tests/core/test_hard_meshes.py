"""Scans, coarse cages and thin channels: valid by the first way, and in shape.

The folder of meshes lies beside the checkout; without it these tests are skipped.
"""

import pathlib

import pytest

from core.files.mesh_files import read_mesh
from core.pipeline import decompose
from core.settings import Settings

PUBLIC = pathlib.Path(__file__).resolve().parents[2].parent / "shared" / "meshes" / "public"
# The worst scaled Jacobian that the cells as traced must reach.
LEAST = {"blub_fish": 0.5, "penguin": 0.5, "spot_control_quads": 0.4, "hele_shaw_2d": 0.4}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not PUBLIC.is_dir(), reason="the shared meshes are not beside the checkout"),
]


@pytest.mark.parametrize("name", LEAST)
def test_the_first_way_leads_to_quads_in_shape(name):
    points, polygons = read_mesh(PUBLIC / f"{name}.obj")
    result = decompose(points, polygons, Settings(quad_count=5000, coarseness="direct"))
    assert result.way == "direct"
    assert result.quads.scaled_jacobian.min() > LEAST[name]
    assert result.singularities.index_sum == result.singularities.expected_index_sum
