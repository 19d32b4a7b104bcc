"""Time limits for stages: what they ask to know whether to stop also says when time is up."""

from __future__ import annotations

from math import inf
from time import monotonic, thread_time


class Patience:
    """Handed to a stage in place of `cancelled`: true once so many seconds have passed, too.

    seconds    CPU seconds of this thread from now on, so that other programs do not change results
    cancelled  function () -> bool, the one to stand in for, or another Patience; None: never
    waited     seconds of the clock on the wall from now on: how long a user of a very busy machine
               is to wait all the same; None: for ever

    The stage then raises Cancelled. `ran_out` tells whether time was up or the user asked to stop.
    """

    def __init__(self, seconds: float, cancelled=None, waited: float | None = None):
        self.seconds = seconds
        self._end = thread_time() + seconds
        self._latest = inf if waited is None else monotonic() + waited
        self._cancelled = cancelled or (lambda: False)

    def __call__(self) -> bool:
        return self._cancelled() or self._time_is_up()

    @property
    def ran_out(self) -> bool:
        """Is it only this limit that stops the stage?"""
        return self._time_is_up() and not self._cancelled()

    def _time_is_up(self):
        return thread_time() > self._end or monotonic() > self._latest
