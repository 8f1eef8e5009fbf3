"""What functions of a scene name, what has states of its own, what is driven and what controllers do, as arrays."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.functions.program_set import ProgramSet, flatten


class ChannelKind(IntEnum):
    """What a channel is: a state of elements, a joint coordinate, or its rate."""

    STATE = 0
    COORDINATE = 1
    RATE = 2


@dataclass(frozen=True, eq=False)
class Channels:
    """c scalars that functions name beside the time and what they act along: variable CHANNELS + i of a program is
    channel i.

    `kind` (c,): see `Kind`; `index` (c,): among the states of elements, or the system's coordinates.
    """

    kind: Integers
    index: Integers

    @classmethod
    def of(cls, channels: Sequence[tuple[ChannelKind, int]]) -> Channels:
        """In this order."""
        numbers = np.array(channels, dtype=np.intp).reshape(-1, 2)
        return cls(numbers[:, 0].copy(), numbers[:, 1].copy())

    @property
    def size(self) -> int:
        """c."""
        return len(self.kind)

    @property
    def is_state(self) -> npt.NDArray[np.bool_]:
        """Which are states of elements, (c,); the others are of joint coordinates."""
        return np.asarray(self.kind == ChannelKind.STATE)


#: Of a system whose functions name none.
NO_CHANNELS = Channels.of([])


@dataclass(frozen=True, eq=False)
class ElementStates:
    """K first-order states of elements, x' = program(t, channels).

    `start`, `scale` (K,): with what a run begins, and what the absolute tolerance is relative to. `counts` (K,): those
    that go on where all else rests.
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
        """1 of each state that an equilibrium brings to rest, 0 of one that counts, (K,)."""
        return np.where(self.counts, 0.0, 1.0)


NO_STATES = ElementStates(np.zeros(0), np.zeros(0), flatten([]), np.zeros(0, dtype=bool))


@dataclass(frozen=True, eq=False)
class Energies:
    """In J, of the time and channels: what elements keep, and what they have lost."""

    stored: ProgramSet
    lost: ProgramSet


#: Of a scene without any.
NO_SIGNALS = flatten([])
NO_ENERGIES = Energies(flatten([]), flatten([]))


@dataclass(frozen=True, eq=False)
class Motions:
    """k rheonomic rows s(q) - start - f(t) = 0 (Haug 1989, sect. 9.5).

    `joint_coordinate` (k,): which of the system's coordinates each s is; `start` (k,): what the functions count from;
    `programs`: the f. `places`: where each stands in the scene file.
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


#: Of a controller in one run: each is kept with some 200 bytes.
MOST_INSTANTS = 2_000_000


@dataclass(frozen=True, eq=False)
class Actions:
    """A actions at the times first + k period, k = 0, 1, ...; those at one time in their order.

    `first`, `period` (A,) in s. `start` (A+1,): action a sets the states `state[start[a]:start[a + 1]]`, all at once,
    to what their `programs` are of the time and channels before. `names` (A,): of their controllers, for messages.
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
        """The entries of `state`, and the programs, of one of them."""
        return range(*self.start[action : action + 2].tolist())

    def is_held(self, states: int) -> npt.NDArray[np.bool_]:
        """Which of so many states they set, (states,)."""
        found: npt.NDArray[np.bool_] = np.zeros(states, dtype=bool)
        found[self.state] = True
        return found

    def instants(self, start: float, end: float, slack: float) -> Mapping[float, tuple[int, ...]]:
        """The actions at each time from `start` to `end`; one at `start` but for `slack` is there. Raises InputError
        where these are too many to be kept."""
        for name, period in zip(self.names, self.period.tolist(), strict=True):
            count = (end - start) / period
            if count > MOST_INSTANTS:
                what = f"{name} has {count:.2g} instants in this run, at most {MOST_INSTANTS:.2g} are kept"
                raise InputError(Problem(what, hint="give it a longer period, or make the run shorter"))
        found = defaultdict[float, list[int]](list)
        for action, (first, period) in enumerate(zip(self.first.tolist(), self.period.tolist(), strict=True)):
            k = max(int(np.ceil((start - slack - first) / period)), 0)
            last = int(np.floor((end - first) / period))
            for time in (first + np.arange(k, last + 1) * period).tolist():
                found[time].append(action)
        return {time: tuple(actions) for time, actions in found.items()}


NO_ACTIONS = Actions(np.zeros(0), np.zeros(0), np.zeros(1, dtype=np.intp), np.zeros(0, dtype=np.intp), flatten([]), ())
