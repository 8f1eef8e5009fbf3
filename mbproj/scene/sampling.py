"""When a run records: at t0, then every output step, and at the end."""

from __future__ import annotations

import math

from mbproj.errors import InputError, Problem
from mbproj.scene.records import Settings

#: Samples of an error-controlled run whose scene names no output step.
DEFAULT_SAMPLES = 1000
#: A time is that of a sample where they differ by less than this part of the duration: round-off, and no more.
SAME_TIME = 1e-12
#: The time of a step is a multiple of it: of more, 16 digits cannot tell one from the next.
MOST_STEPS = 1e15
#: An error-controlled run holds the times of all its samples in memory.
MOST_SAMPLES = 1e7


def too_many(settings: Settings) -> Problem | None:
    """What is wrong with settings that ask for more steps or samples than can be told apart or held."""
    if settings.duration is None:
        return None
    duration = f"the duration of {settings.duration:.6g} s"
    if settings.step is not None and settings.duration / settings.step > MOST_STEPS:
        message = f"'step' of {settings.step:.6g} s: 16 digits cannot tell so many steps apart in {duration}"
        hint = f"make it {settings.duration / MOST_STEPS:.2g} s or longer, or the duration shorter"
        return Problem(message, hint=hint)
    by_error = settings.step is None and settings.output_step is not None
    if by_error and settings.duration / _interval(settings) > MOST_SAMPLES:
        message = f"'output_step' of {settings.output_step:.6g} s: more than {MOST_SAMPLES:.0e} samples in {duration}"
        hint = f"make it {settings.duration / MOST_SAMPLES:.2g} s or longer, or the duration shorter"
        return Problem(message, hint=hint)
    return None


def _interval(settings: Settings) -> float:
    """The time between the samples of an error-controlled run."""
    assert settings.duration is not None
    return settings.output_step or settings.duration / DEFAULT_SAMPLES


def _require_fewer(settings: Settings) -> None:
    problem = too_many(settings)
    if problem is not None:
        raise InputError(problem)


def output_interval(settings: Settings) -> float:
    """The time between two samples, s."""
    return _interval(settings) if settings.step is None else output_every(settings) * settings.step


def whole_steps(settings: Settings) -> int:
    """The number of fixed steps: the duration over the step; a remainder above round-off is one shorter step more.
    Raises InputError where they are too many."""
    _require_fewer(settings)
    assert settings.step is not None and settings.duration is not None
    ratio = settings.duration / settings.step
    nearest = round(ratio)
    return nearest if nearest and abs(ratio - nearest) <= 1e-9 * nearest else math.ceil(ratio)


def output_every(settings: Settings) -> int:
    """How many fixed steps lie between two samples."""
    assert settings.step is not None
    return 1 if settings.output_step is None else max(1, round(settings.output_step / settings.step))


def output_times(settings: Settings, start: float) -> list[float]:
    """The times of the samples of an error-controlled run, from the start to the end of the duration. Raises InputError
    where they are too many."""
    _require_fewer(settings)
    assert settings.duration is not None
    interval = _interval(settings)
    ratio = settings.duration / interval
    count = round(ratio) if abs(ratio - round(ratio)) <= 1e-9 * ratio else math.floor(ratio)
    times = [start + k * interval for k in range(count)] + [start + settings.duration]
    if abs(ratio - count) > 1e-9 * ratio:
        times.insert(-1, start + count * interval)
    return times


def nearest_samples(settings: Settings, time: float) -> tuple[float, ...] | None:
    """The sample times (s) next to `time` (from 0), at most one before and one after; () where it is one of them to
    round-off. None where the settings do not say when a run records.
    """
    if settings.duration is None or (settings.step is None and settings.tolerance is None) or too_many(settings):
        return None
    interval, slack = output_interval(settings), SAME_TIME * settings.duration
    number = round(time / interval)
    regular = min(number * interval, settings.duration)
    if min(abs(time - regular), abs(time - settings.duration)) <= slack:
        return ()
    after = min(math.ceil(time / interval) * interval, settings.duration)
    return tuple(dict.fromkeys((math.floor(time / interval) * interval, after)))
