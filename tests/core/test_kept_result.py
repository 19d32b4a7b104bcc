"""What is kept of a decomposition: it comes back the same, divides and exports the same."""

from dataclasses import fields

import numpy as np
import pytest

from core.divisions.divisions import redivide
from core.divisions.wall_spacing import Grading
from core.errors import InputError
from core.files.plot3d import plot3d_grid
from core.kept_result import from_arrays, to_arrays
from core.pipeline import decompose
from core.settings import Settings
from tests.core import creased, surfaces

MAKERS = {
    "holes": lambda: surfaces.plate_with_holes(24),
    "octant": lambda: surfaces.octant(12),
    "cube": lambda: creased.cube(6),
}


@pytest.fixture(scope="module", params=MAKERS)
def made(request):
    surface = MAKERS[request.param]()
    points, triangles = (
        (surface.points, surface.triangles) if hasattr(surface, "triangles") else surface
    )
    result = decompose(points, triangles, Settings(quad_count=600))
    return result, from_arrays(to_arrays(result))


def demand_alike(first, second, parts=("blocks", "placement", "quads")):
    for part in parts:
        for field in fields(getattr(first, part)):
            there = getattr(getattr(second, part), field.name)
            assert np.array_equal(getattr(getattr(first, part), field.name), there), field.name


def test_everything_kept_comes_back(made):
    first, second = made
    demand_alike(first, second, ("blocks", "placement", "quads", "singularities"))
    assert np.array_equal(first.whole.points, second.whole.points)
    assert np.array_equal(first.whole.triangles, second.whole.triangles)
    assert np.array_equal(first.whole.loop_halfedges, second.whole.loop_halfedges)
    assert np.array_equal(first.face_origin, second.face_origin)
    assert second.settings == first.settings and second.way == first.way
    assert second.warnings == first.warnings and second.sentence() == first.sentence()


def test_only_flat_arrays_of_two_types(made):
    for name, value in to_arrays(made[0]).items():
        if not isinstance(value, str):
            assert value.ndim == 1 and value.dtype in (np.float64, np.int32), name


def test_new_divisions_are_the_same(made):
    # Lengths of the surface are measured anew, so the last digits may differ.
    first, second = (redivide(result, {0: 9}) for result in made)
    assert np.array_equal(first.quads.quads, second.quads.quads)
    assert np.allclose(first.quads.points, second.quads.points, atol=1e-9)
    assert plot3d_grid(second.quads.points, second.blocks)


def test_grading_is_the_same():
    surface = MAKERS["holes"]()
    first = decompose(surface.points, surface.triangles, Settings(quad_count=600))
    second = from_arrays(to_arrays(first))
    first, second = (redivide(r, (), Grading(0.005)) for r in (first, second))
    assert np.array_equal(first.blocks.shape, second.blocks.shape)
    assert np.allclose(first.quads.points, second.quads.points, atol=1e-9)


def test_kept_twice_is_kept_once(made):
    once = to_arrays(made[0])
    twice = to_arrays(made[1])
    assert once.keys() == twice.keys()
    assert all(np.array_equal(once[name], twice[name]) for name in once)


def test_t_junctions_are_kept():
    surface = MAKERS["cube"]()
    settings = Settings(quad_count=300, t_junctions=True)
    first = decompose(surface.points, surface.triangles, settings)
    kept = to_arrays(first)
    second = from_arrays(kept)
    demand_alike(first, second, ("blocks", "layout"))
    assert second.layout.count == first.layout.count <= first.blocks.count
    kept["t_edges"] = kept["t_edges"][:-1]
    with pytest.raises(InputError, match="decompose the mesh again"):
        from_arrays(kept)


def test_settings_of_other_versions_are_read():
    surface = MAKERS["octant"]()
    kept = to_arrays(decompose(surface.points, surface.triangles, Settings(quad_count=99)))
    kept["settings"] = kept["settings"][:-1] + ', "unheard_of": 1}'
    assert from_arrays(kept).settings.quad_count == 99


@pytest.mark.parametrize("name", ["blocks.corner", "surface.points", "quads.quads", "settings"])
def test_damage_is_one_sentence(made, name):
    kept = to_arrays(made[0])
    for damaged in (
        {k: v for k, v in kept.items() if k != name},
        kept | {name: kept[name][:-1]},
    ):
        with pytest.raises(InputError, match="decompose the mesh again"):
            from_arrays(damaged)
