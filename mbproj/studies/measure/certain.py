"""A reference up to the time until which it is certain: the end of the study, or the time when a motion becomes
chaotic."""

from __future__ import annotations

from collections.abc import Sequence

from mbproj.errors import InputError, Problem
from mbproj.studies.measure.cause import why_not
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.reference import Reference, reference
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.spans import common_times
from mbproj.studies.parallel.progress import Tell, silent

#: A study ends early where the reference is uncertain by more than this part of the mechanism's size.
CERTAIN = 1e-6


def certain_reference(
    mechanism: Mechanism, until: float, own: Setting, names: Sequence[str], tell: Tell = silent
) -> tuple[Reference, list[str]]:
    """The reference up to `until` (s), or to the last time at which it is certain to `CERTAIN`, and notes on it. It
    serves to compare the integrators `names` and the setting `own`. Raises InputError where no time is certain."""
    steps = [own.step] if own.step is not None and own.step <= until else []
    tell("reference", 0, 1)
    found = reference(mechanism, common_times(until, steps), names)
    limit, notes = CERTAIN * mechanism.system.length, list[str]()
    while (certain := found.certain_until(limit)) < found.times[-1]:
        why = why_not(mechanism, found, limit, certain, tell)
        if certain < 2 * found.times[1]:
            raise InputError(Problem(f"there is no reference for this mechanism: {why}", hint="try a shorter time"))
        notes = [f"the study ends at {certain:.4g} s: the reference is certain to {limit:.1g} m up to there ({why})"]
        found = reference(mechanism, common_times(certain, steps), names)
    return found, [found.words, *notes]
