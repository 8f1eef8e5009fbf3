"""The variables of a scene's functions at a state: the time and channels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from mbproj.base.arrays import Array, Numbers, like_of, numbers
from mbproj.base.dataclass import dataclass
from mbproj.equations.constraints import set_velocity
from mbproj.equations.kinematics import Pose, Twist
from mbproj.functions.program import TIME
from mbproj.model.channels import ChannelKind
from mbproj.model.system import System

if TYPE_CHECKING:
    from mbproj.functions.series import Series


def of_signals(instant: Instant) -> Numbers:
    """Return the values of the signals of a scene, (..., S)."""
    from mbproj.functions.values import values

    programs = instant.system.signals
    each = values(programs, range(programs.size), instant.values())
    return np.stack([np.broadcast_to(signal, instant.channels.shape[:-1]) for signal in each], axis=-1)


def no_states() -> Array:
    """Return the states of a system without states of elements."""
    return np.zeros(0)


@dataclass(frozen=True, eq=False)
class Instant:
    """A system at times t (...), in poses and with twists (...). `counted`: the joints' coordinates (..., nc) to within
    half a turn, or a function that computes them on first use. `x` (..., K): the states of elements."""

    system: System
    pose: Pose
    twist: Twist
    t: Numbers | float
    counted: Numbers | Callable[[], Numbers]
    x: Numbers = field(default_factory=no_states)

    @cached_property
    def expected(self) -> Numbers:
        """The joints' coordinates to within half a turn, (..., nc), which give the whole turns of angles."""
        return self.counted() if callable(self.counted) else self.counted

    @cached_property
    def channels(self) -> Numbers:
        """The values of all channels, (..., c)."""
        channels, bound = self.system.channels, self.system.coordinates
        like = like_of(self.pose.position, bound.local, self.x)
        channel_values = np.empty((*self.pose.position.shape[:-2], channels.size), like=like)
        by_kind = {ChannelKind.STATE: self.x}
        if not channels.is_state.all():
            value = bound.value(self.pose.places(bound))
            if self.expected.shape[-1]:
                from mbproj.equations.turning import near

                value = near(self.system, value, self.expected)
            by_kind |= {ChannelKind.COORDINATE: value, ChannelKind.RATE: self.speed}
        for kind, values in by_kind.items():
            here, index = channels.places[kind]
            channel_values[..., here] = values[..., index]
        return channel_values

    @cached_property
    def speed(self) -> Numbers:
        """The rates of the joints' coordinates, (..., nc)."""
        return set_velocity(self.system.coordinates, self.pose, self.twist)

    def values(self, s: Numbers | float = 0.0, rate: Numbers | float = 0.0) -> list[Numbers]:
        """Return the variables of a program that acts along a coordinate s with this rate, (...) each."""
        variables: list[Any] = [numbers(each) for each in (self.t, s, rate)]
        shape = self.channels.shape[:-1]
        broadcast = (each if each.shape == shape else np.broadcast_to(each, shape) for each in variables)
        return [*broadcast, *self._each]

    @cached_property
    def _each(self) -> list[Numbers]:
        """The channels one by one, (...) each."""
        return list(np.moveaxis(self.channels, -1, 0))

    def variables(self, s: Numbers | float = 0.0, rate: Numbers | float = 0.0) -> Sequence[Series]:
        """Return the variables as series in time; all but the time are taken as constant."""
        from mbproj.functions.series import Variables, time_series

        values = self.values(s, rate)
        return Variables(values, {TIME: time_series(values[TIME])})
