"""Time limits for stages: what they ask to know whether to stop also says when time is up."""

from __future__ import annotations

from time import monotonic, thread_time

# A user waits by the clock on the wall: a busy machine may take so many times as long.
_WAITED = 1.4


class Patience:
    """Handed to a stage in place of `cancelled`: true once so many seconds have passed, too.

    seconds    CPU seconds of this thread from now on, so that other programs do not change results;
               where they slow it down very much, 1.4 times as many seconds of the clock
    cancelled  function () -> bool, the one to stand in for, or another Patience; None: never

    The stage then raises Cancelled. `ran_out` tells whether time was up or the user asked to stop.
    """

    def __init__(self, seconds: float, cancelled=None):
        self.seconds = seconds
        self._end = thread_time() + seconds
        self._latest = monotonic() + _WAITED * seconds
        self._cancelled = cancelled or (lambda: False)

    def __call__(self) -> bool:
        return self._cancelled() or self._time_is_up()

    @property
    def ran_out(self) -> bool:
        """Is it only this limit that stops the stage?"""
        return self._time_is_up() and not self._cancelled()

    def _time_is_up(self):
        return thread_time() > self._end or monotonic() > self._latest
