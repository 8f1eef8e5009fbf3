"""The variables of a scene's functions at a state: the time and channels; and the cause of a value that is not
finite."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import set_velocity
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.functions.program import CHANNELS, TIME, Op
from mbproj.functions.program_set import ProgramSet
from mbproj.lanes import one_of
from mbproj.model.channels import ChannelKind
from mbproj.model.system import System
from mbproj.several import is_several

if TYPE_CHECKING:
    from mbproj.functions.taylor import Series

#: The most inputs that a message lists.
MOST_INPUTS = 6


def of_signals(instant: Instant) -> Numbers:
    """Return the values of the signals of a scene, (..., S)."""
    from mbproj.functions.series import run

    programs, variables = instant.system.signals, instant.variables()
    values = (run(programs, at, variables)[0] for at in range(programs.size))
    return np.stack([np.broadcast_to(value, instant.channels.shape[:-1]) for value in values], axis=-1)


def no_states() -> Array:
    """Return the states of a system without states of elements."""
    return np.zeros(0)


@dataclass(frozen=True, eq=False)
class Instant:
    """A system at times t (...), in poses and with twists (...). `expected` (..., nc): the joints' coordinates, each to
    less than half a turn, from which angles take their turns. `x` (..., K): the states of elements."""

    system: System
    pose: Pose
    twist: Twist
    t: Numbers | float
    expected: Numbers
    x: Numbers = field(default_factory=no_states)

    @cached_property
    def channels(self) -> Numbers:
        """The values of all channels, (..., c)."""
        channels, bound = self.system.channels, self.system.coordinates
        like = one_of((self.pose.position, bound.local, self.x))
        channel_values = np.empty((*self.pose.position.shape[:-2], channels.size), like=like)
        given = {ChannelKind.STATE: self.x}
        if not channels.is_state.all():
            value = bound.value(self.pose.places(bound))
            if self.expected.shape[-1]:
                from mbproj.dynamics.equations.teeth import near

                value = near(self.system, value, self.expected)
            given |= {ChannelKind.COORDINATE: value, ChannelKind.RATE: self.speed}
        for kind, values in given.items():
            here, index = channels.places[kind]
            channel_values[..., here] = values[..., index]
        return channel_values

    @cached_property
    def speed(self) -> Numbers:
        """The rates of the joints' coordinates, (..., nc)."""
        return set_velocity(self.system.coordinates, self.pose, self.twist)

    def values(self, s: Numbers | float = 0.0, rate: Numbers | float = 0.0) -> list[Numbers]:
        """Return the variables of a program that acts along a coordinate s with this rate, (...) each."""
        given: list[Any] = [each if is_several(each) else np.asarray(each, dtype=float) for each in (self.t, s, rate)]
        shape = self.channels.shape[:-1]
        own = (each if each.shape == shape else np.broadcast_to(each, shape) for each in given)
        return [*own, *self._each]

    @cached_property
    def _each(self) -> list[Numbers]:
        """The channels one by one, (...) each."""
        return list(np.moveaxis(self.channels, -1, 0))

    def variables(self, s: Numbers | float = 0.0, rate: Numbers | float = 0.0) -> Sequence[Series]:
        """Return the variables as series in time; all but the time are taken as constant."""
        from mbproj.functions.series import Variables, time_series

        values = self.values(s, rate)
        return Variables(values, {TIME: time_series(values[TIME])})


def cause_of(instant: Instant, programs: ProgramSet, index: int, variables: Sequence[Series]) -> str:
    """Return the cause of a value that is not finite, in words: "sqrt(-0.25) is not finite, with pin.angle = 0.3".

    Where a signal in the program has no finite value, the words are on that signal, the first in the order of
    evaluation."""
    from mbproj.functions.series import failure, run

    signals, names = instant.system.signals, instant.system.names.signals
    wrong = [at for at in _within(signals, programs, index) if not np.isfinite(run(signals, at, variables)[0])]
    if not wrong:
        return failure(programs, index, variables) + _inputs(instant, programs, index)
    root = min(wrong, key=lambda at: len(_code(signals, at)))  # a signal that names another one has longer code
    said = f"signal '{names[root]}' is not finite: '{signals.texts[root]}', {failure(signals, root, variables)}"
    return said + _inputs(instant, signals, root)


def _code(programs: ProgramSet, index: int) -> bytes:
    """Return the instructions of a program as bytes."""
    own = slice(int(programs.start[index]), int(programs.start[index + 1]))
    return np.column_stack([programs.op[own].astype(float), programs.operand[own]]).tobytes()


def _within(signals: ProgramSet, programs: ProgramSet, index: int) -> Iterator[int]:
    """The numbers of the signals whose code is a part of a program's code. Signals with tables are not found, because
    each set numbers its own tables."""
    whole = _code(programs, index)
    yield from (at for at in range(signals.size) if _code(signals, at) in whole)


def _inputs(instant: Instant, programs: ProgramSet, index: int) -> str:
    """Return the channels that a program names with their values, in words."""
    channels, names = instant.system.channels, instant.system.names
    own = range(int(programs.start[index]), int(programs.start[index + 1]))
    read = {int(programs.operand[at]) - CHANNELS for at in own if programs.op[at] == Op.VARIABLE}
    said = []
    for channel in sorted(number for number in read if number >= 0):
        kind, at = ChannelKind(int(channels.kind[channel])), int(channels.index[channel])
        name = names.states[at] if kind is ChannelKind.STATE else names.coordinates[at]
        value = float(instant.channels[..., channel])
        said.append(f"{name}{'_dot' if kind is ChannelKind.RATE else ''} = {value:.6g}")
    more = f" and {len(said) - MOST_INPUTS} more" if len(said) > MOST_INPUTS else ""
    return f", with {', '.join(said[:MOST_INPUTS])}{more}" if said else ""
