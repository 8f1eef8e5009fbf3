"""Finds whether a run was too stiff for its step. The fastest mode of its forces and states at some samples is compared
with the stability limit of its integrator. Beyond that limit errors grow with a fixed step; error control holds the
step there, where accuracy would allow a longer one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mbproj.base.arrays import Array, Flags, Integers, may_overflow
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError, shortened
from mbproj.base.registry import AUTOMATIC, WHERE_SMOOTH, WHERE_STIFF, explicit_integrators, is_explicit
from mbproj.base.settings import Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.derivatives import state_slopes
from mbproj.equations.fast_modes import Mode, fast_modes, leading, moved_bodies, slopes, speeds_of_free_bodies
from mbproj.equations.kinematics import pose_of
from mbproj.equations.samples import Samples, join
from mbproj.model.system import System
from mbproj.motion.failures import UNSOLVED, LostStep, Stiffness, TurnsUntold, damps, grows, holds, too_stiff
from mbproj.motion.formulations.choice import Choice, choose
from mbproj.motion.formulations.full import FullFormulation
from mbproj.motion.numpy_loop import attempted, error_norm, first_point
from mbproj.motion.report import Tally
from mbproj.motion.steppers.runge_kutta import ExplicitRungeKutta, amplification, reach
from mbproj.motion.steppers.tableau import ImplicitTableau, load_tableau, tableau_of

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
        self._samples: list[_KeptSample] = []

    @cached_property
    def _modes(self) -> FastModes:

        return FastModes(self._choice, self._system)

    def take(self, samples: Samples, chosen: Flags | None = None) -> None:
        """Keep some of the samples of a block, or of its `chosen` ones, evenly spread, and the first sample of the
        run."""
        choice = np.arange(len(samples.t)) if chosen is None else np.flatnonzero(chosen)
        for at in choice[_spread(len(choice), OF_A_BLOCK)] if len(choice) else choice:
            state = samples.state(at)
            if np.all(np.isfinite(state.y)):
                step = self._settings.step or float(samples.step_size[at])
                self._samples.append(_KeptSample(state, step, int(samples.counters["steps"][at])))
        while len(self._samples) > KEPT:
            self._samples = self._samples[::2]

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
        if not self._samples or self._settings.step is None:
            return None
        stiffness = self._at(self._samples[-1], gains=True)
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
        inner = self._samples[1:-1] or self._samples
        damped = [
            self._against(sample, *mode) for sample in inner if (mode := self._slowest_vibration(sample)) is not None
        ]
        return damped[-1] if damped and len(damped) >= THRESHOLDS.named * len(inner) else None

    def _slowest_vibration(self, sample: _KeptSample) -> tuple[str, complex] | None:
        """Return the slowest vibration that a step of a sample does not resolve; None without one."""
        modes = [
            mode
            for mode in self._modes.at(sample.state, sample.step)
            if sample.step * abs(mode.eigenvalue) > THRESHOLDS.unresolved_vibration
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
        if not self._samples or self._settings.step is None:
            return None
        logarithm, first = 0.0, None
        ends = [*(sample.steps for sample in self._samples[1:]), None]
        for sample, until in zip(self._samples, ends, strict=True):
            stiffness = self._at(sample, gains=gains)
            if stiffness is None or not stiffness.growth > 1.0:
                continue
            steps = (end - sample.state.t) / sample.step if until is None else until - sample.steps
            logarithm += np.log(stiffness.growth) * max(steps, 1.0)
            first = first or stiffness
        return first if logarithm > np.log(THRESHOLDS.spoilt) else None

    def _limiting_mode(self) -> Stiffness | None:
        """Return the mode that has limited the step of a run with error control; None without one."""
        inner = [self._at(sample, gains=True) for sample in self._samples[1:-1]]
        near = [
            (sample, stiffness)
            for sample, stiffness in zip(self._samples[1:-1], inner, strict=True)
            if stiffness is not None and stiffness.omega_h >= THRESHOLDS.near_limit * stiffness.limit
        ]
        if not near or len(near) < THRESHOLDS.named * len(inner):
            return None
        tried = [near[at] for at in _spread(len(near), LOOKS)]
        return tried[-1][1] if all(self._is_smooth(sample) for sample, _ in tried) else None

    def _is_smooth(self, sample: _KeptSample) -> bool:
        """Return whether the motion of the next `smooth_span` steps is a polynomial of the degree that one step
        resolves.

        A mode at the limit of stability may stay as large as error control allows. Accuracy alone would let the step
        grow."""
        tolerance, order = self._settings.tolerance, self._tableau.error_order
        assert tolerance is not None
        span = THRESHOLDS.smooth_span * sample.step
        settings = replace(self._settings, duration=span, output_step=span / POINTS)
        try:
            samples = join([part for part in self._march(sample.state, settings) if part is not None])
        except SimulationError:
            return False
        layout = samples.layout
        y, scale = (part[..., np.isfinite(layout.scale)] for part in (samples.y, layout.scale))
        basis = np.polynomial.chebyshev.chebvander(np.linspace(-1.0, 1.0, len(y)), order)
        left = y - basis @ np.linalg.lstsq(basis, y, rcond=None)[0]
        scale = scale + np.abs(y).max(axis=0)
        return _mean(np.abs(left).max(axis=0) / scale) <= THRESHOLDS.below_tolerances * tolerance

    def _at(self, sample: _KeptSample, *, gains: bool) -> Stiffness | None:
        """Return the fastest mode at a sample, compared with the integrator's stability."""
        candidates = [self._modes.fastest(sample.state, sample.step), self._of_gains() if gains else None]
        fastest = sorted((each for each in candidates if each is not None), key=lambda each: -abs(each[1]))
        return self._against(sample, *fastest[0]) if fastest else None

    def _against(self, sample: _KeptSample, where: str, eigenvalue: complex) -> Stiffness:

        return against(self._integrator, sample.step, where, eigenvalue)

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


# --- Modes at a state of a run ----------------------------------------------------------------------------------------
# The modes of a mechanism's forces and its elements' states at a state of its run, compared with the step.


#: The most coordinates of forces that are considered: those that would be fastest on free bodies.
LAWS = 100
#: The most forces or states that a message names.
MOST_NAMED = 3


def modes_at(choice: Choice, system: System, state: State, step: float = np.inf) -> tuple[Integers, list[Mode]]:
    """Return the coordinates of forces that are considered, (e,), and the modes at a state, the fastest first. There
    are no modes where all are slow compared with the step."""
    with may_overflow():  # the state may be the last one of a run that is lost
        slope, of_states = slopes(system, state), _state_slopes(system, state)
    bound = speeds_of_free_bodies(system, pose_of(state.q), slope)
    fastest = max(bound.max(initial=0.0), np.abs(np.linalg.eigvals(of_states)).max(initial=0.0))
    laws = np.sort(np.argsort(-bound)[:LAWS])
    laws = laws[bound[laws] > 0.0]
    if fastest == 0.0 or step * fastest < THRESHOLDS.stiff_for_step:
        return laws, []
    W = choice.responses(system, state, laws) if len(laws) else np.zeros((0, 0))
    if W is None:
        laws, W = laws[:0], np.zeros((0, 0))
    return laws, fast_modes(W, laws, slope, of_states)


def _state_slopes(system: System, state: State) -> Array:
    return state_slopes(state.instant(system))


def can_be_fast(system: System) -> bool:
    """Return whether there are forces along coordinates, or states of elements."""
    return system.states.size > 0 or system.forces.size > 0


@dataclass(frozen=True, eq=False)
class Owners:
    """The causes of a mode, the one with the largest part first: `forces`, or `states` of elements."""

    forces: tuple[str, ...] = ()
    states: tuple[str, ...] = ()

    @classmethod
    def of(cls, system: System, mode: Mode) -> Owners:
        """Return the causes of a mode of a system."""
        count = len(system.names.states)
        along = len(mode.shares) - count
        if mode.shares[along:].any():
            return cls(states=leading(system.names.states, mode.shares[along:]))
        return cls(forces=leading(system.forces.owners, mode.shares[:along]))

    @property
    def words(self) -> str:
        """The causes in words: "forces 'a', 'b'"."""
        kind, names = ("state", self.states) if self.states else ("force", self.forces)
        return f"{kind}{'s' * (len(names) > 1)} " + shortened([f"'{name}'" for name in names], MOST_NAMED)


@dataclass(frozen=True, eq=False)
class FastModes:
    """The fast modes of the forces and states of a system, in the chosen formulation."""

    choice: Choice
    system: System

    def at(self, state: State, step: float) -> list[Mode]:
        """Return the modes at a state, the fastest first; none where all are slow compared with the step."""
        return modes_at(self.choice, self.system, state, step)[1]

    def fastest(self, state: State, step: float) -> tuple[str, complex] | None:
        """Return the cause of the fastest mode, and its eigenvalue; None where all are slow compared with the step."""
        mode = next(iter(self.at(state, step)), None)
        return None if mode is None else (self.causes(mode), mode.eigenvalue)

    def causes(self, mode: Mode) -> str:
        """Return the causes of a mode in words, the one with the largest part first."""
        return Owners.of(self.system, mode).words


def against(integrator: str, step: float, where: str, eigenvalue: complex) -> Stiffness:
    """Return a mode's |hλ| and growth in a step of an integrator, with the integrator's limit of stability."""
    size, tableau = abs(eigenvalue), tableau_of(integrator)
    direction = complex(round(min(eigenvalue.real, 0.0) / size, 3), round(abs(eigenvalue.imag) / size, 3))
    z = step * eigenvalue
    return Stiffness(
        where=where,
        omega_h=step * size,
        limit=reach(tableau, direction),
        growth=amplification(tableau, z) / np.exp(max(z.real, 0.0)),
        step=step,
        direction=direction,
        integrator=integrator,
    )


# --- The fastest modes of a mechanism's forces and states at its start ------------------------------------------------
# Their causes, the bodies that they move, and the step that explicit integrators need for them.


#: The number of modes that are reported.
TOLD = 3


@dataclass(frozen=True)
class FastMode:
    """An eigenvalue λ in 1/s, the forces or states with most of its energy, and the bodies that move most; the largest
    part comes first."""

    eigenvalue: complex
    forces: tuple[str, ...]
    states: tuple[str, ...]
    bodies: tuple[str, ...]

    @property
    def time_constant(self) -> float:
        """1 / |λ| in s."""
        return 1.0 / abs(self.eigenvalue)

    @property
    def direction(self) -> complex:
        """λ / |λ|, without slight growth."""
        size = abs(self.eigenvalue)
        return complex(round(min(self.eigenvalue.real, 0.0) / size, 3), round(abs(self.eigenvalue.imag) / size, 3))


def fastest_at(choice: Choice, system: System, state: State) -> list[FastMode]:
    """Return the fastest modes at a state, the fastest first; none without forces along coordinates or states."""
    chosen, modes = modes_at(choice, system, state)
    fastest = modes[:TOLD]
    real = [mode for mode in fastest if abs(mode.eigenvalue) > THRESHOLDS.no_motion * abs(fastest[0].eigenvalue)]
    return [_described(system, state, chosen, mode) for mode in real]


def stable_steps(modes: Sequence[FastMode]) -> dict[str, float]:
    """Return the largest step in s, by name, with which each explicit integrator is stable for all these modes."""
    if not modes:
        return {}
    return {
        name: min(reach(tableau_of(name), mode.direction) * mode.time_constant for mode in modes)
        for name in explicit_integrators()
    }


def steps_for_stability(system: System, state: State, settings: Settings) -> float:
    """Return the least number of steps that DOP853 makes for stability alone in a run with these settings. It assumes
    the forces at the start; 0 without forces along coordinates and states."""
    if not can_be_fast(system):
        return 0.0
    stable = stable_steps(fastest_at(choose(system, state, settings), system, state))
    return (settings.duration or 0.0) / stable[WHERE_SMOOTH] if stable else 0.0


def _described(system: System, state: State, chosen: Integers, mode: Mode) -> FastMode:
    motion: Array | None = None
    if system.bodies <= THRESHOLDS.large and mode.moves_bodies:
        motion = moved_bodies(system, pose_of(state.q), chosen, mode)
    bodies = () if motion is None else leading(system.names.carriers, motion)
    owners = Owners.of(system, mode)
    return FastMode(mode.eigenvalue, owners.forces, owners.states, bodies)


# --- The limits of a step in a run with error control -----------------------------------------------------------------
# The error of the step by bodies and states, or the force or state that limits it for stability alone.


@dataclass(frozen=True)
class StepLimit:
    """A step of size `step` (s) from `time` on (s), and its error in tolerances, NaN where it cannot be made. `shares`:
    the part of each body and state in the square of the error, the largest first. `reason`: the limit other than
    accuracy, "" for none."""

    time: float
    step: float
    error: float
    shares: tuple[tuple[str, float], ...]
    reason: str


def step_limit(system: System, state: State, settings: Settings, step: float) -> StepLimit:
    """Return the limits of a step of this size from a state, by the integrator and the tolerance of `settings`. The
    full formulation is used for all runs."""
    full = replace(settings, formulation="full", duration=step, output_step=step)
    choice = choose(system, state, full)
    held = _stiff_cause(FastModes(choice, system), state, settings.integrator, step)
    try:
        with may_overflow():
            tried = (_explicit if is_explicit(settings.integrator) else _implicit)(choice, system, state, full)
    except SimulationError as error:
        return StepLimit(state.t, step, np.nan, (), ": ".join(filter(None, [error.where, error.cause])))
    square = np.concatenate([tried.of_bodies, tried.of_states]) ** 2
    part = square / max(float(square.sum()), np.finfo(float).tiny)
    order = np.argsort(-part, kind="stable")
    names = (*system.names.carriers, *(f"state {name}" for name in system.names.states))
    shares = tuple((names[each], float(part[each])) for each in order)
    return StepLimit(state.t, step, tried.norm, shares, held)


class _TriedStep(NamedTuple):
    """The `norm` of the error of a step, in tolerances; and the sizes of its parts, of bodies (n,) and states (K,)."""

    norm: float
    of_bodies: Array
    of_states: Array


def _explicit(choice: Choice, system: System, state: State, settings: Settings) -> _TriedStep:
    """Return the error of an explicit step. Raises SimulationError where it cannot be made."""
    formulation = FullFormulation.of(system, state, settings, choice.redundant)
    stepper, step = ExplicitRungeKutta(load_tableau(settings.integrator)), settings.duration or 0.0
    point = first_point(formulation, state, Tally())
    tried = attempted(stepper, formulation.derivative, point, step)
    tried, estimates = stepper.error(formulation.derivative, state.t + step, tried)
    layout, tolerance = formulation.layout, settings.tolerance or 0.0
    part = estimates[0] / (layout.scale + np.maximum(np.abs(tried.y), np.abs(tried.y_new)))
    of_bodies = np.array(formulation.split(part)[:2]).reshape(2, -1, 7)
    norm = error_norm(estimates, tried.y, tried.y_new, tolerance, layout.scale)
    return _TriedStep(norm, np.linalg.norm(of_bodies, axis=(0, 2)), part[layout["states"]])


def _implicit(choice: Choice, system: System, state: State, settings: Settings) -> _TriedStep:
    """Return the error of an implicit step, which the kernel makes. Raises SimulationError where it cannot be made."""
    compiled, step = choice.compiled, settings.duration or 0.0
    assert compiled is not None
    run = compiled.run(state, settings)
    tried = run.try_step(step)
    if tried is None:
        raise compiled.failure(run, settings) or SimulationError(state.t, UNSOLVED)
    (y_new, error), layout, tolerance = tried, compiled.layout, settings.tolerance or 0.0
    y, controlled = compiled.beginning(state), layout.controlled
    part = error / (layout.scale + np.maximum(np.abs(y), np.abs(y_new)))
    norm = error_norm(error[None, controlled], y[controlled], y_new[controlled], tolerance, layout.scale[controlled])
    return _TriedStep(norm, np.linalg.norm(compiled.bodies_of(part), axis=-1), part[layout["states"]])


def _stiff_cause(modes: FastModes, state: State, integrator: str, step: float) -> str:
    """Return the force or state that holds an explicit step at its limit of stability; "" for none."""
    fastest = modes.fastest(state, step) if is_explicit(integrator) else None
    if fastest is None:
        return ""
    stiffness = against(integrator, step, *fastest)
    return (
        f"{stiffness.where}: {stiffness.what}" if stiffness.omega_h >= THRESHOLDS.near_limit * stiffness.limit else ""
    )
