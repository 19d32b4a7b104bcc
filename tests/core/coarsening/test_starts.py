"""First layouts: well shaped, with few blocks, and as many of them as were asked for."""

import numpy as np
import pytest

from core.blocks.blocks import verify_blocks
from core.coarsening.goal import Goal
from core.coarsening.kinks import without_kinks
from core.coarsening.starts import first_drafts
from core.errors import Cancelled
from core.settings import Settings
from tests.core.coarsening.test_coarsening import layout_of


def starts(name, good, **settings):
    surface, layout = layout_of(name)
    layout, kinks = without_kinks(layout)
    goal = Goal.of(Settings(**settings), surface.face_area.sum())
    return first_drafts(surface, layout, kinks, goal, good)


@pytest.mark.parametrize("name, blocks", [("disc", 5), ("lshape", 3), ("octant", 3)])
def test_the_first_good_one_ends_the_search(name, blocks):
    found = starts(name, 0.5)
    assert [draft.blocks.count for _, draft in found] == [blocks]
    assert found[0][1].worst >= 0.5


def test_without_a_good_one_several_are_judged_once_each():
    found = starts("handle", 1.1)
    counts = [draft.blocks.count for _, draft in found]
    assert 1 < len(counts) <= 4 and len(set(counts)) == len(counts)
    for _, draft in found:
        verify_blocks(draft.blocks, draft.quads.quad)


def test_quads_wanted_by_size_or_by_number():
    assert Goal.of(Settings(quad_count=100), 25.0).size == pytest.approx(0.5)
    assert Goal.of(Settings(edge_length=0.2), 25.0) == Goal(0.2, None)


def test_drafts_have_at_most_about_a_thousand_quads():
    for _, draft in starts("holes", 1.1, quad_count=20000):
        assert len(draft.quads.quad) <= 1000


def test_cancel():
    surface, layout = layout_of("disc")
    layout, kinks = without_kinks(layout)
    with pytest.raises(Cancelled):
        first_drafts(surface, layout, kinks, Goal(0.1, None), 0.5, cancelled=lambda: True)
