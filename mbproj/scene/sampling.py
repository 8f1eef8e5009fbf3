"""When a run records: at t0, then every output step, and at the end."""

from __future__ import annotations

import math

from mbproj.scene.records import Settings

#: Samples of an error-controlled run whose scene names no output step.
DEFAULT_SAMPLES = 1000
#: A time is that of a sample where they differ by less than this part of the duration: round-off, and no more.
SAME_TIME = 1e-12


def whole_steps(settings: Settings) -> int:
    """The number of fixed steps: the duration over the step; a remainder above round-off is one shorter step more."""
    assert settings.step is not None and settings.duration is not None
    ratio = settings.duration / settings.step
    nearest = round(ratio)
    return nearest if nearest and abs(ratio - nearest) <= 1e-9 * nearest else math.ceil(ratio)


def output_every(settings: Settings) -> int:
    """How many fixed steps lie between two samples."""
    assert settings.step is not None
    return 1 if settings.output_step is None else max(1, round(settings.output_step / settings.step))


def output_times(settings: Settings, start: float) -> list[float]:
    """The times of the samples of an error-controlled run, from the start to the end of the duration."""
    assert settings.duration is not None
    interval = settings.output_step or settings.duration / DEFAULT_SAMPLES
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
    if settings.duration is None or (settings.step is None and settings.tolerance is None):
        return None
    if settings.step is None:
        interval = settings.output_step or settings.duration / DEFAULT_SAMPLES
    else:
        interval = output_every(settings) * settings.step
    slack = SAME_TIME * settings.duration
    number = round(time / interval)
    regular = min(number * interval, settings.duration)
    if min(abs(time - regular), abs(time - settings.duration)) <= slack:
        return ()
    after = min(math.ceil(time / interval) * interval, settings.duration)
    return tuple(dict.fromkeys((math.floor(time / interval) * interval, after)))
