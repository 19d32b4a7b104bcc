"""The shipped examples are what the docs say they are, and decompose as their shapes ask."""

from pathlib import Path

import numpy as np
import pytest

from core.files.mesh_files import read_mesh
from core.pipeline import decompose
from core.settings import Settings

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"


@pytest.mark.parametrize(
    "name, loops, euler, fewest, most",
    [("plate", 4, -2, 4, 14), ("aerofoil", 4, -2, 0, 16), ("octant", 1, 1, 1, 1)],
)
def test_examples_decompose(name, loops, euler, fewest, most):
    points, polygons = read_mesh(EXAMPLES / f"{name}.obj")
    result = decompose(points, polygons, Settings(quad_count=2000))
    assert result.surface.loop_count == loops
    assert result.surface.euler_characteristic == euler
    assert fewest <= len(result.singularities.k) <= most
    assert result.singularities.index_sum == result.singularities.expected_index_sum
    quads = result.quads.quads
    sides = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    number = len(np.unique(sides, axis=0))
    assert len(result.quads.points) - number + len(quads) == euler
    assert result.quads.scaled_jacobian.min() > 0.3
    assert 1700 <= len(quads) <= 2300


def test_octant_has_three_blocks_round_one_singularity():
    points, polygons = read_mesh(EXAMPLES / "octant.obj")
    result = decompose(points, polygons, Settings(quad_count=300))
    assert result.singularities.valence.tolist() == [3]
    assert result.blocks.count == 3
    off_centre = result.singularities.position[0] - np.full(3, 1 / np.sqrt(3))
    assert np.linalg.norm(off_centre) < 0.1


def test_the_plate_of_the_readme_has_few_blocks_by_default():
    """Two of its arcs can only be zero: the coarse lengths must give way elsewhere."""
    points, polygons = read_mesh(EXAMPLES / "plate.obj")
    traced = decompose(points, polygons, Settings(quad_count=1500, coarseness="direct"))
    default = decompose(points, polygons, Settings(quad_count=1500))
    assert 3 * default.blocks.count < traced.blocks.count
    assert default.quads.scaled_jacobian.min() > 0.7
