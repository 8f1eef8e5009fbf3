"""When a run records: at t0, then every output step, and at the end."""

from __future__ import annotations

import math

from mbproj.scene.records import Settings

#: Samples of an error-controlled run whose scene names no output step.
DEFAULT_SAMPLES = 1000


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
