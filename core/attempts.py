"""One way after the other, until one leads to a valid mesh. (method section 8)"""

from __future__ import annotations

from .errors import Cancelled, LayoutError
from .features.creases import Creases
from .patience import Patience
from .run import Run
from .settings import Settings
from .stages import Stages, run_stages, split_triangles
from .surface.resolution import WorkingSurface
from .ways import DIRECT, FEWER_CREASES, MIDPOINT_SPLIT, Way, ways

# CPU seconds after which the way being tried is given up for the last one, which never fails.
PATIENCE = 60.0
# The same in seconds of the clock, for machines that have much else to do.
WAITED = 85.0
# Where these ways fail, the creases that are to blame go first.
_GIVES_WAY = (DIRECT, FEWER_CREASES)
# Creases nearer than this share of the diameter to where a layout failed are to blame for it.
NEAR = 0.02
# A worst scaled Jacobian that is no more than rounding keeps above 0, unless the surface has
# corners so sharp; so many other ways are then tried, and the best one is taken.
POOR, MORE_WHEN_POOR = 1e-4, 2
# Triangles of a working surface that may be cut into four for another attempt.
MOST_TO_HALVE = 12_000
# Faults of the program itself: they are told in the report, and another way is taken all the same.
_SLIPS = (ArithmeticError, LookupError, ValueError)


def first_valid(run: Run, working: WorkingSurface, creases: Creases, settings: Settings):
    """The first way that leads to a valid mesh: (its name, what the stages found, sentences).

    The sentences tell why the ways before it failed. Raises LayoutError where no quads are wanted
    and no way leads as far as is wanted; Cancelled.
    """
    attempts = _Attempts(run, working, creases, settings)
    while attempts.may_go_on():
        found = attempts.next()
        if found is not None:
            return found
    return attempts.last()


class _Attempts:
    """The ways that are left, and what those already tried have led to."""

    def __init__(self, run, working, creases, settings):
        self._run, self._working, self._creases = run, working, creases
        self._settings = settings
        may_halve = working.surface.face_count <= MOST_TO_HALVE
        self._left = ways(creases.masks(), settings, may_halve)
        self._notes, self._failure = [], None
        self._poor = []  # valid by a hair: (worst scaled Jacobian, what is then returned)

    def may_go_on(self) -> bool:
        if not self._left or len(self._poor) > MORE_WHEN_POOR:
            return False
        return not self._notes or not self._patience()()

    def next(self):
        """Try the next way: what `first_valid` returns, or None."""
        way, patience = self._left.pop(0), self._patience()
        try:
            stages = run_stages(self._run, self._working, way, patience)
        except Cancelled:
            if not patience.ran_out:
                raise
            self._left = []
            late = LayoutError(f"It took longer than {PATIENCE:.0f} seconds.")
            self._note(way, late, "was given up")
        except LayoutError as error:
            self._note(way, error)
            self._give_way(way, self._beside(way, error))
        except _SLIPS as error:
            self._note(way, _fault(error))
        else:
            return self._judged(way, stages)
        return None

    def last(self):
        """What is left when no way led to a good mesh."""
        if self._poor:
            return max(self._poor, key=lambda found: found[0])[1]
        if self._settings.stop_after != "quads":
            raise self._failure
        try:
            stages = split_triangles(self._run, self._working, self._creases.all, self._settings)
        except _SLIPS as error:
            raise _fault(error) from error
        return MIDPOINT_SPLIT, stages, self._notes

    def _patience(self):
        run = self._run
        return Patience(PATIENCE - run.total, run.cancelled, WAITED - run.waited)

    def _judged(self, way: Way, stages: Stages):
        if stages.filling is None:
            return way.name, stages, self._notes
        quads = stages.filling.quads
        inverted = quads.quads[quads.scaled_jacobian <= 0]
        if len(inverted):
            self._note(way, f"{len(inverted)} quads would be inverted.")
            self._give_way(way, self._creases.without_beside(way.crease, quads.points[inverted]))
            return None
        worst = float(quads.scaled_jacobian.min())
        if worst > POOR:
            return way.name, stages, self._notes
        self._poor.append((worst, (way.name, stages, list(self._notes))))
        self._note(way, "a quad would have no area.")
        return None

    def _note(self, way: Way, reason, what="failed"):
        self._notes.append(f"The {way.name} way {what}: {reason}")
        if isinstance(reason, LayoutError):
            self._failure = reason

    def _beside(self, way: Way, error: LayoutError):
        """The creases of the way without those near the place of the error, if it has one."""
        if not len(error.place):
            return way.crease
        reach = NEAR * self._working.surface.diameter
        return self._creases.without_near(way.crease, error.place, reach)

    def _give_way(self, way: Way, fewer):
        """Try the way next with fewer creases, where they are fewer and it may give way."""
        if way.name in _GIVES_WAY and fewer.sum() < way.crease.sum():
            self._left.insert(0, Way(FEWER_CREASES, fewer, way.settings))


def _fault(error) -> LayoutError:
    return LayoutError(
        f"There is a fault in the program ({type(error).__name__}: {error}); please report it."
    )
