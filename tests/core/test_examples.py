"""The shipped examples are clean surfaces with the topology that they are shown for."""

import pathlib

import numpy as np
import pytest

from core.cleaning.cleaning import clean
from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field
from core.field.distance import arrival_distance
from core.field.propagation import propagate
from core.field.singularities import find_singularities
from core.files.mesh_files import read_mesh
from core.surface.refinement import split_boundary_chords
from core.surface.surface import build_surface

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"


@pytest.mark.parametrize("name, loops", [("plate", 4), ("aerofoil", 4), ("octant", 1)])
def test_examples_make_a_field_from_file_to_singularities(name, loops):
    path = EXAMPLES / f"{name}.obj"
    assert path.stat().st_size < 400_000
    mesh = clean(*read_mesh(path))
    assert mesh.warnings == []
    given = build_surface(mesh.points, mesh.triangles)
    assert given.component_count == 1 and given.loop_count == loops
    surface, _ = split_boundary_chords(given)
    constraints = boundary_constraints(surface, np.radians(20))
    angle = propagate(surface, constraints, arrival_distance(surface, constraints.fixed))
    field = build_cross_field(surface, angle, constraints)
    found = find_singularities(surface, field, constraints)
    assert found.index_sum == found.expected_index_sum == 4 * (2 - loops)
    assert len(found) < 20


def test_every_example_is_checked_here():
    names = sorted(path.stem for path in EXAMPLES.glob("*.obj"))
    assert names == ["aerofoil", "octant", "plate"]
