"""Errors of forces and of other functions of a scene: which one has no finite value, and why."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.errors import SimulationError, shortened
from mbproj.equations.instant import Instant
from mbproj.functions.program import CHANNELS, Op
from mbproj.functions.program_set import ProgramSet
from mbproj.functions.series import Series, failure, run
from mbproj.model.channels import ChannelKind
from mbproj.model.forces import Forces

if TYPE_CHECKING:
    from mbproj.equations.forces import LawState

#: The most inputs that a message lists.
MOST_INPUTS = 6


def law_fails(instant: Instant, state: LawState) -> SimulationError:
    """Return the error for the first force of this state that is not finite."""
    forces, t = instant.system.forces, float(instant.t)
    law = int(np.flatnonzero(~np.isfinite(state.force))[0])
    program = int(forces.laws.program[law]) if law < forces.laws.size else -1
    value, rate = float(state.value[law]), float(state.rate[law])
    if program >= 0 and np.isfinite(value) and np.isfinite(rate):
        return force_fails(instant, program, value, rate)
    where = f"force '{forces.owners[law]}'"
    if value == 0.0 and law < forces.laws.size:
        return SimulationError(t, "its two points have met, and it has no direction", where=where, hint="move one")
    return SimulationError(t, "the solution is no longer finite", where=where, hint="try a smaller step or tolerance")


def turns_too_far(forces: Forces, cosine: Array, t: float) -> SimulationError:
    """Return the error for the bushing whose frames stand furthest apart; `cosine` (B,) are those of half the angle."""
    worst = int(np.argmin(cosine))
    angle = np.degrees(2.0 * np.arccos(np.clip(cosine[worst], 0.0, 1.0)))
    cause = f"its frames stand {angle:.4g} deg apart, and at 180 deg a rotation vector has no direction"
    hint = "make it stiffer, or let a joint hold what turns so far"
    return SimulationError(t, cause, where=f"force '{forces.bushing_names[worst]}'", hint=hint)


def force_fails(instant: Instant, index: int, value: float = 0.0, rate: float = 0.0) -> SimulationError:
    """Return the error for program `index` of a force without a finite value."""
    forces = instant.system.forces
    return program_fails(instant, index, f"force '{forces.program_owners[index]}'", instant.variables(value, rate))


def program_fails(
    instant: Instant, index: int, where: str, variables: Sequence[Series], programs: ProgramSet | None = None
) -> SimulationError:
    """Return the error for program `index` without a finite value for these variables. The program is one of
    `programs`, by default the system's."""
    programs = programs or instant.system.programs
    cause = f"'{programs.texts[index]}' fails: {cause_of(instant, programs, index, variables)}"
    hint = "correct the expression, or end the run before that time"
    return SimulationError(float(instant.t), cause, where=where, hint=hint)


def cause_of(instant: Instant, programs: ProgramSet, index: int, variables: Sequence[Series]) -> str:
    """Return the cause of a value that is not finite, in words: "sqrt(-0.25) is not finite, with pin.angle = 0.3".

    Where signals in the program have no finite value, the words are about the first such signal in the order of
    evaluation."""
    signals, names = instant.system.signals, instant.system.names.signals
    wrong = [at for at in _signals_in(signals, programs, index) if not np.isfinite(run(signals, at, variables)[0])]
    if not wrong:
        return failure(programs, index, variables) + _inputs(instant, programs, index)
    root = min(wrong, key=lambda at: len(_code(signals, at)))  # a signal that names another one has longer code
    said = f"signal '{names[root]}' is not finite: '{signals.texts[root]}', {failure(signals, root, variables)}"
    return said + _inputs(instant, signals, root)


def _code(programs: ProgramSet, index: int) -> bytes:
    """Return the instructions of a program as bytes."""
    instructions = slice(int(programs.start[index]), int(programs.start[index + 1]))
    return np.column_stack([programs.op[instructions].astype(float), programs.operand[instructions]]).tobytes()


def _signals_in(signals: ProgramSet, programs: ProgramSet, index: int) -> Iterator[int]:
    """The numbers of the signals whose code is a part of a program's code. Signals with tables are not found, because
    each set numbers its own tables."""
    whole = _code(programs, index)
    yield from (at for at in range(signals.size) if _code(signals, at) in whole)


def _inputs(instant: Instant, programs: ProgramSet, index: int) -> str:
    """Return the channels that a program names with their values, in words."""
    channels, names = instant.system.channels, instant.system.names
    instructions = range(int(programs.start[index]), int(programs.start[index + 1]))
    read = {int(programs.operand[at]) - CHANNELS for at in instructions if programs.op[at] == Op.VARIABLE}
    said = []
    for channel in sorted(number for number in read if number >= 0):
        kind, at = ChannelKind(int(channels.kind[channel])), int(channels.index[channel])
        name = names.states[at] if kind is ChannelKind.STATE else names.coordinates[at]
        value = float(instant.channels[..., channel])
        said.append(f"{name}{'_dot' if kind is ChannelKind.RATE else ''} = {value:.6g}")
    return f", with {shortened(said, MOST_INPUTS)}" if said else ""
