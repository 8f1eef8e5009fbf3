"""The layout of y: the blocks of a state, and of what is integrated. Nobody else counts where in y something is.

A state has positions q and velocities q' in 7 coordinates a body, the whole turns of the joints' coordinates, and the
states of elements. A run integrates positions, velocities and states; beside them the work that forces have done, and
angles that forces or gears follow from stage to stage. A block that is new is recorded, continued, looked at for
numbers that are not finite, and controlled in its error by its entry here.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass

#: Of numbers whose errors have no say in the size of a step.
UNCONTROLLED = np.inf


@dataclass(frozen=True, eq=False)
class Block:
    """Some numbers of y, one after another.

    `scale` (size,): what the absolute tolerance is relative to; `UNCONTROLLED` where errors have no say in the step.
    `projected`: whether a projection moves them. `start` (size,): with what a run begins; None where the assembled pose
    says it. `dataset`: where they are recorded as they are, by `names` and `units` (size,); None where only what
    follows from them is recorded.
    """

    name: str
    scale: Array
    start: Array | None = None
    projected: bool = False
    dataset: str | None = None
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """How many numbers."""
        return len(self.scale)

    @property
    def is_controlled(self) -> bool:
        """Whether its errors have a say in the step."""
        return bool(np.isfinite(self.scale).all())


def uncontrolled(name: str, size: int) -> Block:
    """A block whose errors have no say in the step, and that begins with zeros."""
    return Block(name, np.full(size, UNCONTROLLED), np.zeros(size))


@dataclass(frozen=True, eq=False)
class Layout:
    """The blocks of a vector, in their order."""

    blocks: tuple[Block, ...]

    @cached_property
    def _slices(self) -> Mapping[str, slice]:
        ends = np.cumsum([0, *(block.size for block in self.blocks)]).tolist()
        return {block.name: slice(*ends[i : i + 2]) for i, block in enumerate(self.blocks)}

    def __getitem__(self, name: str) -> slice:
        """Where a block is."""
        return self._slices[name]

    def size_of(self, name: str) -> int:
        """How many numbers a block has."""
        return self[name].stop - self[name].start

    @cached_property
    def size(self) -> int:
        """Of the vector."""
        return sum(block.size for block in self.blocks)

    @cached_property
    def controlled(self) -> slice:
        """The blocks that come first: those whose errors are controlled."""
        return slice(0, sum(block.size for block in self.blocks if block.is_controlled))

    @cached_property
    def scale(self) -> Array:
        """What the absolute tolerance is relative to, (size,)."""
        return np.concatenate([block.scale for block in self.blocks])

    def joined(self, parts: Mapping[str, Array | Integers]) -> Array:
        """The vector (..., size) of these blocks, (..., their sizes); the others are as a run begins with them."""
        y = np.empty((*next(iter(parts.values())).shape[:-1], self.size))
        for block in self.blocks:
            y[..., self[block.name]] = parts[block.name] if block.start is None else parts.get(block.name, block.start)
        return y

    @property
    def recorded(self) -> dict[str, str]:
        """The names of the blocks that are recorded as they are, by their datasets."""
        return {block.dataset: block.name for block in self.blocks if block.dataset and block.size}

    def shared(self, y: Array, other: Layout) -> dict[str, Array]:
        """The blocks of y (..., size) that another layout has, too."""
        return {block.name: y[..., self[block.name]] for block in self.blocks if block.name in other._slices}

    def changed(self, y: Array, parts: Mapping[str, Array | Integers]) -> Array:
        """A copy of y with these blocks in place of its own."""
        return self.joined({**self.shared(y, self), **parts})
