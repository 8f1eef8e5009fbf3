"""Notes on the instants of controllers: those that split fixed steps, and those that lie after the end of the run."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from mbproj.errors import Problem
from mbproj.scene.blocks.control.expanded import where
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import Settings

#: A time is on the grid of fixed steps where it differs from a whole number of them by at most this part of a step.
ON_GRID = 1e-6


def note_instants(blocks: Mapping[str, Any], settings: Settings | None, reading: Reading) -> None:
    """Note the controllers whose instants lie inside of fixed steps, or that have at most one instant in the run."""
    if settings is None:
        return
    for name, each in blocks.get("controllers", {}).items():
        path = where("controllers", name, blocks.get("signals", {})) or ("controllers", name)
        what = None
        if each.start + each.period > settings.duration:
            count = "one instant" if each.start <= settings.duration else "no instant"
            what = f"'{name}' has {count} in a run of {settings.duration:g} s"
            hint = f"its period is {each.period:g} s: give a shorter one, or make the run longer"
        elif settings.step is not None and any(map(_splits(settings.step), (each.period, each.delay, each.start))):
            times = (2.0 if each.delay else 1.0) / each.period
            what = f"'{name}' acts inside of steps of {settings.step:g} s: they end there, and go on to their grid"
            hint = f"that makes up to {times:.4g} steps a second beside {1.0 / settings.step:.4g}; none where the step"
            hint += " divides 'period', 'delay' and 'start'"
        if what is not None:
            near = next(path[:end] for end in range(len(path), -1, -1) if path[:end] in reading.places)
            reading.notes.append(Problem(what, reading.places[near], hint))


def _splits(step: float) -> Any:
    def splits(time: float) -> bool:
        return abs(time / step - math.floor(time / step + 0.5)) > ON_GRID

    return splits
