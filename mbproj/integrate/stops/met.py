"""What a run has met, where the kernel's loop leaves over what happens then."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.model.system import System


@dataclass(frozen=True)
class Meaning:
    """What it is that a run has met: a stop or a friction; a contact of that stop that is `released`, a friction that
    comes to `rest`."""

    stop: int | None = None
    friction: int | None = None
    released: bool = False
    rest: bool = False

    @property
    def let_go(self) -> tuple[int, ...]:
        """The stop that is released, or none."""
        return () if self.stop is None or not self.released else (self.stop,)

    def name(self, system: System) -> str:
        """For messages."""
        if self.friction is not None:
            return f"friction '{system.names.frictions[self.friction]}'"
        return "" if self.stop is None else f"stop '{system.names.stops[self.stop]}'"


@dataclass(frozen=True)
class Met:
    """What a run has met: stops that are `released`, a friction that comes to `rest`, or nothing of these; and the
    `fastest` motion of the run so far, 1/s. `again`: a stop whose gap would close from here on, though nothing presses
    it yet: it does from here on."""

    released: tuple[int, ...] = ()
    rest: int | None = None
    fastest: float = 0.0
    again: int | None = None
