"""The length of a study, and sample times that fixed steps of several sizes meet."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from math import ceil, floor, lcm

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Problem
from mbproj.scene.read import Scene
from mbproj.scene.sampling import DEFAULT_SAMPLES, MOST_SAMPLES
from mbproj.studies.measure.solve import sample_times

#: The fewest and the most samples, where the steps allow it.
FEW, MANY = 200, 1000
#: The number of samples where there is no fixed step: a number with many divisors.
DEFAULT = 480
#: The largest common multiple of steps, in units of the shortest, that is converted to a floating-point number.
FARTHEST = Fraction(10) ** 200
#: The relative difference up to which a ratio of times counts as a whole number.
WHOLE = 1e-9


def span(scene: Scene, until: float | None) -> float:
    """The length of a study in s: `until`, or the scene's duration. Raises InputError where neither is given."""
    duration = scene.settings.duration if until is None else until
    if duration is None or not 0.0 < duration < float("inf"):
        hint = "add it to 'simulation', or say how long on the command line"
        problem = Problem("the scene has no duration", scene.place("simulation"), hint)
        raise InputError(problem)
    return duration


def sampled(scene: Scene, until: float | None) -> Array:
    """The sample times of a run of the scene, (T,), s: every output step, or every step, or every thousandth of the
    duration, up to `until`. Raises InputError where the scene has no duration, or there are too many samples to
    hold."""
    duration, settings = span(scene, until), scene.settings
    interval = min(duration, settings.output_step or settings.step or (settings.duration or duration) / DEFAULT_SAMPLES)
    if duration / interval > MOST_SAMPLES:
        message = f"more than {MOST_SAMPLES:.0e} samples, every {interval:.6g} s until {duration:.6g} s"
        raise InputError(Problem(message, hint="choose a longer --output-step, or an earlier end"))
    whole = np.asarray(interval * np.arange(int(duration / interval * (1.0 + WHOLE)) + 1), dtype=float)
    over = duration - float(whole[-1]) > WHOLE * duration
    return np.concatenate([whole, [duration]]) if over else whole


def common_times(until: float, steps: Iterable[float]) -> Array:
    """Times from 0 to `until` (s) that are whole multiples of every step (s): some hundreds where possible. They end at
    the last common multiple before `until`. Raises InputError where there is none."""
    steps = tuple(steps)
    if not steps:
        return sample_times(until, DEFAULT)
    fractions = [Fraction(step / min(steps)).limit_denominator(10**7) for step in steps]
    whole = lcm(*(part.denominator for part in fractions))
    multiple = Fraction(lcm(*(int(part * whole) for part in fractions)), whole)  # in units of the shortest step
    together = min(steps) * float(min(multiple, FARTHEST))
    ratio = until / together
    count = floor(ratio * (1.0 + WHOLE))
    if not count:
        message = f"the steps do not meet before {together:g} s, and the study ends at {until:g} s"
        raise InputError(Problem(message, hint="choose steps that divide each other: 0.01, 0.005, 0.0025"))
    end = until if abs(ratio - count) <= WHOLE * ratio else count * together
    thinner = (stride for stride in range(ceil(count / MANY), ceil(count / FEW) + 1) if count % stride == 0)
    return sample_times(end, count // next(thinner, 1))


def stride_for(times: Array, step: float) -> int | None:
    """The fewest intervals of `times` after which a fixed step meets a sample again; None where no number fits."""
    intervals, interval = len(times) - 1, float(times[1] - times[0])
    for stride in range(1, intervals + 1):
        ratio = stride * interval / step
        if intervals % stride == 0 and ratio > 0.5 and abs(ratio - round(ratio)) <= WHOLE * ratio:
            return stride
    return None


def divisors(number: int) -> list[int]:
    """All divisors of a number, in increasing order."""
    return [int(part) for part in np.flatnonzero(number % np.arange(1, number + 1) == 0) + 1]
