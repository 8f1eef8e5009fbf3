"""The finding of a check: a measured number, the bound on it, and whether the bound holds."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.studies.verify.rounded import EPS

#: Where round-off alone may change a result by more than this part of it, a comparison tells nothing.
VACUOUS = 0.1


@dataclass(frozen=True)
class Finding:
    """A measured number and the bound `allowed` on it, in the same unit. `remark` is a note for the reader."""

    measured: float
    allowed: float
    remark: str = ""
    #: Whether `allowed` is a lower bound on `measured` instead of an upper one.
    at_least: bool = False

    @property
    def passed(self) -> bool:
        """Whether the bound holds."""
        good = self.measured >= self.allowed if self.at_least else self.measured <= self.allowed
        return bool(good)


#: The result of a check: its finding, or the reason why it does not apply.
Found = Finding | str


def difference(one: Array, other: Array, bound: Array, scale: Array | float = 1.0, whole: float | None = None) -> Found:
    """Compare two results that are to be equal to within `bound`, component by component.

    Differences are in units of `scale`, as parts of `whole`, by default the largest component of `other`. Return the
    component that is nearest to its bound or farthest beyond it, or the reason why nothing can be told."""
    if not one.size:
        return "nothing to compare"
    if whole is None:
        whole = float(np.abs(other / scale).max())
    if whole == 0.0:
        return "nothing moves: all that is compared is zero"
    gap, allowed = np.abs(one - other) / (scale * whole), bound / (scale * whole) + EPS
    worst = int(np.argmax(gap / allowed))
    if allowed.flat[worst] > 1.0:
        return "both results are nothing but round-off"
    if allowed.flat[worst] > VACUOUS:
        return f"round-off alone may change it by {allowed.flat[worst]:.1g} of its size: nothing can be told"
    return Finding(float(gap.flat[worst]), float(allowed.flat[worst]))


def worse(findings: list[Found]) -> Found:
    """The finding that is nearest to its bound or farthest beyond it. Where there is none, return the first reason."""
    numbers = [each for each in findings if isinstance(each, Finding)]
    if not numbers:
        return findings[0]
    return max(numbers, key=lambda each: each.measured / each.allowed if each.allowed else np.inf)
