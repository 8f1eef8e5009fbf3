"""Families of settings: an integrator with fixed steps or error control, whose fineness is one whole number."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import log10

from mbproj.dataclass import dataclass
from mbproj.integrate.steppers.methods import tableau_of
from mbproj.registry import (
    AUTOMATIC,
    PROJECTIONS,
    explicit_integrators,
    implicit_integrators,
    integrators,
    with_fixed_steps,
)
from mbproj.studies.measure.setting import Setting

#: Exponents of the loosest and the tightest tolerance, and the number of tolerances a decade. Each has two digits.
LOOSEST, TIGHTEST, PER_DECADE = -1, -14, 16


@dataclass(frozen=True)
class Family:
    """Settings that add to `base` an integrator and a fineness from 1 on. With fixed steps the fineness is the number
    of steps in an output step of `interval` s. With error control it selects a tolerance of two digits."""

    base: Setting
    integrator: str
    by_error: bool
    interval: float

    @property
    def finest(self) -> int | None:
        """The largest fineness; None where there is no bound."""
        return PER_DECADE * (LOOSEST - TIGHTEST) + 1 if self.by_error else None

    @property
    def order(self) -> int:
        """The order of the integrator; where a run chooses its integrator itself, the order of the explicit one."""
        return integrators()[with_fixed_steps(self.integrator)].order

    def setting(self, fineness: int) -> Setting:
        """The setting with this fineness."""
        if not self.by_error:
            return replace(self.base, integrator=self.integrator, step=self.interval / fineness, tolerance=None)
        return replace(self.base, integrator=self.integrator, step=None, tolerance=self.tolerance(fineness))

    def tolerance(self, fineness: int) -> float:
        """The tolerance that belongs to a fineness, with error control."""
        return float(f"{10.0 ** (LOOSEST - (fineness - 1) / PER_DECADE):.1e}")

    def at_cost(self, fineness: int, factor: float) -> int:
        """The fineness whose cost is about `factor` times that of the fineness given."""
        return round(fineness + PER_DECADE * self.order * log10(factor) if self.by_error else fineness * factor)

    def at_error(self, fineness: int, factor: float) -> int:
        """The fineness whose error is about `factor` times that of the fineness given."""
        if self.by_error:
            return round(fineness - PER_DECADE * log10(factor))
        return round(fineness * factor ** (-1.0 / self.order))

    def fixed_cost(self, fineness: int, intervals: int) -> int:
        """The number of evaluations of a run with fixed steps over `intervals` output steps."""
        return tableau_of(self.integrator).stages * fineness * intervals + 1

    @property
    def name(self) -> str:
        """The integrator and how its step is chosen, in words."""
        return f"{self.integrator}, {'error control' if self.by_error else 'fixed steps'}"


def families(base: Setting, interval: float, *, stiff: bool = False) -> Iterator[Family]:
    """The families of all explicit integrators, first those whose cost grows least with accuracy. Where forces may be
    `stiff`, the families of the implicit ones and of `auto` follow. `base` tells how constraints are enforced."""
    names = explicit_integrators()[::-1]
    yield from (Family(base, name, True, interval) for name in names if integrators()[name].embedded)
    yield from (Family(base, name, False, interval) for name in names)
    if stiff:
        yield from (Family(base, name, True, interval) for name in (*implicit_integrators(), AUTOMATIC))


def with_closed_joints(setting: Setting) -> Setting:
    """Return a setting that closes every joint after every step in the kernel, in the fastest formulation. It is
    `setting`, where its projection does so, or otherwise the default with GPOPM."""
    entry = PROJECTIONS[setting.projection]
    always = setting.every == 1 and setting.threshold is None and setting.project_position and setting.project_velocity
    if entry.corrects and entry.compiled and always:
        return replace(setting, formulation="auto", acceleration="bordered")
    return Setting()
