"""Joint coordinates between steps: what is known of them near a state whose turns are counted."""

from __future__ import annotations

from dataclasses import dataclass

from mbproj.arrays import Array


@dataclass(frozen=True, eq=False)
class Turning:
    """The joints' coordinates (nc,) at time t in s, turns counted, and their rates."""

    t: float
    coordinate: Array
    speed: Array

    def expected(self, t: float) -> Array:
        """Where they are at a time near by, (nc,): what tells a turn from the next in a step."""
        return self.coordinate + (t - self.t) * self.speed
