"""What a check finds: a number, how large it may be, and whether that holds."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.studies.verify.rounded import EPS

#: Where round-off alone may change a result by this part of itself, nothing can be told.
VACUOUS = 0.1


@dataclass(frozen=True)
class Finding:
    """`measured` and the bound `allowed` on it, in the same unit; `remark`: what a reader should know besides."""

    measured: float
    allowed: float
    remark: str = ""
    #: Whether `measured` is to be at least `allowed` instead.
    at_least: bool = False

    @property
    def passed(self) -> bool:
        """Whether it holds."""
        good = self.measured >= self.allowed if self.at_least else self.measured <= self.allowed
        return bool(good)


#: What a check returns: what it found, or why it does not apply.
Found = Finding | str


def difference(one: Array, other: Array, bound: Array, scale: Array | float = 1.0, whole: float | None = None) -> Found:
    """Two results that are to be equal to within `bound`, componentwise, each in units of its `scale`, as parts of
    `whole`: of the largest of `other` where that is not given. The component nearest to its bound, or farthest beyond
    it, is told."""
    if not one.size:
        return "nothing to compare"
    if whole is None:
        whole = float(np.abs(other / scale).max())
    if whole == 0.0:
        return "nothing moves: all that is compared is zero"
    gap, allowed = np.abs(one - other) / (scale * whole), bound / (scale * whole) + EPS
    worst = int(np.argmax(gap / allowed))
    if allowed.flat[worst] > 1.0:
        return "what is compared is nothing but round-off"
    if allowed.flat[worst] > VACUOUS:
        return f"round-off alone may change it by {allowed.flat[worst]:.1g} of its size: nothing can be told"
    return Finding(float(gap.flat[worst]), float(allowed.flat[worst]))


def worse(findings: list[Found]) -> Found:
    """The finding that is nearest to its bound, or farthest beyond it; the first reason where there is none."""
    numbers = [each for each in findings if isinstance(each, Finding)]
    if not numbers:
        return findings[0]
    return max(numbers, key=lambda each: each.measured / each.allowed if each.allowed else np.inf)
