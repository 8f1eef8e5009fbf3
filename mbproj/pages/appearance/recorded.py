"""The motion in a results file."""

from __future__ import annotations

from mbproj.errors import InputError, Problem
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.results import Results


def motion_of(results: Results) -> PoseHistory:
    """The motion of all bodies. Raises InputError where at no sample all poses are finite."""
    motion = PoseHistory(results.time, results["bodies/position"], results["bodies/orientation"])
    if not len(motion.finite):
        message = f"'{results.path}' has no sample to show"
        raise InputError(Problem(message, hint=f"its status: {results.status}"))
    return motion
