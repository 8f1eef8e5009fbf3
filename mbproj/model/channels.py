"""Channels (the scalars that functions of a scene name), states of elements, motions and controllers' actions, as
arrays."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from enum import IntEnum
from functools import cached_property

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem
from mbproj.functions.program_set import ProgramSet, flatten


class ChannelKind(IntEnum):
    """The kind of a channel: a state of an element, a joint coordinate, or the rate of one."""

    STATE = 0
    COORDINATE = 1
    RATE = 2


@dataclass(frozen=True, eq=False)
class Channels:
    """c scalars, beside the time and the force's own coordinate, that functions name. Variable CHANNELS + i of a
    program is channel i.

    `kind` (c,): see `ChannelKind`. `index` (c,): a number among the states of elements or among the system's
    coordinates.
    """

    kind: Integers
    index: Integers

    @classmethod
    def of(cls, channels: Sequence[tuple[ChannelKind, int]]) -> Channels:
        """Return channels with these pairs of a kind and an index, in this order."""
        numbers = np.array(channels, dtype=np.intp).reshape(-1, 2)
        return cls(numbers[:, 0].copy(), numbers[:, 1].copy())

    @property
    def size(self) -> int:
        """c."""
        return len(self.kind)

    @cached_property
    def is_state(self) -> npt.NDArray[np.bool_]:
        """Whether each channel is a state of an element, (c,); the others belong to joint coordinates."""
        return np.asarray(self.kind == ChannelKind.STATE)

    @cached_property
    def places(self) -> Mapping[ChannelKind, tuple[Integers, Integers]]:
        """The numbers of the channels of each kind, and their indices."""
        return {kind: (here := np.flatnonzero(self.kind == kind), self.index[here]) for kind in ChannelKind}


#: The channels of a system whose functions name none.
NO_CHANNELS = Channels.of([])


@dataclass(frozen=True, eq=False)
class ElementStates:
    """K first-order states of elements, x' = program(t, channels).

    `start` (K,): the initial values. `scale` (K,): the magnitude to which the absolute tolerance is relative. `counts`
    (K,): whether a state goes on changing while the mechanism is at rest.
    """

    start: Array
    scale: Array
    programs: ProgramSet
    counts: Array

    @property
    def size(self) -> int:
        """K."""
        return len(self.start)

    @property
    def rests(self) -> Array:
        """1 for each state with x' = 0 at an equilibrium, 0 for a state that `counts`, (K,)."""
        return np.where(self.counts, 0.0, 1.0)


NO_STATES = ElementStates(np.zeros(0), np.zeros(0), flatten([]), np.zeros(0, dtype=bool))


@dataclass(frozen=True, eq=False)
class Energies:
    """The energies in J, functions of time and channels, that elements have stored and that they have lost."""

    stored: ProgramSet
    lost: ProgramSet


#: The signals of a scene without any.
NO_SIGNALS = flatten([])
NO_ENERGIES = Energies(flatten([]), flatten([]))


@dataclass(frozen=True, eq=False)
class Motions:
    """k rheonomic constraints s(q) - start - f(t) = 0 (Haug 1989, sect. 9.5), one row each.

    `joint_coordinate` (k,): the number of s among the system's coordinates. `start` (k,): the value from which f
    counts. `programs`: the functions f. `places`: the place of each motion in the scene file.
    """

    joint_coordinate: Integers
    start: Array
    programs: ProgramSet
    places: tuple[Place | None, ...]

    @property
    def size(self) -> int:
        """k."""
        return len(self.start)


NO_MOTIONS = Motions(np.zeros(0, dtype=np.intp), np.zeros(0), flatten([]), ())


#: The most instants of a controller in one run: each takes some 200 bytes.
MOST_INSTANTS = 2_000_000


@dataclass(frozen=True, eq=False)
class Actions:
    """A actions of controllers at the times first + k period, k = 0, 1, ...; actions at one time run in their order.

    `first`, `period` (A,) in s. Action a sets the states `state[start[a]:start[a + 1]]`, `start` (A+1,), all at once.
    The new values are those of `programs` for the time and the channels before the action. `names` (A,): the
    controllers, for messages.
    """

    first: Array
    period: Array
    start: Integers
    state: Integers
    programs: ProgramSet
    names: tuple[str, ...]

    @property
    def size(self) -> int:
        """A."""
        return len(self.first)

    def sets(self, action: int) -> range:
        """Return the range of the entries of `state`, and of `programs`, that belong to an action."""
        return range(*self.start[action : action + 2].tolist())

    def instants(self, start: float, end: float, slack: float) -> Mapping[float, tuple[int, ...]]:
        """Return the actions at each time from `start` to `end`; an action within `slack` before `start` is at `start`.
        Raises InputError where there are too many to store."""
        for name, period in zip(self.names, self.period.tolist(), strict=True):
            count = (end - start) / period
            if count > MOST_INSTANTS:
                what = f"{name} has {count:.2g} instants in this run, at most {MOST_INSTANTS:.2g} are kept"
                raise InputError(Problem(what, hint="give it a longer period, or make the run shorter"))
        at_times = defaultdict[float, list[int]](list)
        for action, (first, period) in enumerate(zip(self.first.tolist(), self.period.tolist(), strict=True)):
            k = max(int(np.ceil((start - slack - first) / period)), 0)
            last = int(np.floor((end - first) / period))
            for time in (first + np.arange(k, last + 1) * period).tolist():
                at_times[time].append(action)
        return {time: tuple(actions) for time, actions in at_times.items()}


NO_ACTIONS = Actions(np.zeros(0), np.zeros(0), np.zeros(1, dtype=np.intp), np.zeros(0, dtype=np.intp), flatten([]), ())
