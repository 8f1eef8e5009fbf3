"""The kernel's laws of contacts at an instant, of rows A in coordinates in which the kinetic energy is ½|x|²."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mbproj.base.registry import IMPACT_LAWS
from mbproj.base.thresholds import THRESHOLDS, of_the_kernel
from mbproj.kernel import core


def _thresholds():
    return core().Thresholds(**of_the_kernel())


class Cone(NamedTuple):
    """The forces that one contact may have: its row `push`, -1 for the friction of a joint, its `tangents`, the `most`
    with which it sticks, and the parts of the push with which it `slides`."""

    push: int
    tangents: tuple[int, ...] = ()
    most: float = 0.0
    slides: tuple[float, ...] = ()


def contact_problem(B, b, cones):
    """The forces y along all rows with which no row that is held accelerates; None where none are within the cones."""
    return core().contact_problem(thresholds=_thresholds(), B=B, b=b, cones=list(cones))


def coulomb_problem(B, b, cones):
    """The forces y along all rows by Coulomb's law: stops may open, frictions may slip. None where none are found."""
    return core().coulomb_problem(thresholds=_thresholds(), B=B, b=b, cones=list(cones))


def one_sided(N, b):
    """Pushes z >= 0 with N Nᵀz + b >= 0; None where there are none."""
    return core().one_sided(thresholds=_thresholds(), B=N @ N.T, b=b)


@dataclass
class Balanced:
    """The forces, and which frictions are stuck."""

    y: np.ndarray
    stuck: np.ndarray
    direction: np.ndarray
    part: np.ndarray


@dataclass
class FrictionBalance:
    """S stops that touch and K frictions, as in kernel/src/contact/friction_balance.hpp: their rows A (S+K, f)."""

    A: np.ndarray
    b: np.ndarray
    static: np.ndarray
    sliding: np.ndarray
    direction: np.ndarray
    partner: np.ndarray
    stop: np.ndarray
    loads: Callable
    still: float = 0.0

    def _kernel(self):
        size = np.linalg.norm(self.A, axis=1)
        return core().FrictionBalance(
            thresholds=_thresholds(),
            B=self.A @ self.A.T,
            b=self.b,
            static=self.static,
            sliding=self.sliding,
            direction=self.direction,
            still=np.full(len(self.static), self.still),
            stop=self.stop,
            partner=self.partner,
            able=size > THRESHOLDS.no_push * size.max(),
            loads=self.loads,
        )

    def accelerations(self, y):
        """Those along all rows under the forces y."""
        return self.b + self.A @ (self.A.T @ y)

    def balanced(self):
        """The balance in which as many frictions stick as can; None where there is none."""
        y, direction, *more = self._kernel().decide()
        return None if y is None else Balanced(y, np.array(more[0]), direction, more[1])

    def forces(self):
        """The forces that hold all frictions at rest, or are at most their static forces; None where there are none."""
        return self._kernel().forces()


@dataclass
class Struck:
    """What an impact does: the speeds x' after it, the impulses (k + K,), the energy that each takes and what is lost,
    J."""

    v: np.ndarray
    impulse: np.ndarray
    taken: np.ndarray
    lost: float


def strike(law, A, speeds, restitution, coefficient=(), rubbing=(), off=0.0):
    """The impact of stops, of which the first rows of A are, then their tangents; None where the law has no answer.
    `rubbing`: of each tangent its partner, or -1, and its stop; `off`: the error of the rows' rates."""
    A, speeds = np.asarray(A), np.asarray(speeds)
    found = core().strike(
        thresholds=_thresholds(),
        law=IMPACT_LAWS.index(law),
        B=A @ A.T,
        b=A @ speeds + off,
        restitution=np.asarray(restitution),
        coefficient=np.asarray(coefficient),
        partner=[partner for partner, _ in rubbing],
        by=[by for _, by in rubbing],
    )
    if found is None:
        return None
    v = speeds + A.T @ found[0]
    return Struck(v, found[0], found[2], 0.5 * float(speeds @ speeds - v @ v))
