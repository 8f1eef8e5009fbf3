"""Samples of a run at consecutive times, as the integration yields them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import cache, cached_property
from typing import final

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.equations.assembly.assemble import State
from mbproj.model.layout import Layout

#: The number of samples of a block times that of bodies, and the bounds of the number of samples. The fixed cost of
#: observing a block is then small beside that of its samples, and its memory is some MB.
BODY_SAMPLES, FEWEST, MOST = 10_000, 20, 1024
#: The bytes of a block's arrays that the process keeps for the next block.
KEPT_BYTES = 2**23


def block_samples(bodies: int) -> int:
    """Return the largest number of samples in a block."""
    return max(FEWEST, min(MOST, BODY_SAMPLES // bodies))


@cache
def keep_freed_memory() -> None:
    """Make glibc keep freed memory for the arrays of the next block.

    By default it returns arrays of more than 128 kB to the system when they are freed. New arrays then need new pages,
    which takes half of the time of a block. After one release of KEPT_BYTES, glibc keeps up to that size."""
    np.empty(KEPT_BYTES, dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class Sample:
    """A state with its acceleration q'' (7n,), multipliers λ of the joints' rows and then the motions', step size in s,
    and counters.

    `work` (2 + K,) since the start, in J: the work of forces and motions, the energy dissipated by dampers and
    friction, and the part of it by each of K dry frictions."""

    state: State
    acceleration: Array
    multipliers: Array
    step_size: float
    work: Array
    counters: Mapping[str, int]


class Motion(ABC):
    """The motion at T samples, each part of which is computed on first use. y has the `layout` of a state."""

    layout: Layout

    @property
    @abstractmethod
    def y(self) -> Array:
        """States, (T, N)."""

    @property
    @abstractmethod
    def q(self) -> Array:
        """Coordinates, (T, 7n), with time innermost in memory; so is it in v and q''."""

    @property
    @abstractmethod
    def v(self) -> Array:
        """Velocities q', (T, 7n)."""

    @property
    @abstractmethod
    def acceleration(self) -> Array:
        """q'', (T, 7n)."""

    @property
    @abstractmethod
    def x(self) -> Array:
        """States of elements, (T, K)."""

    def state(self, t: float, at: int) -> State:
        """Return the state of one sample."""
        return State(t, self.y[at].copy(), self.layout)

    def chosen(self, rows: Integers | slice) -> Motion:
        """Return the motion at some of the samples."""
        return GivenMotion(self.layout, self.y[rows], self.acceleration[rows])


@final
class GivenMotion(Motion):
    """The motion with given states (T, N) and accelerations (T, 7n)."""

    def __init__(self, layout: Layout, y: Array, acceleration: Array) -> None:
        self.layout, self._y, self._acceleration = layout, y, acceleration

    @property
    def y(self) -> Array:
        return self._y

    @cached_property
    def q(self) -> Array:
        return np.asfortranarray(self._y[:, self.layout["positions"]], like=self._y)

    @cached_property
    def v(self) -> Array:
        return np.asfortranarray(self._y[:, self.layout["velocities"]], like=self._y)

    @property
    def x(self) -> Array:
        return self._y[:, self.layout["states"]]

    @cached_property
    def acceleration(self) -> Array:
        return np.asfortranarray(self._acceleration, like=self._acceleration)


@dataclass(frozen=True, eq=False)
class Samples:
    """T consecutive samples: the fields of `Sample` with a leading axis of length T.

    `carried` (T, m) are the multipliers from the run. `solved` computes the multipliers to be recorded from the
    samples, on first use, because it can cost more than all else. `press`: the push of each stop, (T, S), where there
    are stops. `rub`: the force of each dry friction and the sign of its sliding, 0 while it sticks, (T, K) each, where
    there are some."""

    t: Array
    motion: Motion
    carried: Array
    solved: Callable[[Samples], Array]
    step_size: Array
    work: Array
    counters: Mapping[str, Integers]
    press: Callable[[], Array] | None = None
    rub: Callable[[], tuple[Array, Array]] | None = None

    @cached_property
    def multipliers(self) -> Array:
        """λ of the joints' rows and then the motions', (T, m)."""
        return self.solved(self)

    @property
    def layout(self) -> Layout:
        """The layout of y."""
        return self.motion.layout

    @property
    def y(self) -> Array:
        """States, (T, N)."""
        return self.motion.y

    @property
    def q(self) -> Array:
        """Coordinates, (T, 7n)."""
        return self.y[:, self.layout["positions"]]

    @property
    def v(self) -> Array:
        """Velocities q', (T, 7n)."""
        return self.y[:, self.layout["velocities"]]

    @property
    def acceleration(self) -> Array:
        """q'', (T, 7n)."""
        return self.motion.acceleration

    @property
    def x(self) -> Array:
        """States of elements, (T, K)."""
        return self.motion.x

    @property
    def turns(self) -> Integers:
        """Whole turns of the joints' coordinates, (T, nc)."""
        return self.y[:, self.layout["turns"]].astype(np.intp)

    def state(self, at: int) -> State:
        """Return the state of one sample."""
        return self.motion.state(float(self.t[at]), at)


def stack(samples: Sequence[Sample]) -> Samples:
    """Return at least one sample as a block."""
    return Samples(
        t=np.array([sample.state.t for sample in samples]),
        motion=GivenMotion(
            samples[0].state.layout,
            np.stack([sample.state.y for sample in samples]),
            np.stack([sample.acceleration for sample in samples]),
        ),
        carried=np.stack([sample.multipliers for sample in samples]),
        solved=lambda stacked: stacked.carried,
        step_size=np.array([sample.step_size for sample in samples]),
        work=np.stack([sample.work for sample in samples]),
        counters={key: np.array([sample.counters[key] for sample in samples]) for key in samples[0].counters},
    )


def join(blocks: Sequence[Samples]) -> Samples:
    """Return at least one block as a single block."""
    if len(blocks) == 1:
        return blocks[0]
    arrays = {
        field.name: np.concatenate([getattr(block, field.name) for block in blocks])
        for field in fields(Samples)
        if field.name not in {"motion", "counters", "carried", "solved", "press", "rub"}
    }
    solved = blocks[0].solved
    alike = all(block.solved == solved for block in blocks)
    counters = {key: np.concatenate([block.counters[key] for block in blocks]) for key in blocks[0].counters}
    pressing = [block.press for block in blocks if block.press is not None]
    rubbing = [block.rub for block in blocks if block.rub is not None]
    return Samples(
        **arrays,
        motion=GivenMotion(
            blocks[0].layout,
            np.concatenate([block.y for block in blocks]),
            np.concatenate([block.acceleration for block in blocks]),
        ),
        carried=np.concatenate([block.carried for block in blocks]) if alike else arrays["work"][:, :0],
        solved=solved if alike else lambda _: np.concatenate([block.multipliers for block in blocks]),
        counters=counters,
        press=(lambda: np.concatenate([press() for press in pressing])) if pressing else None,
        rub=(lambda: _side_by_side([rub() for rub in rubbing])) if rubbing else None,
    )


def _side_by_side(blocks: Sequence[tuple[Array, Array]]) -> tuple[Array, Array]:
    """Return the forces and the states of frictions of all blocks, joined in time."""
    return np.concatenate([force for force, _ in blocks]), np.concatenate([state for _, state in blocks])
