"""One run: the clock of its stages, its progress, and whether the user wants it to stop."""

from __future__ import annotations

from contextlib import contextmanager
from time import monotonic, process_time

from .errors import Cancelled

# Share of the whole work after which each stage ends, for the progress bar.
STAGE_ENDS = {
    "surface": 0.05, "distance": 0.15, "propagation": 0.2, "relaxation": 0.35, "lines": 0.5,
    "quads": 0.95, "blocks": 1.0,
}


class Run:
    """Handed through all stages.

    seconds    dict, CPU seconds of each stage so far, all attempts together
    cancelled  function () -> bool
    """

    def __init__(self, progress=None, cancelled=None):
        self.seconds: dict[str, float] = {}
        self._progress = progress or (lambda fraction, stage: None)
        self.cancelled = cancelled or (lambda: False)
        self._done = 0.0
        self._start = monotonic()

    @contextmanager
    def stage(self, name: str):
        """Time a stage in CPU seconds; raises Cancelled before and after it when asked to stop."""
        self._stop_if_cancelled()
        self._progress(self._done, name)
        start = process_time()
        try:
            yield
        finally:
            # A stage that fails has taken its time too.
            self.seconds[name] = self.seconds.get(name, 0.0) + process_time() - start
        self._done = max(self._done, STAGE_ENDS[name])
        self._stop_if_cancelled()
        self._progress(self._done, name)

    @property
    def total(self) -> float:
        """CPU seconds of all stages so far."""
        return sum(self.seconds.values())

    @property
    def waited(self) -> float:
        """Seconds of the clock since the run began."""
        return monotonic() - self._start

    def _stop_if_cancelled(self):
        if self.cancelled():
            raise Cancelled("The decomposition was cancelled; nothing has been changed.")
