"""Samples of a run, as the integration hands them over: consecutive times, with what each formulation knows there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import cache, cached_property

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.model.layout import Layout

#: A block has so many samples of so many bodies together, within these bounds: what it takes to observe a block is then
#: small beside its samples, and so is its memory (some MB).
BODY_SAMPLES, FEWEST, MOST = 10_000, 20, 1024
#: Bytes of a block's arrays that the process keeps for the next.
KEPT_BYTES = 2**23


def block_samples(bodies: int) -> int:
    """How many samples a block has at most."""
    return max(FEWEST, min(MOST, BODY_SAMPLES // bodies))


@cache
def keep_freed_memory() -> None:
    """glibc gives arrays of more than 128 kB back to the system when they are freed, and new ones get new pages: half
    of the time of a block. Once so many bytes were freed at a time, it keeps as many."""
    np.empty(KEPT_BYTES, dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class Sample:
    """A state: its acceleration q'' (7n,), multipliers λ of the joints' rows and then the motions', step size in s,
    counters.

    `work` (2 + K,): what forces and motions have worked, what dampers and friction have dissipated since the start, and
    of that each dry friction, J."""

    state: State
    acceleration: Array
    multipliers: Array
    step_size: float
    work: Array
    counters: Mapping[str, int]


@dataclass(frozen=True, eq=False)
class Samples:
    """T consecutive samples: the fields of `Sample` with a leading axis of length T; y (T, N) has the `layout` of a
    state. `carried` (T, m) are the multipliers that the run gave, and `solved` makes from the samples those that are
    recorded, which may cost more than all else: they are solved for where somebody asks.
    `press`: how hard each stop pushes, (T, S), where there are stops. `rub`: the force of each dry friction, and the
    sign of its sliding, 0 while it sticks, (T, K) each, where there are some."""

    t: Array
    y: Array
    layout: Layout
    acceleration: Array
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
    def q(self) -> Array:
        """(T, 7n)."""
        return self.y[:, self.layout["positions"]]

    @property
    def v(self) -> Array:
        """(T, 7n)."""
        return self.y[:, self.layout["velocities"]]

    @property
    def x(self) -> Array:
        """States of elements, (T, K)."""
        return self.y[:, self.layout["states"]]

    @property
    def turns(self) -> Integers:
        """(T, nc)."""
        return self.y[:, self.layout["turns"]].astype(np.intp)

    def state(self, at: int) -> State:
        """That of one sample."""
        return State(float(self.t[at]), self.y[at].copy(), self.layout)


def stack(samples: Sequence[Sample]) -> Samples:
    """One block of at least one sample."""
    return Samples(
        t=np.array([sample.state.t for sample in samples]),
        y=np.stack([sample.state.y for sample in samples]),
        layout=samples[0].state.layout,
        acceleration=np.stack([sample.acceleration for sample in samples]),
        carried=np.stack([sample.multipliers for sample in samples]),
        solved=lambda stacked: stacked.carried,
        step_size=np.array([sample.step_size for sample in samples]),
        work=np.stack([sample.work for sample in samples]),
        counters={key: np.array([sample.counters[key] for sample in samples]) for key in samples[0].counters},
    )


def join(blocks: Sequence[Samples]) -> Samples:
    """One block of at least one."""
    if len(blocks) == 1:
        return blocks[0]
    arrays = {
        field.name: np.concatenate([getattr(block, field.name) for block in blocks])
        for field in fields(Samples)
        if field.name not in {"layout", "counters", "carried", "solved", "press", "rub"}
    }
    solved = blocks[0].solved
    alike = all(block.solved == solved for block in blocks)
    counters = {key: np.concatenate([block.counters[key] for block in blocks]) for key in blocks[0].counters}
    pressing = [block.press for block in blocks if block.press is not None]
    rubbing = [block.rub for block in blocks if block.rub is not None]
    return Samples(
        **arrays,
        layout=blocks[0].layout,
        carried=np.concatenate([block.carried for block in blocks]) if alike else arrays["work"][:, :0],
        solved=solved if alike else lambda _: np.concatenate([block.multipliers for block in blocks]),
        counters=counters,
        press=(lambda: np.concatenate([press() for press in pressing])) if pressing else None,
        rub=(lambda: _side_by_side([rub() for rub in rubbing])) if rubbing else None,
    )


def _side_by_side(blocks: Sequence[tuple[Array, Array]]) -> tuple[Array, Array]:
    """The forces and the states of frictions, block after block."""
    return np.concatenate([force for force, _ in blocks]), np.concatenate([state for _, state in blocks])
