"""The worst quad that corners allow: sines of known angles, and no mesh is better."""

import numpy as np
import pytest

from core.cells.layout import trace_layout
from core.coarsening.corner_shape import corner_shape
from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field
from core.field.distance import arrival_distance
from core.field.propagation import propagate
from core.pipeline import decompose
from core.settings import Settings
from core.surface.surface import build_surface
from tests.core import surfaces


def limit_of(surface):
    constraints = boundary_constraints(surface, np.radians(20))
    angle = propagate(surface, constraints, arrival_distance(surface, constraints.fixed))
    layout = trace_layout(surface, constraints, build_cross_field(surface, angle, constraints))
    return corner_shape(surface, layout)


def sheared_square(degrees, count=10):
    """A rhombus with sides of 1 and corners of so many degrees."""
    x, y = np.meshgrid(np.arange(count + 1) / count, np.arange(count + 1) / count)
    turn = np.radians(degrees)
    points = np.stack([x + np.cos(turn) * y, np.sin(turn) * y, 0 * x], axis=2).reshape(-1, 3)
    first = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    other = first + count + 1
    lower = np.stack([first, first + 1, other + 1], axis=1)
    upper = np.stack([first, other + 1, other], axis=1)
    return build_surface(points, np.concatenate([lower, upper]))


@pytest.mark.parametrize("degrees", [20, 60, 75, 90])
def test_a_rhombus(degrees):
    assert limit_of(sheared_square(degrees)) == pytest.approx(np.sin(np.radians(degrees)))


@pytest.mark.parametrize("name, limit", [("lshape", 1.0), ("disc", 1.0), ("octant", 1.0)])
def test_right_angles_and_no_corners_allow_all(name, limit):
    # The octant is made of plane triangles, whose angles are not quite right ones.
    assert limit_of(getattr(surfaces, name)(8)) == pytest.approx(limit, abs=1e-4)


@pytest.mark.parametrize("degrees", [12, 25, 40])
@pytest.mark.parametrize("coarseness", ["direct", "balanced"])
def test_no_mesh_is_better_and_ours_are_nearly_as_good(degrees, coarseness):
    surface = sheared_square(degrees)
    settings = Settings(quad_count=300, coarseness=coarseness)
    worst = decompose(surface.points, surface.triangles, settings).quads.scaled_jacobian.min()
    limit = limit_of(surface)
    assert 0.9 * limit <= worst <= limit + 1e-9
