"""The layout of y: the blocks of a state, and of the integrated vector. No other module counts places in y.

A state has positions q and velocities q' in 7 coordinates a body, the whole turns of the joints' coordinates, and the
states of elements. A run integrates positions, velocities and states. It also integrates the work of forces, and the
angles that forces or gears follow from stage to stage. A block that is listed here is recorded, continued, checked for
numbers that are not finite, and controlled in its error.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from mbproj.base.arrays import Array, Integers, like_of
from mbproj.base.dataclass import dataclass

#: The scale of numbers whose errors have no effect on the step size.
UNCONTROLLED = np.inf


@dataclass(frozen=True, eq=False)
class Block:
    """Some consecutive numbers of y.

    `scale` (size,): the magnitude to which the absolute tolerance is relative; `UNCONTROLLED` where errors do not limit
    the step. `projected`: whether a projection moves them. `start` (size,): the initial values; None where the
    assembled pose gives them. `dataset`: where they are recorded as they are, with `names` and `units` (size,); None
    where only quantities derived from them are recorded.
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
        """The number of entries."""
        return len(self.scale)

    @property
    def is_controlled(self) -> bool:
        """Whether its errors limit the step size."""
        return bool(np.isfinite(self.scale).all())


def uncontrolled(name: str, size: int) -> Block:
    """Return a block that starts with zeros and whose errors do not limit the step size."""
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
        """Return the slice of a block in the vector."""
        return self._slices[name]

    def size_of(self, name: str) -> int:
        """Return the number of entries of a block."""
        return self[name].stop - self[name].start

    @cached_property
    def size(self) -> int:
        """The number of entries of the vector."""
        return sum(block.size for block in self.blocks)

    @cached_property
    def controlled(self) -> slice:
        """The slice of the blocks whose errors are controlled; they come first."""
        return slice(0, sum(block.size for block in self.blocks if block.is_controlled))

    @cached_property
    def scale(self) -> Array:
        """The magnitudes to which the absolute tolerance is relative, (size,)."""
        return np.concatenate([block.scale for block in self.blocks])

    def vector_of(self, parts: Mapping[str, Array | Integers]) -> Array:
        """Return the vector (..., size) made of the blocks `parts`, each (..., its size); the others have their initial
        values."""
        y = np.empty((*next(iter(parts.values())).shape[:-1], self.size), like=like_of(*parts.values()))
        for block in self.blocks:
            y[..., self[block.name]] = parts[block.name] if block.start is None else parts.get(block.name, block.start)
        return y

    @property
    def recorded(self) -> dict[str, str]:
        """The names of the blocks that are recorded as they are, by dataset."""
        return {block.dataset: block.name for block in self.blocks if block.dataset and block.size}

    def common_blocks(self, y: Array, other: Layout) -> dict[str, Array]:
        """Return the blocks of y (..., size) that another layout also has."""
        return {block.name: y[..., self[block.name]] for block in self.blocks if block.name in other._slices}

    def changed(self, y: Array, parts: Mapping[str, Array | Integers]) -> Array:
        """Return a copy of y with the blocks `parts` in place of its own."""
        return self.vector_of({**self.common_blocks(y, self), **parts})
