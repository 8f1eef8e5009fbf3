"""Finds whether a run was too stiff for its step. The fastest mode of its forces and states at some samples is compared
with the stability limit of its integrator. Beyond that limit errors grow with a fixed step; error control holds the
step there, where accuracy would allow a longer one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Samples, join
from mbproj.errors import SimulationError
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.reporting.failures import LostStep, TurnsUntold
from mbproj.integrate.reporting.stiff_words import Stiffness, damps, grows, holds, too_stiff
from mbproj.integrate.steppers.implicit_tableau import ImplicitTableau
from mbproj.integrate.steppers.tableau import tableau_of
from mbproj.model.system import System
from mbproj.registry import AUTOMATIC, WHERE_STIFF
from mbproj.scene.records import Settings
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from mbproj.integrate.stiff.modes_at_a_step import FastModes

#: The number of samples of a block that are kept, and of a run.
OF_A_BLOCK, KEPT = 4, 8
#: The number of points of a motion whose smoothness is checked, and the number of samples from which it is.
POINTS, LOOKS = 60, 3

#: Yields samples of a run from a state with settings.
March = Callable[[State, Settings], Iterator[Samples | None]]


@dataclass(frozen=True, eq=False)
class _KeptSample:
    """A sample: its state, its step in s, and the number of steps before it."""

    state: State
    step: float
    steps: int


class StiffnessWatch:
    """Keeps some samples of one run, from which stiffness is diagnosed at its end."""

    def __init__(self, choice: Choice, system: System, settings: Settings, march: March) -> None:
        self._system, self._settings, self._march = system, settings, march
        self._choice = choice
        self._integrator = WHERE_STIFF if settings.integrator == AUTOMATIC else settings.integrator
        self._tableau = tableau_of(self._integrator)
        self._kept: list[_KeptSample] = []

    @cached_property
    def _modes(self) -> FastModes:
        from mbproj.integrate.stiff.modes_at_a_step import FastModes

        return FastModes(self._choice, self._system)

    def take(self, samples: Samples, chosen: Flags | None = None) -> None:
        """Keep some of the samples of a block, or of its `chosen` ones, evenly spread, and the first sample of the
        run."""
        choice = np.arange(len(samples.t)) if chosen is None else np.flatnonzero(chosen)
        for at in choice[_spread(len(choice), OF_A_BLOCK)] if len(choice) else choice:
            state = samples.state(at)
            if np.all(np.isfinite(state.y)):
                step = self._settings.step or float(samples.step_size[at])
                self._kept.append(_KeptSample(state, step, int(samples.counters["steps"][at])))
        while len(self._kept) > KEPT:
            self._kept = self._kept[::2]

    @contextmanager
    def naming(self) -> Iterator[None]:
        """Replace the error of a run with fixed steps in this block where errors have grown because of a stiff force.
        The new error names the force."""
        try:
            yield
        except SimulationError as error:
            stiffness = self._spoilt(error.time, gains=True)
            if stiffness is None and isinstance(error, TurnsUntold | LostStep):
                stiffness = self._led_off(error)
            if stiffness is None:
                raise
            raise too_stiff(error, stiffness) from error

    def _led_off(self, error: TurnsUntold | LostStep) -> Stiffness | None:
        """Return the mode that has led a step astray, or makes turns too fast to count; None without one.

        A mode is the cause of uncertain turns only if it is unstable even with a step short enough to count turns.
        Errors then grow to whole turns in a few steps."""
        if not self._kept or self._settings.step is None:
            return None
        stiffness = self._at(self._kept[-1], gains=True)
        limit = error.step / self._settings.step if isinstance(error, TurnsUntold) else 1.0
        return (
            stiffness
            if stiffness is not None and stiffness.growth > 1.0 and limit * stiffness.omega_h > stiffness.limit
            else None
        )

    def verdict(self, end: float) -> str:
        """Return the note for the user on a run that has ended at that time, or ""."""
        if isinstance(self._tableau, ImplicitTableau):
            damped = self._damped()
            return "" if damped is None else damps(damped)
        if self._settings.step is not None:
            stiffness = self._spoilt(end, gains=False)
            return "" if stiffness is None else grows(stiffness)
        stiffness = self._limiting_mode()
        return "" if stiffness is None else holds(stiffness)

    def _damped(self) -> Stiffness | None:
        """Return the slowest vibration that the implicit steps damp and the mechanism itself hardly damps, at most of
        the samples; None without one."""
        inner = self._kept[1:-1] or self._kept
        damped = [self._against(kept, *mode) for kept in inner if (mode := self._slowest_vibration(kept)) is not None]
        return damped[-1] if damped and len(damped) >= THRESHOLDS.named * len(inner) else None

    def _slowest_vibration(self, kept: _KeptSample) -> tuple[str, complex] | None:
        """Return the slowest vibration that a step of a sample does not resolve; None without one."""
        modes = [
            mode
            for mode in self._modes.at(kept.state, kept.step)
            if kept.step * abs(mode.eigenvalue) > THRESHOLDS.unresolved_vibration
            and abs(mode.eigenvalue.real) < THRESHOLDS.hardly_damped * abs(mode.eigenvalue)
        ]
        if not modes:
            return None
        slowest = min(modes, key=lambda mode: abs(mode.eigenvalue))
        return self._modes.causes(slowest), slowest.eigenvalue

    def _spoilt(self, end: float, *, gains: bool) -> Stiffness | None:
        """Return the mode by which errors have grown beyond bounds, with a fixed step, until some time; None without
        one. The result is the mode when the growth began. Baumgarte's gains count on request, because rows closed to
        the last bit are not affected."""
        if not self._kept or self._settings.step is None:
            return None
        logarithm, first = 0.0, None
        ends = [*(kept.steps for kept in self._kept[1:]), None]
        for kept, until in zip(self._kept, ends, strict=True):
            stiffness = self._at(kept, gains=gains)
            if stiffness is None or not stiffness.growth > 1.0:
                continue
            steps = (end - kept.state.t) / kept.step if until is None else until - kept.steps
            logarithm += np.log(stiffness.growth) * max(steps, 1.0)
            first = first or stiffness
        return first if logarithm > np.log(THRESHOLDS.spoilt) else None

    def _limiting_mode(self) -> Stiffness | None:
        """Return the mode that has limited the step of a run with error control; None without one."""
        inner = [self._at(kept, gains=True) for kept in self._kept[1:-1]]
        near = [
            (kept, stiffness)
            for kept, stiffness in zip(self._kept[1:-1], inner, strict=True)
            if stiffness is not None and stiffness.omega_h >= THRESHOLDS.near_limit * stiffness.limit
        ]
        if not near or len(near) < THRESHOLDS.named * len(inner):
            return None
        tried = [near[at] for at in _spread(len(near), LOOKS)]
        return tried[-1][1] if all(self._is_smooth(kept) for kept, _ in tried) else None

    def _is_smooth(self, kept: _KeptSample) -> bool:
        """Return whether the motion of the next `smooth_span` steps is a polynomial of the degree that one step
        resolves.

        A mode at the limit of stability may stay as large as error control allows. Accuracy alone would let the step
        grow."""
        tolerance, order = self._settings.tolerance, self._tableau.error_order
        assert tolerance is not None
        span = THRESHOLDS.smooth_span * kept.step
        settings = replace(self._settings, duration=span, output_step=span / POINTS)
        try:
            samples = join([part for part in self._march(kept.state, settings) if part is not None])
        except SimulationError:
            return False
        layout = samples.layout
        y, scale = (part[..., np.isfinite(layout.scale)] for part in (samples.y, layout.scale))
        basis = np.polynomial.chebyshev.chebvander(np.linspace(-1.0, 1.0, len(y)), order)
        left = y - basis @ np.linalg.lstsq(basis, y, rcond=None)[0]
        scale = scale + np.abs(y).max(axis=0)
        return _mean(np.abs(left).max(axis=0) / scale) <= THRESHOLDS.below_tolerances * tolerance

    def _at(self, kept: _KeptSample, *, gains: bool) -> Stiffness | None:
        """Return the fastest mode at a sample, compared with the integrator's stability."""
        candidates = [self._modes.fastest(kept.state, kept.step), self._of_gains() if gains else None]
        fastest = sorted((each for each in candidates if each is not None), key=lambda each: -abs(each[1]))
        return self._against(kept, *fastest[0]) if fastest else None

    def _against(self, kept: _KeptSample, where: str, eigenvalue: complex) -> Stiffness:
        from mbproj.integrate.stiff.modes_at_a_step import against

        return against(self._integrator, kept.step, where, eigenvalue)

    def _of_gains(self) -> tuple[str, complex] | None:
        """Return the faster root of λ² + 2αλ + β² = 0 of Baumgarte's terms (ref. 9)."""
        gains = self._settings.projection.gains
        if gains is None:
            return None
        alpha, beta = gains
        return f"Baumgarte's gains of {alpha:g} and {beta:g} 1/s", -alpha - np.sqrt(complex(alpha**2 - beta**2))


def _spread(count: int, most: int) -> list[int]:
    """Return at most `most` numbers from 0 to count - 1, evenly spread."""
    return sorted(set(np.linspace(0, count - 1, min(count, most)).astype(int).tolist()))


def _mean(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values * values)))
