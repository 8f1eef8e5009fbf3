"""What functions of a scene see at a state: the time, and channels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from functools import cached_property

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import set_velocity
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.dynamics.equations.teeth import near
from mbproj.functions.program import TIME
from mbproj.functions.series import Variables, run, time_series
from mbproj.functions.taylor import Series
from mbproj.model.channels import Kind
from mbproj.model.system import System


def of_signals(instant: Instant) -> Numbers:
    """The signals of a scene, (..., S)."""
    programs, variables = instant.system.signals, instant.variables()
    values = (run(programs, at, variables)[0] for at in range(programs.size))
    return np.stack([np.broadcast_to(value, instant.channels.shape[:-1]) for value in values], axis=-1)


def no_states() -> Array:
    """Those of a system without elements that have some."""
    return np.zeros(0)


@dataclass(frozen=True, eq=False)
class Instant:
    """A system at times t (...), in poses and with twists (...). `expected` (..., nc): the joints' coordinates, each to
    less than half a turn, from which angles take their turns; `x` (..., K): states of elements."""

    system: System
    pose: Pose
    twist: Twist
    t: Numbers | float
    expected: Numbers
    x: Numbers = field(default_factory=no_states)

    @cached_property
    def channels(self) -> Numbers:
        """All channels, (..., c)."""
        channels, bound = self.system.channels, self.system.coordinates
        found = np.empty((*self.pose.position.shape[:-2], channels.size))
        if not channels.is_state.all():
            value = bound.value(self.pose.places(bound))
            value = near(self.system, value, self.expected) if self.expected.shape[-1] else value
            for kind, values in ((Kind.COORDINATE, value), (Kind.RATE, set_velocity(bound, self.pose, self.twist))):
                found[..., channels.kind == kind] = values[..., channels.index[channels.kind == kind]]
        found[..., channels.is_state] = self.x[..., channels.index[channels.is_state]]
        return found

    def values(self, s: Numbers | float = 0.0, rate: Numbers | float = 0.0) -> list[Numbers]:
        """The variables of a program that acts along a coordinate s with this rate, (...) each."""
        own = (np.broadcast_to(np.asarray(each, dtype=float), self.channels.shape[:-1]) for each in (self.t, s, rate))
        return [*own, *self._each]

    @cached_property
    def _each(self) -> list[Numbers]:
        """The channels one by one, (...) each."""
        return list(np.moveaxis(self.channels, -1, 0))

    def variables(self, s: Numbers | float = 0.0, rate: Numbers | float = 0.0) -> Sequence[Series]:
        """The same; all but the time are taken as constant."""
        values = self.values(s, rate)
        return Variables(values, {TIME: time_series(values[TIME])})
