"""The times at which a run records: t0, every output step after it, and the end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import overload

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.settings import Settings

#: The number of intervals between samples of an error-controlled run whose scene gives no output step.
DEFAULT_SAMPLES = 1000
#: Two times are the same where they differ by less than this part of the duration, which is round-off.
SAME_TIME = 1e-12
#: The most fixed steps. The times of more steps could not be told apart, since numbers have 16 digits.
MOST_STEPS = 1e15
#: The most samples of an error-controlled run: with more, its file would exceed some 10 GB.
MOST_SAMPLES = 1e7


def too_many(settings: Settings) -> Problem | None:
    """The problem of settings that ask for too many steps or samples; None where they do not."""
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
    """The number of fixed steps between two samples."""
    assert settings.step is not None
    return 1 if settings.output_step is None else max(1, round(settings.output_step / settings.step))


@dataclass(frozen=True)
class SampleTimes(Sequence[float]):
    """The times of `number` samples in s: `first`, then origin + (offset + k) interval for k = 1, 2, .., and `last`.
    They are computed when asked for, so that a million take no more memory than two."""

    first: float
    last: float
    origin: float
    interval: float
    offset: int = 0
    number: int = 2

    def __len__(self) -> int:
        return self.number

    @overload
    def __getitem__(self, index: int) -> float: ...
    @overload
    def __getitem__(self, index: slice) -> list[float]: ...
    def __getitem__(self, index: int | slice) -> float | list[float]:
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(self.number))]
        k = index + self.number if index < 0 else index
        if not 0 <= k < self.number:
            raise IndexError(index)
        if k == 0:
            return self.first
        return self.last if k == self.number - 1 else self.origin + (self.offset + k) * self.interval


def output_times(settings: Settings, start: float) -> SampleTimes:
    """The times of the samples of an error-controlled run, from the start to the end of the duration. Raises InputError
    where they are too many."""
    _require_fewer(settings)
    assert settings.duration is not None
    interval = _interval(settings)
    ratio = settings.duration / interval
    count = round(ratio) if abs(ratio - round(ratio)) <= 1e-9 * ratio else math.floor(ratio)
    odd = abs(ratio - count) > 1e-9 * ratio  # the last interval is shorter
    return SampleTimes(start, start + settings.duration, start, interval, number=count + 1 + odd)


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
