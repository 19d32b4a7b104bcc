"""Limits of time: they stop a stage as a user would, and can be told from one."""

import pytest

from core import patience
from core.patience import Patience


@pytest.fixture
def clock(monkeypatch):
    now = [100.0]
    monkeypatch.setattr(patience, "thread_time", lambda: now[0])
    return now


def test_time_runs_out(clock):
    stop = Patience(5.0)
    clock[0] += 4.9
    assert not stop() and not stop.ran_out
    clock[0] += 0.2
    assert stop() and stop.ran_out


def test_who_asks_to_stop_is_not_the_clock(clock):
    asked = [False]
    stop = Patience(5.0, lambda: asked[0])
    asked[0] = True
    assert stop() and not stop.ran_out
    clock[0] += 6.0
    assert stop() and not stop.ran_out


def test_of_two_limits_the_outer_one_counts(clock):
    outer = Patience(2.0)
    inner = Patience(5.0, outer)
    clock[0] += 3.0
    assert inner() and not inner.ran_out and outer.ran_out


def test_a_busy_machine_does_not_make_users_wait_for_long(clock, monkeypatch):
    wall = [50.0]
    monkeypatch.setattr(patience, "monotonic", lambda: wall[0])
    stop = Patience(5.0, waited=7.0)
    wall[0] += 6.0
    assert not stop()
    wall[0] += 2.0
    assert stop() and stop.ran_out
