"""Whatever goes in, a valid mesh or one sentence comes out: random domains, solids, broken meshes."""

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from core.errors import CrossfieldError
from core.pipeline import decompose
from core.settings import Settings
from tests.core import surfaces

pytestmark = pytest.mark.slow

PATIENT = settings(
    max_examples=12, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)


def check(points, polygons, valid_only=False, **chosen):
    """Decompose; the result must be a valid quad mesh of the surface that was made of the input."""
    try:
        result = decompose(points, polygons, Settings(quad_count=300, **chosen))
    except CrossfieldError as error:
        assert not valid_only, error
        assert len(str(error).splitlines()) == 1 and str(error).endswith(".")
        return
    quads = result.quads.quads
    assert np.all(result.quads.scaled_jacobian > 0)
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], 2).reshape(-1, 2), axis=1)
    edge, count = np.unique(edges, axis=0, return_counts=True)
    assert count.max() <= 2 and np.isfinite(result.quads.points).all()
    euler = len(result.quads.points) - len(edge) + len(quads)
    assert euler == result.whole.euler_characteristic
    assert np.array_equal(np.unique(edge[count == 1]), np.flatnonzero(result.quads.on_boundary))
    assert result.singularities.index_sum == result.singularities.expected_index_sum


@PATIENT
@given(st.integers(3, 14), st.integers(0, 10**6), st.floats(0.1, 1.0))
def test_star_shaped_polygons(corners, seed, least):
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(corners) + rng.uniform(0, 0.6, corners)) / corners
    radius = rng.uniform(least, 1.0, corners)
    points = np.c_[radius * np.cos(angle), radius * np.sin(angle), np.zeros(corners)]
    check(points, [list(range(corners))], valid_only=True)


@PATIENT
@given(st.integers(2, 6), st.integers(2, 6), st.integers(0, 10**6), st.floats(0.0, 0.3))
def test_plates_with_random_holes(columns, rows, seed, jitter):
    mask = np.random.default_rng(seed).random((columns, rows)) < 0.75
    if mask.any():
        wide = np.kron(mask, np.ones((3, 3), bool))
        try:
            surface = surfaces.plate(wide, jitter=jitter, seed=seed)
        except CrossfieldError:
            return  # squares that touch in a corner only are no surface for the maker of the test
        check(surface.points, surface.triangles, valid_only=True)


@PATIENT
@given(st.integers(1, 3), st.integers(1, 3), st.integers(0, 10**6), st.floats(0.0, 0.15))
def test_crumpled_solids(columns, rows, seed, amount):
    mask = np.random.default_rng(seed).random((columns, rows)) < 0.8
    if mask.any():
        try:
            surface = surfaces.crumpled(surfaces.voxel_shell(np.kron(mask, np.ones((2, 2)))), amount)
        except CrossfieldError:
            return
        check(surface.points, surface.triangles, valid_only=True)


@PATIENT
@given(st.integers(0, 10**6), st.sampled_from(["turn", "drop", "repeat", "weld", "spoil", "scale"]))
def test_broken_meshes(seed, kind):
    rng = np.random.default_rng(seed)
    surface = surfaces.disc(7) if seed % 2 else surfaces.octant(8)
    points, triangles = surface.points.copy(), surface.triangles.copy()
    chosen = rng.random(len(triangles)) < 0.15
    if kind == "turn":
        triangles[chosen] = triangles[chosen][:, ::-1]
    elif kind == "drop":
        triangles = triangles[~chosen]
    elif kind == "repeat":
        triangles = np.concatenate([triangles, triangles[chosen]])
    elif kind == "weld":
        target = rng.integers(0, len(points), 3)
        triangles = np.where(triangles == target[0], target[1], triangles)
    elif kind == "spoil":
        points[rng.integers(0, len(points))] = np.nan
    else:
        points = points * 10.0 ** rng.uniform(-7, 7) + 10.0 ** rng.uniform(-3, 5)
    check(points, triangles)


@PATIENT
@given(st.integers(3, 9), st.integers(1, 14), st.integers(0, 10**6))
@example(7, 14, 643)
def test_random_triangles(vertices, count, seed):
    rng = np.random.default_rng(seed)
    triangles = np.array([rng.choice(vertices, 3, replace=False) for _ in range(count)])
    check(rng.normal(size=(vertices, 3)), triangles)
