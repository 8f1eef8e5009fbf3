"""What functions of a scene name, what has states of its own, and what is driven, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.functions.program_set import ProgramSet, flatten


class Kind(IntEnum):
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
    def of(cls, channels: Sequence[tuple[Kind, int]]) -> Channels:
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
        return np.asarray(self.kind == Kind.STATE)


#: Of a system whose functions name none.
NO_CHANNELS = Channels.of([])


@dataclass(frozen=True, eq=False)
class ElementStates:
    """K first-order states of elements, x' = program(t, channels).

    `start`, `scale` (K,): with what a run begins, and what the absolute tolerance is relative to.
    """

    start: Array
    scale: Array
    programs: ProgramSet

    @property
    def size(self) -> int:
        """K."""
        return len(self.start)


NO_STATES = ElementStates(np.zeros(0), np.zeros(0), flatten([]))


@dataclass(frozen=True, eq=False)
class Energies:
    """In J, of the time and channels: what elements keep, and what they have lost."""

    stored: ProgramSet
    lost: ProgramSet


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
