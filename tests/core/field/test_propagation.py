"""Propagated crosses: exact beside straight walls, minimal for their element, complete everywhere."""

import time

import numpy as np
import pytest

from core.field.constraints import Constraints, boundary_constraints
from core.field.cross_field import build_cross_field, direction_vectors, wrap
from core.field.distance import arrival_distance
from core.field.propagation import propagate, smoothness_term
from core.field.singularities import find_singularities
from core.surface.surface import build_surface
from tests.core.surfaces import (
    annulus,
    crumpled,
    cylinder,
    disc,
    lshape,
    octant,
    plate,
    plate_with_holes,
    regular_polygon,
    sphere,
    together,
    torus,
)

KINK = np.radians(20)


def propagated(surface, constraints=None):
    constraints = constraints or boundary_constraints(surface, KINK)
    arrival = arrival_distance(surface, constraints.fixed)
    return propagate(surface, constraints, arrival), constraints, arrival


def plane_angle(surface, angle):
    """Cross angles against the x axis, for surfaces in the plane."""
    vector = direction_vectors(surface, angle)
    return np.arctan2(vector[:, 1], vector[:, 0])


def gradient_energy(corners, values):
    """Dirichlet energy of the linear function on a plane triangle, by its gradient."""
    matrix = np.column_stack([corners, np.ones(3)])
    gradient = np.linalg.solve(matrix, values)[:2]
    area = 0.5 * abs(np.linalg.det(matrix))
    return area * gradient @ gradient


def test_closed_form_is_the_minimiser():
    """Against a parabola through three values of the energy, on random acute elements."""
    random = np.random.default_rng(1)
    for _ in range(200):
        base, away = random.uniform(0.2, 2, 2)
        along, first, second = random.uniform(0, base), *random.uniform(-1, 1, 2)
        corners = np.array([[0, 0], [base, 0], [along, away]])
        low, middle, high = (gradient_energy(corners, [first, second, t]) for t in (-1, 0, 1))
        minimiser = 0.5 * (low - high) / (low - 2 * middle + high)
        numerator, denominator = smoothness_term(
            np.array([base]), np.array([[along, away]]), first, second
        )
        assert numerator[0] / denominator[0] == pytest.approx(minimiser, abs=1e-10)
        # With the half of the energy's second derivative as denominator, terms can be added up.
        assert denominator[0] == pytest.approx(0.5 * (low - 2 * middle + high) * 2, rel=1e-9)


def test_obtuse_elements_do_not_extrapolate():
    base, apex = np.array([1.0, 1.0]), np.array([[-0.5, 0.2], [1.5, 0.2]])
    numerator, denominator = smoothness_term(base, apex, np.array([0.1, 0.1]), np.array([0.7, 0.7]))
    assert numerator / denominator == pytest.approx([0.1, 0.7], abs=1e-15)


def test_single_parent_hands_on_its_cross():
    numerator, denominator = smoothness_term(
        np.zeros(1), np.array([[0.3, 0.0]]), np.array([0.2]), np.array([0.2])
    )
    assert numerator / denominator == pytest.approx([0.2], abs=1e-15)


@pytest.mark.parametrize(
    "surface", [plate(np.ones((20, 12)), 0.1, 0.25), plate_with_holes(), lshape(9)]
)
def test_straight_walls_are_exact(surface):
    angle, _, _ = propagated(surface)
    assert np.abs(wrap(plane_angle(surface, angle))).max() < 1e-12


def test_straight_walls_are_exact_in_any_direction_and_scale():
    flat = plate(np.ones((20, 12)), 0.1, 0.25)
    turned = np.array([[0.28, -0.96, 0], [0.96, 0.28, 0], [0, 0, 1]])
    surface = build_surface(3e-7 * flat.points @ turned.T, flat.triangles)
    angle, _, _ = propagated(surface)
    wall = np.arctan2(0.96, 0.28)
    assert np.abs(wrap(plane_angle(surface, angle) - wall)).max() < 1e-12


def test_cross_beside_each_wall_of_a_polygon_is_that_of_the_wall():
    surface = regular_polygon(5, 16, 0.1)
    angle, _, _ = propagated(surface)
    points = surface.points[:, :2]
    sector = np.floor(5 * np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi)).astype(int)
    middle = (sector + 0.5) * 2 * np.pi / 5
    inradius = np.cos(np.pi / 5)
    from_wall = inradius - (points[:, 0] * np.cos(middle) + points[:, 1] * np.sin(middle))
    along = np.abs(points[:, 1] * np.cos(middle) - points[:, 0] * np.sin(middle))
    near = (from_wall > 1e-9) & (from_wall < 0.25) & (along < 0.2)
    assert np.count_nonzero(near) > 30
    deviation = wrap(plane_angle(surface, angle) - middle)
    assert np.abs(deviation[near]).max() < 1e-12


def test_folding_the_paper_changes_nothing():
    """An accordion is isometric to the plane; sheared needles go through virtual elements."""
    mask = np.ones((10, 10))
    mask[4:6, 3:5] = 0
    flat = plate(mask, 0.1)
    points = flat.points.copy()
    points[:, 1] += 1.7 * points[:, 0] + np.random.default_rng(2).uniform(0, 0.01, len(points))
    flat = build_surface(points, flat.triangles)
    column = np.rint(points[:, 0] / 0.1)
    folded = build_surface(
        np.c_[0.8 * points[:, 0], points[:, 1], 0.06 * (column % 2)], flat.triangles
    )
    assert np.count_nonzero(flat.corner_angle > np.radians(100)) > 20
    in_plane, on_fold = propagated(flat)[0], propagated(folded)[0]
    assert np.abs(wrap(in_plane - on_fold)).max() < 1e-10


def test_crosses_on_a_cylinder_follow_its_axis():
    surface = cylinder(40, 20)
    angle, _, _ = propagated(surface)
    vector = direction_vectors(surface, angle)
    upright = np.abs(vector[:, 2])
    assert np.minimum(upright, 1 - upright).max() < 1e-6


def test_annulus_crosses_point_outwards():
    surface = annulus(60, 16)
    angle, _, _ = propagated(surface)
    radial = np.arctan2(surface.points[:, 1], surface.points[:, 0])
    deviation = wrap(plane_angle(surface, angle) - radial)
    assert np.abs(deviation).max() < np.radians(360 / 60 / 2)


def test_disc_crosses_are_nearly_radial_where_the_wall_is_nearest():
    worst = []
    for rings in (8, 16, 32):
        surface = disc(rings)
        angle, _, _ = propagated(surface)
        radius = np.linalg.norm(surface.points, axis=1)
        radial = np.arctan2(surface.points[:, 1], surface.points[:, 0])
        outer = radius > 0.5
        worst.append(np.abs(wrap(plane_angle(surface, angle) - radial))[outer].mean())
    assert worst[2] < worst[1] < worst[0] < 0.03


@pytest.mark.parametrize(
    "surface",
    [
        disc(14),
        lshape(10),
        plate_with_holes(),
        octant(12),
        regular_polygon(6, 12),
        torus(),
        sphere(8),
        crumpled(octant(10), 0.7),
        together(disc(5), sphere(5), annulus(20, 5)),
    ],
)
def test_index_sum_is_what_topology_asks(surface):
    angle, constraints, _ = propagated(surface)
    assert np.isfinite(angle).all()
    assert np.abs(wrap(angle - constraints.angle))[constraints.fixed].max(initial=0) < 1e-12
    field = build_cross_field(surface, angle, constraints)
    found = find_singularities(surface, field, constraints)
    assert found.index_sum == found.expected_index_sum == 4 * surface.euler_characteristic


def test_singularities_of_plain_shapes_are_few():
    for surface, least, most in ((lshape(16), 0, 0), (octant(16), 1, 7), (disc(16), 4, 12)):
        angle, constraints, _ = propagated(surface)
        field = build_cross_field(surface, angle, constraints)
        assert least <= np.count_nonzero(field.index) <= most


def sequentially(surface, constraints, arrival):
    """One vertex after the other in the order of distance, each at the foot of its altitude."""
    angle = np.where(arrival.source, constraints.angle, 0.0)
    for v in np.argsort(arrival.distance, kind="stable").tolist():
        if arrival.source[v]:
            continue
        first, second = angle[arrival.parent[v]] + arrival.transport[v]
        share = arrival.apex[v, 0] / arrival.base[v] if arrival.base[v] else 0.0
        angle[v] = first + min(max(share, 0.0), 1.0) * wrap(second - first)
    return angle


@pytest.mark.parametrize("surface", [disc(12), crumpled(octant(10), 0.5), plate_with_holes()])
def test_levels_give_what_one_after_the_other_gives(surface):
    angle, constraints, arrival = propagated(surface)
    difference = wrap(angle - sequentially(surface, constraints, arrival))
    # Where a quarter turn could be matched either way, rounding decides.
    assert np.quantile(np.abs(difference), 0.98) < 1e-9


def test_single_fixed_cross_in_the_plane_is_parallel_everywhere():
    surface = plate(np.ones((15, 15)), 1.0, 0.4)
    vertex = int(np.argmin(np.linalg.norm(surface.points[:, :2] - 7, axis=1)))
    fixed = np.arange(surface.vertex_count) == vertex
    zero = np.zeros(surface.vertex_count, np.int64)
    constraints = Constraints(fixed, np.where(fixed, 0.3, 0.0), zero, fixed & False)
    angle, _, _ = propagated(surface, constraints)
    direction = plane_angle(surface, angle)
    assert np.abs(wrap(direction - direction[vertex])).max() < 1e-12


def test_hundred_thousand_triangles_in_a_second_with_the_distance():
    surface = plate(np.ones((224, 224)), 1 / 224, 0.25)
    constraints = boundary_constraints(surface, KINK)
    start = time.process_time()
    propagate(surface, constraints, arrival_distance(surface, constraints.fixed))
    assert time.process_time() - start < 1.0
