"""Computed in the unit frame, told in the user's: the same results wherever and however large."""

import numpy as np
import pytest

from core.pipeline import decompose
from core.sentences import PlacedSentence
from core.settings import Settings
from core.unit_frame import unit_frame
from tests.core.surfaces import lshape, plate_with_holes

PLACES = [(1e-7, 0.0), (1.0, 1e3), (1e7, 1e9), (1000.0, 0.0)]


def test_frame_is_of_size_one_and_loses_nothing():
    points = np.random.default_rng(1).random((50, 3))
    for scale, offset in PLACES:
        moved = scale * points + offset
        frame = unit_frame(moved)
        inner = frame.inward(moved)
        assert 2 * np.linalg.norm(inner, axis=1).max() == pytest.approx(1)
        assert np.abs(inner.mean(0)).max() < 1e-6
        error = np.abs(frame.outward(inner) - moved).max()
        assert error <= 1e-15 * (offset + scale)
    assert unit_frame(np.zeros((1, 3))).size == 1


@pytest.mark.parametrize("scale, offset", PLACES)
@pytest.mark.parametrize("surface", [plate_with_holes(24), lshape(12)])
def test_scale_and_place_do_not_matter(surface, scale, offset):
    here = decompose(surface.points, surface.triangles, Settings(edge_length=0.08))
    points = scale * surface.points + offset
    there = decompose(points, surface.triangles, Settings(edge_length=0.08 * scale))
    assert np.array_equal(there.surface.points[: len(points)], points[there.clean.vertex_origin])
    assert np.array_equal(there.clean.vertex_origin, here.clean.vertex_origin)
    assert there.blocks.count == here.blocks.count
    assert np.array_equal(there.singularities.face, here.singularities.face)
    near = 1e-5 * scale + 1e-15 * offset
    for name, part in (("position", "singularities"), ("node_position", "complex")):
        moved = scale * getattr(getattr(here, part), name) + offset
        assert np.abs(getattr(getattr(there, part), name) - moved).max(initial=0) < near
    assert there.distance == pytest.approx(scale * here.distance, rel=1e-5, abs=near)
    assert there.surface.edge_length == pytest.approx(scale * here.surface.edge_length, rel=1e-6)
    assert there.surface.diameter == pytest.approx(scale * here.surface.diameter, rel=1e-6)
    assert there.quads.scaled_jacobian.min() > 0.5


def test_sentences_name_the_users_places():
    frame = unit_frame(np.array([(100.0, 0, 0), (104, 0, 0)]))
    sentence = PlacedSentence("{length[0]} long at {point[0]}.", (np.zeros(3),), (0.25,))
    assert sentence.outward(frame) == "1 long at (102, 0, 0)."
