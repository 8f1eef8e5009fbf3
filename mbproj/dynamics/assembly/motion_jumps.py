"""Refuses motions that jump: bodies with mass cannot follow a jump of position, and a jump of velocity takes an
impulse."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from mbproj.errors import InputError, Problem
from mbproj.model.channels import Motions
from mbproj.model.system import System

HINT = "a motion needs a continuous velocity: lead over with a smooth_step or a table"


def refuse_jumps(system: System, start: float, end: float) -> None:
    """Raise InputError where a motion's value or velocity jumps from `start` to `end`. Jumps of the acceleration alone
    are allowed: the driving force jumps with it."""
    problems = _problems(system.motions, system.names.motions, system.names.motion_units, start, end)
    if problems:
        raise InputError(list(problems))


@lru_cache(maxsize=256)
def _problems(
    motions: Motions, names: tuple[str, ...], units: tuple[str, ...], start: float, end: float
) -> tuple[Problem, ...]:
    """Return the first jump of each motion. The result is cached: studies run one mechanism many times."""
    return tuple(
        Problem(f"motion '{name}' {jump}", motions.places[number], HINT)
        for number, (name, unit) in enumerate(zip(names, units, strict=True))
        for jump in _first_jump(motions, number, unit, start, end)
    )


def _first_jump(motions: Motions, number: int, unit: str, start: float, end: float) -> Iterator[str]:
    from mbproj.functions.kinks import kinks

    for kink in kinks(motions.programs, number, start, end):
        value, rate, _ = kink.jump
        if value:
            yield f"jumps by {abs(value):.6g} {unit} at t = {kink.t:.9g} s"
        elif rate:
            yield f"changes its velocity by {abs(rate):.6g} {unit}/s at once at t = {kink.t:.9g} s"
        if value or rate:
            return
