"""Which filling of a layout is taken: the coarse one in time and in shape, else the direct one."""

from dataclasses import replace

import numpy as np
import pytest

from core.cells.layout import trace_layout
from core.errors import Cancelled
from core.field.constraints import boundary_constraints
from core.field.cross_field import build_cross_field
from core.field.distance import arrival_distance
from core.field.propagation import propagate
from core.filling import filling
from core.filling.filling import fill_cells
from core.patience import Patience
from core.settings import Settings
from tests.core import surfaces

DIRECT = Settings(quad_count=300, coarseness="direct")


@pytest.fixture(scope="module")
def traced():
    surface = surfaces.plate_with_holes(24)
    constraints = boundary_constraints(surface, np.radians(20))
    angle = propagate(surface, constraints, arrival_distance(surface, constraints.fixed))
    field = build_cross_field(surface, angle, constraints)
    return surface, trace_layout(surface, constraints, field)


def test_a_coarse_layout_that_takes_too_long_is_given_up(traced, monkeypatch):
    monkeypatch.setattr(filling, "COARSE_SECONDS", 0.0)
    result = fill_cells(*traced, replace(DIRECT, coarseness="balanced"))
    assert result.warnings and "too long" in result.warnings[0]
    assert np.array_equal(result.quads.quads, fill_cells(*traced, DIRECT).quads.quads)


def test_who_cancels_is_heard_while_time_is_left(traced):
    with pytest.raises(Cancelled):
        fill_cells(*traced, replace(DIRECT, coarseness="balanced"), lambda: True)
    with pytest.raises(Cancelled):
        fill_cells(*traced, DIRECT, Patience(-1.0))


def test_a_coarse_layout_in_bad_shape_gives_way(traced, monkeypatch):
    direct = fill_cells(*traced, DIRECT).quads
    monkeypatch.setattr(filling, "LEAST_COARSE", 1.1)
    result = fill_cells(*traced, replace(DIRECT, coarseness="balanced")).quads
    assert result.scaled_jacobian.min() >= direct.scaled_jacobian.min() - 1e-12


@pytest.mark.parametrize("times, stays", [(1.0, True), (1e9, False)])
def test_it_stays_where_the_direct_one_has_many_times_as_many_blocks(traced, monkeypatch, times, stays):
    coarse = fill_cells(*traced, replace(DIRECT, coarseness="balanced"))
    worse = coarse.quads.scaled_jacobian.min() - 0.1
    monkeypatch.setattr(filling, "LEAST_COARSE", 1.1)
    monkeypatch.setattr(filling, "MANY_TIMES", times)
    monkeypatch.setattr(filling, "_worst", lambda found: worse if found.warnings == () else 1.0)
    result = fill_cells(*traced, replace(DIRECT, coarseness="balanced"))
    assert np.array_equal(result.quads.quads, coarse.quads.quads) == stays
    assert any("bad shapes" in str(told) for told in result.warnings) != stays


def test_cells_with_folded_quads_get_more_of_them(traced, monkeypatch):
    """The worst quad is said to be inverted at first: its cell, and what it drags along, grow."""
    collect, cells = filling._collect, []

    def fold(layout, quads, *rest):
        result = collect(layout, quads, *rest)
        cells.append(quads.cell_shape.copy())
        if len(cells) > 1:
            return result
        jacobian = result.quads.scaled_jacobian.copy()
        jacobian[quads.quad_cell == 0] = -1.0
        return replace(result, quads=replace(result.quads, scaled_jacobian=jacobian))

    monkeypatch.setattr(filling, "_collect", fold)
    result = fill_cells(*traced, DIRECT)
    assert result.quads.scaled_jacobian.min() > 0
    before, after = cells
    assert (after[0] >= 2 * before[0]).all()
    assert after.prod(1).sum() < 4 * before.prod(1).sum()
