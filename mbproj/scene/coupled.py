"""What couples coordinates of joints: gears, racks, belts, differentials, and sums of any."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program


@dataclass(frozen=True)
class Coupled:
    """Σ kᵢ sᵢ - function(s₀) = constant, with the weights kᵢ of the coordinates sᵢ, s₀ the first, by name: "A.angle".

    SI units and radians; the row is in m where a coordinate is a length, else in rad. Without a constant the sum keeps
    what it is at the scene's pose; where there is a function, the constant is 0 then. `period`: what whole turns of the
    angles may change it by; None: what follows from the weights and the function. `units`: those that weights are
    written with, "" for none."""

    of: Mapping[str, float]
    function: Program | None = None
    constant: float | None = None
    period: float | None = None
    units: Mapping[str, str] = field(default_factory=dict, repr=False, compare=False)

    @property
    def joints(self) -> tuple[str, ...]:
        """The joint of each coordinate."""
        return tuple(name.partition(".")[0] for name in self.of)
