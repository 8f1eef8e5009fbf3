"""The row that couples coordinates of joints: of gears, racks, belts, differentials, and weighted sums."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from mbproj.dataclass import dataclass
from mbproj.functions.program import Program

#: The key of the function's unit in `units`, beside those of the coordinates.
FUNCTION = "f(s)"


@dataclass(frozen=True)
class Coupled:
    """The row Σ kᵢ sᵢ - function(s₀) = constant. `of` has the weights kᵢ by the names of the coordinates sᵢ, as
    "A.angle"; s₀ is the first.

    SI units and radians; the row is in m where a coordinate is a length, else in rad. Without a constant the sum keeps
    its value at the scene's pose, or is 0 where there is a function. Whole turns of the angles may change the sum by
    multiples of `period`; None: it follows from the weights and the function. `units` are those in which the scene
    gives the weights, by coordinate, the constant, by "", and the function, by `FUNCTION`; "" for none."""

    of: Mapping[str, float]
    function: Program | None = None
    constant: float | None = None
    period: float | None = None
    units: Mapping[str, str] = field(default_factory=dict, repr=False, compare=False)

    @property
    def joints(self) -> tuple[str, ...]:
        """The joint of each coordinate."""
        return tuple(name.partition(".")[0] for name in self.of)
