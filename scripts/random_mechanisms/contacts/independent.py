"""The independent solution: minimal coordinates by hand, friction that is smooth near rest, SciPy's LSODA.

Nothing here calls mbproj. Coulomb's force -μ(|u|) N u/|u| becomes -μ(|u|) N u/max(|u|, ε): what sticks creeps slower
than ε, and the largest friction is exactly that of the law. Where friction falls from `static` at once, it falls from
ε to 2 ε. It is solved for ε and for ε/10, and the difference of the two is what it is known to. The order in ε is 1, so
that this is nine times its error; where the law has a fall it is 1/2, and twice its error: what slips is late by
√(2 ε/a).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from math import exp, hypot
from typing import Any

import numpy as np
from scipy.integrate import odeint

from mbproj.base.arrays import Array

#: The speeds ε below which friction is smooth, m/s.
WIDTHS = (1e-8, 1e-9)
RELATIVE, ABSOLUTE, MOST_STEPS = 1e-9, 1e-15, 6000


@dataclass(frozen=True)
class Law:
    """Coulomb's law with the coefficients of what slides and sticks, and Stribeck's speed in m/s, 0 for none."""

    slides: float
    static: float
    stribeck: float = 0.0

    def drag(self, width: float, *u: float) -> float:
        """μ(|u|)/max(|u|, ε): the friction over the push and the velocity u, which has one or two components."""
        speed = hypot(*u)
        more = self.static - self.slides
        if self.stribeck:
            more *= exp(-((speed / self.stribeck) ** 2))
        elif more:
            more *= min(max(2.0 - speed / width, 0.0), 1.0)
        return (self.slides + more) / max(speed, width)

    def keys(self) -> Any:
        """As a stop's `friction` has it."""
        if self.static == self.slides:
            return self.slides
        keys = {"coefficient": self.slides, "static": self.static}
        return keys | ({"stribeck_speed": self.stribeck} if self.stribeck else {})


#: rate(t, y, ε) -> y', and at a state what is compared and the smallest push of all contacts.
Rate = Callable[[float, Array, float], list[float]]
Look = Callable[[float, Array, float], tuple[list[float], float]]


#: How often pushes are looked at from one time to the next.
LOOKS = 8


@dataclass(frozen=True)
class Solution:
    """What is compared, (T, k), what each is known to, (k,), and the smallest push at each time in N, (T,)."""

    values: Array
    known: Array
    push: Array


class Unsolved(Exception):
    """The independent solution does not get to the end."""


def solve(rate: Rate, look: Look, start: list[float], times: Array) -> Solution:
    """The motion at these times; valid until a push ends, which may be between two of them."""
    dense = np.interp(np.arange(LOOKS * (len(times) - 1) + 1) / LOOKS, np.arange(len(times)), times)
    (coarse, _), (fine, pushes) = (_motion(rate, look, start, dense, width) for width in WIDTHS)
    coarse, fine = coarse[::LOOKS], fine[::LOOKS]
    push = np.append(pushes[:1], pushes[1:].reshape(-1, LOOKS).min(axis=1))
    ends = np.flatnonzero(push < 0.0)
    until = ends[0] if len(ends) else len(times)
    off = np.abs(coarse[:until] - fine[:until]).max(axis=0) if until else np.zeros(fine.shape[1])
    return Solution(fine, off, push)


def _motion(rate: Rate, look: Look, start: list[float], times: Array, width: float) -> tuple[Array, Array]:
    """What is compared and the smallest push, (T, k) and (T,): NaN and -1 from where a push has ended."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # told by `done`
        y, told = odeint(
            rate, start, times, (width,), rtol=RELATIVE, atol=ABSOLUTE, mxstep=MOST_STEPS, tfirst=True, full_output=True
        )
    done = len(times)
    if told["message"] != "Integration successful.":
        done = int(np.argmax(told["tcur"] < times[1:])) + 1  # the first time that was not reached
    seen = [look(t, state, width) for t, state in zip(times[:done], y, strict=False)]
    values, push = np.array([values for values, _ in seen]), np.array([push for _, push in seen])
    if done < len(times):
        if push[-3:].min() >= 0.0:
            raise Unsolved(told["message"])
        values = np.vstack([values, np.full((len(times) - done, values.shape[1]), np.nan)])
        push = np.append(push, np.full(len(times) - done, -1.0))
    return values, push
