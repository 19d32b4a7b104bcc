"""The list of ways, and how they start."""

import numpy as np

from core.field.constraints import boundary_constraints
from core.settings import RELAXATIONS, Settings
from core.ways import DIRECT, FEWER_CREASES, Way, ways
from tests.core import surfaces


def test_every_relaxation_and_mask_is_tried_and_the_wanted_one_first():
    masks = [np.ones(6, bool), np.zeros(6, bool)]
    listed = ways(masks, Settings())
    assert listed[0].name == DIRECT and listed[0].settings == Settings()
    assert {way.settings.relaxation for way in listed} == set(RELAXATIONS)
    assert [way.crease.any() for way in listed if way.name == FEWER_CREASES] == [False]
    assert any(way.halved for way in listed)
    assert not any(way.halved for way in ways(masks, Settings(), may_halve=False))


def test_a_disturbance_is_repeatable_and_leaves_fixed_crosses():
    surface = surfaces.disc(5)
    constraints = boundary_constraints(surface, 0.3)
    way = Way("other field", np.zeros(0, bool), Settings(), seed=3)
    angle = np.where(constraints.fixed, constraints.angle, 0.0)
    first = way.start(angle, constraints)
    assert np.array_equal(first, way.start(angle, constraints))
    assert np.array_equal(first[constraints.fixed], angle[constraints.fixed])
    assert not np.allclose(first, angle)
