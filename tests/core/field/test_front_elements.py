"""Elements of the front against plane geometry that can be checked directly."""

import numpy as np
import pytest

from core.field.front_elements import front_elements
from core.surface.surface import build_surface
from tests.core.surfaces import crumpled, octant, plate, sphere


def needles(n=12, ratio=8.0, shear=0.5):
    """A square of jittered triangles, squeezed and sheared."""
    surface = plate(np.ones((n, n)), 1 / n, 0.2)
    points = surface.points.copy()
    points[:, 0] += shear * points[:, 1]
    points[:, 1] /= ratio
    return build_surface(points, surface.triangles)


def split_corners(surface, elements):
    """Number of corners that were replaced by two virtual elements."""
    return len(elements.target) - 3 * surface.face_count


def test_acute_triangles_are_their_own_elements():
    surface = octant(6)
    elements = front_elements(surface)
    assert len(elements.target) == 3 * surface.face_count
    assert np.array_equal(elements.parent, [surface.tail, surface.head])
    assert np.all(elements.apex > 0)


def test_elements_are_true_plane_triangles():
    surface = needles()
    elements = front_elements(surface)
    assert split_corners(surface, elements) > surface.face_count // 2
    target = surface.points[elements.target, :2]
    first, second = surface.points[elements.parent, :2]
    edge = second - first
    assert np.linalg.norm(edge, axis=1) == pytest.approx(elements.base, rel=1e-12)
    along = ((target - first) * edge).sum(1) / elements.base
    away = (
        edge[:, 0] * (target - first)[:, 1] - edge[:, 1] * (target - first)[:, 0]
    ) / elements.base
    assert np.abs(along - elements.apex[0]).max() < 1e-12
    assert np.abs(away - elements.apex[1]).max() < 1e-12
    assert elements.apex[1].min() > 0


def test_transport_in_the_plane_keeps_directions():
    """The global angle of a vertex frame is that of its first halfedge."""
    surface = needles()
    elements = front_elements(surface)
    first = surface.fan[surface.fan_offset[:-1]]
    step = surface.points[surface.head[first]] - surface.points[surface.tail[first]]
    frame = np.arctan2(step[:, 1], step[:, 0])
    turn = elements.transport - frame[elements.parent] + frame[elements.target]
    assert np.abs(np.exp(1j * turn) - 1).max() < 1e-11


def test_folding_the_paper_changes_nothing():
    """An accordion is isometric to the plane, so elements and transports are the same."""
    flat = plate(np.ones((10, 10)), 0.1)
    points = flat.points.copy()
    points[:, 1] += 1.7 * points[:, 0]
    flat = build_surface(points, flat.triangles)
    column = np.rint(points[:, 0] / 0.1)
    folded = np.c_[0.8 * points[:, 0], points[:, 1], 0.06 * (column % 2)]
    plane, accordion = front_elements(flat), front_elements(build_surface(folded, flat.triangles))
    assert split_corners(flat, plane) > 20
    assert np.array_equal(plane.target, accordion.target)
    assert np.array_equal(plane.parent, accordion.parent)
    assert np.abs(plane.apex - accordion.apex).max() < 1e-12
    assert np.abs(plane.base - accordion.base).max() < 1e-12
    assert np.abs(np.exp(1j * (plane.transport - accordion.transport)) - 1).max() < 1e-12


def test_split_corners_become_acute():
    surface = needles(16, 5.0, 0.3)
    elements = front_elements(surface)
    along, away = elements.apex
    at_target = np.pi - np.arctan2(away, along) - np.arctan2(away, elements.base - along)
    obtuse = np.count_nonzero(at_target > np.radians(91))
    # What is left are corners whose wedge runs out of the surface.
    assert obtuse < 0.15 * np.count_nonzero(surface.corner_angle > np.radians(91))
    wide = needles(40, 5.0, 0.3)
    assert split_corners(wide, front_elements(wide)) > 0.9 * np.count_nonzero(
        wide.corner_angle > np.radians(91)
    )


def test_obtuse_corner_at_the_boundary_stays():
    surface = build_surface([[0, 0, 0], [4, 0, 0], [2, 0.5, 0]], [[0, 1, 2]])
    elements = front_elements(surface)
    assert np.array_equal(elements.target, [2, 0, 1])


@pytest.mark.parametrize("surface", [crumpled(sphere(6), 0.8), crumpled(octant(8), 0.8)])
def test_any_surface_gives_proper_elements(surface):
    elements = front_elements(surface)
    for values in (elements.transport, elements.base, elements.apex):
        assert np.isfinite(values).all()
    assert elements.base.min() > 0 and elements.apex[1].min() > 0
    assert (elements.parent != elements.target).all()
