"""stability(): a map of where each method holds, degrades and fails while one quantity varies. Bisection finds the
limits.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import ceil, exp, log
from types import MappingProxyType
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, MbprojError, Problem, SimulationError, choose_from
from mbproj.base.registry import PROJECTIONS, WHERE_STIFF, integrators, with_fixed_steps
from mbproj.base.settings import SETTINGS, Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.constraints import constraint_at
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.instants import round_of
from mbproj.linear.modes import modes
from mbproj.linear.reference import reference_at
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.model.system import System
from mbproj.motion.formulations.choice import choose
from mbproj.motion.formulations.reduced import InPlane
from mbproj.motion.report import Report
from mbproj.motion.simulate import simulate
from mbproj.motion.steppers.runge_kutta import real_axis_limit
from mbproj.motion.steppers.tableau import tableau_of
from mbproj.results.views import Table, Tabled
from mbproj.scene.scene import Scene, SceneText
from mbproj.studies.case_arrays import OneCaseOnly, case_of
from mbproj.studies.case_blocks import CaseBlock, as_one, by_arrays
from mbproj.studies.measure.reference import span as until_of
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import DatasetRecorder, Mechanism, of_scene, sample_times, solve
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.study import Study
from mbproj.studies.variants import (
    rescaled,
    with_damping,
    with_inertia_ratio,
    with_mass_ratio,
    with_speed,
    with_stiffness,
)

# --- The subject of a stability map, a scene with a setting, and the verdict on it ------------------------------------
# Whether it holds, degrades or fails, from which time on, and at which joint. A run is judged, or the small motions
# about the equilibrium are: by the modes, or from one round of a sampled controller's instants to the next.


#: The three states of a point, from best to worst.
HOLDS, DEGRADES, FAILS = "holds", "degrades", "fails"
#: The most samples of a run. Between samples nothing is checked.
SAMPLES = 400
#: Energies below this part of the work of gravity over the mechanism's length count as zero.
STILL = 1e-9
#: The most values that are judged in one block.
BLOCK = 50
#: The name of the track, and the relative precision of its limits: each point costs little.
NAME, VERDICT_PRECISION = "small motions", 1e-8
#: Motions that grow by a smaller part in a round count as neutral: rounding splits a double eigenvalue 1 by √ε.
GROWS = 2e-8


@dataclass(frozen=True)
class Limits:
    """The limits of the three states. A run holds while joints are open by at most `closed` (the mechanism's lengths,
    rad), and the energy balance is off by at most `energy`. The latter is relative to the largest kinetic energy, |ΔV|
    and work. A run fails where it stops, or exceeds `open` or `lost`; in between it degrades."""

    closed: float = 1e-6
    energy: float = 1e-2
    open: float = 1e-2
    lost: float = 0.1


@dataclass(frozen=True)
class Subject:
    """A scene that is run with a setting until a time (s). With `is_linear` it is not run: its small motions are
    judged."""

    scene: Scene
    setting: Setting
    until: float
    limits: Limits
    is_linear: bool = False

    @property
    def step(self) -> float:
        """The fixed step, s."""
        assert self.setting.step is not None
        return self.setting.step


@dataclass(frozen=True)
class StabilityPoint:
    """The result of a run at one value of the quantity. `closure` is the largest opening of a joint (the mechanism's
    lengths, rad), `energy` the largest relative error of the balance; NaN where not computed. `time` (s), `joint` and
    `cause` tell when, where and why the run first exceeded a limit; None and "" where it holds. `ended` is False for a
    run that stopped early."""

    value: float
    state: str
    closure: float
    energy: float
    time: float | None = None
    joint: str | None = None
    cause: str = ""
    ended: bool = True


def cause_of(error: MbprojError) -> str:
    """The message of an error that ended a run, without its place and time."""
    if isinstance(error, InputError):
        return error.problems[0].message
    return error.cause if isinstance(error, SimulationError) else str(error)


def judged(subject: Subject, value: float) -> StabilityPoint:
    """Run the subject and judge it. An error of the run becomes the cause of a failed point. Raises InputError where
    there is nothing to run."""
    mechanism = Mechanism.of(subject.scene)
    watch, report, stopped = _Watch(mechanism.system), None, None
    try:
        with np.errstate(all="ignore"):  # a run that overflows reports its failure itself
            report = simulate(mechanism.system, mechanism.state, settings_of(subject), watch)
    except MbprojError as error:
        stopped = error
    point = watch.point(value, subject.limits, stopped)
    return point if report is None else _with_energy_row(point, report, subject)


def judged_in_blocks(changed: Callable[[float], Subject], values: Sequence[float]) -> dict[int, StabilityPoint]:
    """The points of the values that arrays can judge, with the bits of single runs, by the values' numbers. `changed`
    returns the subject at a value; only numbers of its scene may differ."""

    def run(group: Sequence[float]) -> list[StabilityPoint | None]:
        subjects = [changed(value) for value in group]
        first = subjects[0]
        if first.setting.energy_row or any(replace(each, scene=first.scene) != first for each in subjects):
            raise OneCaseOnly("settings of several cases differ")
        # a run does not depend on the texts of changes
        scenes = [replace(each.scene, overrides=first.scene.overrides) for each in subjects]
        cases = CaseBlock.of(as_one(scenes), settings_of(first), len(group))
        blocks, ended = cases.observed()
        watch = _Watch(cases.mechanism.system)
        for block in blocks:
            watch.write(block)
        return [
            watch.of_case(at).point(value, first.limits, None) if ended[at] else None for at, value in enumerate(group)
        ]

    return by_arrays(
        values,
        run,
        lambda value, point: repr(judged(changed(value), value)) == repr(point),
        lambda value: values.index(value) // BLOCK,
    )


def _with_energy_row(point: StabilityPoint, report: Report, subject: Subject) -> StabilityPoint:
    """Return the point with the energy that the projection's energy row gave or took as an error of the balance."""
    limits, share = subject.limits, report.rows.furthest / max(report.exchanged, np.finfo(float).tiny)
    if point.state == FAILS or not share > max(limits.energy, point.energy):
        return replace(point, energy=max(point.energy, share)) if share > 0.0 else point
    state = FAILS if share > limits.lost else DEGRADES
    said = point.cause or f"the energy row gave or took {share:.1e} of it"
    return replace(point, state=state, energy=share, time=point.time or subject.until, cause=said)


def settings_of(subject: Subject) -> Settings:
    """The settings of the run, with a sample every few steps. Raises InputError where they do not fit each other."""
    step = subject.setting.step
    if step is None:
        return of_scene(subject.scene, subject.setting.settings(subject.until, subject.until / SAMPLES))
    steps = max(1, ceil(subject.until / step / SAMPLES))
    return replace(of_scene(subject.scene, subject.setting.settings(subject.until, step)), output_step=steps * step)


ENERGIES = tuple(f"diagnostics/{name}" for name in ("energy_balance", "kinetic_energy", "potential_energy", "work"))


class _Watch(DatasetRecorder):
    """A recorder of how far each joint is open, and of the energies."""

    def __init__(self, system: System) -> None:
        super().__init__(("time", "joints/violation_length", "joints/violation_angle", *ENERGIES))
        self._length, self._joints = system.length, system.names.joints
        self._weight = system.mass.sum() * np.linalg.norm(system.gravity) * system.length

    def of_case(self, at: int) -> _Watch:
        """The recorded data of one case of a block."""
        watch = copy(self)
        vars(watch).update({name: case_of(value, at) for name, value in vars(self).items()})  # also the dict of parts
        return watch

    def point(self, value: float, limits: Limits, stopped: MbprojError | None) -> StabilityPoint:
        """Judge what was recorded. `stopped` is the error that ended the run, if any."""
        where = stopped.where if isinstance(stopped, SimulationError) else None
        end = stopped.time if isinstance(stopped, SimulationError) else 0.0
        cause = "" if stopped is None else f"stops at {end:.3g} s: {cause_of(stopped)}"
        if self.is_empty:
            return StabilityPoint(value, FAILS, np.nan, np.nan, end, where, cause, ended=False)
        times, off = self["time"], self._balance_error()
        opened = np.maximum(self["joints/violation_length"] / self._length, self["joints/violation_angle"])
        widest = opened.max(axis=1, initial=0.0)
        good = np.isfinite(widest) & np.isfinite(off)
        bad = np.flatnonzero(~(good & (widest <= limits.closed) & (off <= limits.energy)))
        closure, energy = (float(part[good].max(initial=0.0)) for part in (widest, off))
        lost = bool(np.any(~good) or closure > limits.open or energy > limits.lost)
        state = FAILS if stopped is not None or lost else DEGRADES if len(bad) else HOLDS
        if not len(bad):
            return StabilityPoint(
                value, state, closure, energy, end if stopped else None, where, cause, stopped is None
            )
        first = int(bad[0])
        joint = None
        if widest[first] > limits.closed:
            joint = f"joint '{self._joints[int(np.argmax(opened[first]))]}'"
        what = f"{joint} is open by {widest[first]:.1e}" if joint else f"the energy is off by {off[first]:.1e}"
        said = what if state == DEGRADES or not cause else cause
        return StabilityPoint(value, state, closure, energy, float(times[first]), joint or where, said, stopped is None)

    def _balance_error(self) -> Array:
        """The error of the energy balance of each sample, (T,), relative to the largest kinetic energy, |ΔV| and work
        so far. Early samples, before much has moved, are relative to the median of these sizes."""
        balance, kinetic, potential, work = map(self.__getitem__, ENERGIES)
        size = np.maximum.accumulate(kinetic) + np.maximum.accumulate(np.abs(work))
        size = size + np.maximum.accumulate(potential) - np.minimum.accumulate(potential)
        finite = size[np.isfinite(size)]
        least = max(STILL * float(self._weight), float(np.median(finite)) if len(finite) else 0.0, np.finfo(float).tiny)
        with np.errstate(invalid="ignore"):  # both overflow where a run is lost
            return np.asarray(np.abs(balance) / np.maximum(size, least))


def small_motions(subject: Subject, value: float) -> StabilityPoint:
    """Test that no small motion grows. An error becomes the cause of a failed point."""
    try:
        fault = _fault(Mechanism.of(subject.scene))
    except MbprojError as error:
        fault = cause_of(error)
    return StabilityPoint(value, FAILS if fault else HOLDS, np.nan, np.nan, None, None, fault, ended=False)


def _fault(mechanism: Mechanism) -> str:
    """A sentence on the fastest growing small motion; "" where none grows."""
    system = mechanism.system
    rest = equilibrium(system, mechanism.state)
    if rest.reference.held:
        raise InputError(Problem(f"dry friction holds it: {', '.join(rest.reference.held)}"))
    if system.actions.size:
        period = round_of(reference_at(system, rest.state, "equilibrium"))
        times = float(np.abs(period.multipliers).max(initial=0.0))
        return (
            f"a small motion grows by {times - 1.0:.3g} of itself in {period.time:.6g} s" if times > 1.0 + GROWS else ""
        )
    values = modes(rest.reference).eigenvalues
    fastest = float(values.real.max(initial=0.0))
    grows = fastest > THRESHOLDS.no_motion * float(np.abs(values).max(initial=0.0))
    return f"a small motion grows with {fastest:.6g} 1/s" if grows else ""


# --- The quantities that can be varied --------------------------------------------------------------------------------
# How a value changes the scene or its setting, their range, and the methods concerned.
# Baumgarte's gains have a limit: those from which an offset of C grows over 300 steps, and the limit from the
# tableau.
# With α = β the violation obeys C'' + 2αC' + α²C = 0, whose double eigenvalue is -α. A Runge-Kutta method has the
# stability function R(z) = 1 + z bᵀ(I - zA)⁻¹1. It keeps the violation bounded while |R(-αh)| <= 1 (Hairer & Wanner
# 1996, sect. IV.2).


#: The number of steps over which |C| is watched, and the initial offset in units of the mechanism's length.
STEPS, OFFSET = 300, 1e-8


def growth(subject: Subject, value: float) -> StabilityPoint:
    """Test whether an offset of C grows with these gains.

    The difference to a run without the offset is watched, because the integrator's error adds to C in both. `closure`
    is this difference after the last step, in lengths or rad."""
    mechanism = Mechanism.of(subject.scene)
    closed, opened = (_violations(subject, each) for each in (mechanism, _shifted(subject, mechanism)))
    first, last = (float(part) for part in np.abs(opened - closed).max(axis=1))
    if last <= first:
        return StabilityPoint(value, HOLDS, last, np.nan)
    said = f"an offset has grown from {first:.1e} to {last:.1e}"
    return StabilityPoint(
        value, FAILS, last, np.nan, STEPS * subject.step, _worst(mechanism.system, opened - closed), said
    )


def _shifted(subject: Subject, mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with its bodies shifted by random offsets. The offsets stay in the plane where the run is
    planar."""
    state, random = mechanism.state, np.random.default_rng(0)
    shift = np.zeros((mechanism.system.bodies, 7))
    shift[:, :3] = OFFSET * mechanism.system.length * random.choice([-1.0, 1.0], (mechanism.system.bodies, 3))
    run = choose(mechanism.system, state, subject.setting.settings(STEPS * subject.step, subject.step)).compiled
    if isinstance(run, InPlane):
        normal = run.plane.axes[:, 2]
        shift[:, :3] -= np.outer(shift[:, :3] @ normal, normal)
    return replace(mechanism, state=state.changed(positions=state.q + shift.ravel()))


def _violations(subject: Subject, mechanism: Mechanism) -> Array:
    """The violation C of joints and motions at the start and after the last step, (2, m), in the mechanism's length or
    rad."""
    span, system = STEPS * subject.step, mechanism.system
    recorder = DatasetRecorder(("time", "bodies/position", "bodies/orientation"))
    with np.errstate(all="ignore"):
        simulate(system, mechanism.state, mechanism.settings(subject.setting, span, span), recorder)
    violation = constraint_at(system, _coordinates(system, recorder), recorder["time"]) / system.row_scale
    return np.asarray(violation[:, system.bodies :])


def _coordinates(system: System, block: DatasetRecorder) -> Array:
    """The coordinates q (T, 7n) of the carriers, each computed from the first body that is fixed to it."""
    first = [int(np.argmax(system.body_carrier == carrier)) for carrier in range(system.bodies)]
    back = system.body_turn[first] * np.array([1.0, -1.0, -1.0, -1.0])
    orientation = product(block["bodies/orientation"][:, first], back)
    arm = (rotation_matrix(orientation) @ system.body_offset[first][..., None])[..., 0]
    q = np.concatenate([block["bodies/position"][:, first] - arm, orientation], axis=-1)
    return np.asarray(q.reshape(len(q), -1))


def _worst(system: System, offset: Array) -> str:
    """The owner of the row that has grown most."""
    return system.row_owner(system.bodies + int(np.argmax(np.abs(offset[-1]))))


@dataclass(frozen=True)
class ValueSpan:
    """The range in which a quantity is varied, and its value in the scene itself."""

    low: float
    own: float
    high: float


@dataclass(frozen=True)
class VariedQuantity:
    """A quantity that can be varied. `option` is the option that a projection method must have for it ("gains",
    "alpha"), or "". `run` judges a subject at a value.

    `of_forces`: the quantity makes forces stiff, so an implicit method is tried too. `of_motion`: the quantity changes
    the mechanism itself, so small motions are judged too."""

    unit: str
    summary: str
    span: Callable[[Subject], ValueSpan]
    changed: Callable[[Subject, float], Subject]
    option: str = ""
    run: Callable[[Subject, float], StabilityPoint] = judged
    of_forces: bool = False
    of_motion: bool = False


def _factor(
    low: float,
    high: float,
    change: Callable[[Scene, float], Scene],
    summary: str,
    *,
    applies_to_all: bool = False,
    of_forces: bool = False,
) -> VariedQuantity:
    """A factor that is 1 in the scene itself. `change` raises InputError for scenes to which it does not apply."""

    def span(subject: Subject) -> ValueSpan:
        if not applies_to_all:
            change(subject.scene, 1.0)
        return ValueSpan(low, 1.0, high)

    def changed(subject: Subject, value: float) -> Subject:
        return replace(subject, scene=change(subject.scene, value))

    return VariedQuantity("", summary, span, changed, of_forces=of_forces)


def _steps(subject: Subject) -> ValueSpan:
    return ValueSpan(subject.step / 8.0, subject.step, min(64.0 * subject.step, subject.until))


def _of_setting(changes: Callable[[float], dict[str, Any]]) -> Callable[[Subject, float], Subject]:
    return lambda subject, value: replace(subject, setting=replace(subject.setting, **changes(value)))


def _gains(subject: Subject) -> ValueSpan:
    if not (subject.scene.joints or subject.scene.motions):
        said = "the scene has no joints for Baumgarte's terms to close"
        raise InputError(Problem(said, hint="vary something else, 'step' for example"))
    gains = subject.setting.gains or SETTINGS["gains"].where_taken
    return ValueSpan(0.05 / subject.step, gains[0], 20.0 / subject.step)


#: Every quantity by name. A new one is an entry here, and the function in `mbproj.studies.variants` that applies it.
QUANTITIES: Mapping[str, VariedQuantity] = MappingProxyType(
    {
        "step": VariedQuantity("s", "the integrator's fixed step", _steps, _of_setting(lambda h: {"step": h})),
        "mass-ratio": _factor(
            1e-12,
            1e12,
            with_mass_ratio,
            "every second body, counted from the ground along the joints, √r times as heavy, the others 1/√r times",
        ),
        "inertia-ratio": _factor(1e-12, 1e12, with_inertia_ratio, "as `mass-ratio`, of the moments of inertia alone"),
        "speed": _factor(1e-3, 1e3, with_speed, "a factor on the velocities of the start and the speed of all motions"),
        "length-scale": _factor(
            1e-6,
            1e6,
            rescaled,
            "a factor on lengths, velocities and gravity: the same motion in another unit of length",
            applies_to_all=True,
        ),
        "stiffness": _factor(1e-6, 1e6, with_stiffness, "a factor on the stiffness of all springs", of_forces=True),
        "damping": _factor(1e-6, 1e6, with_damping, "a factor on the damping of all dampers", of_forces=True),
        "baumgarte-gain": VariedQuantity(
            "1/s",
            "Baumgarte's gains α = β: whether |C| grows over 300 steps from an offset of 1e-8",
            _gains,
            _of_setting(lambda gain: {"gains": (gain, gain)}),
            "gains",
            growth,
        ),
        "penalty": VariedQuantity(
            "",
            "the penalty α of mass-orthogonal and mmopm",
            lambda subject: ValueSpan(1.0, subject.setting.alpha or SETTINGS["alpha"].where_taken, 1e16),
            _of_setting(lambda alpha: {"alpha": alpha}),
            "alpha",
        ),
        "duration": VariedQuantity(
            "s",
            "how long the run is",
            lambda subject: ValueSpan(subject.until / 10.0, subject.until, 100.0 * subject.until),
            lambda subject, until: replace(subject, until=until),
        ),
    }
)


#: The prefix that names a parameter of the scene.
PARAMETER = "parameters."


def _of_parameter(name: str) -> VariedQuantity:
    """A parameter of the scene, varied from a tenth of its value to ten times its value."""

    def span(subject: Subject) -> ValueSpan:
        known = subject.scene.parameters
        if name not in known:
            hint = choose_from(name, known, "parameters are") if known else "name a number: `parameters: {T: 20 ms}`"
            raise InputError(Problem(f"the scene has no parameter '{name}'", hint=hint))
        scene_value = known[name]
        if not scene_value > 0.0:
            said = f"parameter '{name}' is {scene_value:.6g}, and values are varied by their logarithms"
            raise InputError(Problem(said, hint="let a positive parameter be a factor of it"))
        return ValueSpan(0.1 * scene_value, scene_value, 10.0 * scene_value)

    def changed(subject: Subject, value: float) -> Subject:
        return replace(subject, scene=subject.scene.with_({name: value}))

    return VariedQuantity("", f"the scene's parameter {name}", span, changed, of_motion=True)


def quantity_named(name: str) -> VariedQuantity:
    """The quantity with this name in `QUANTITIES`, or the parameter of the scene: `parameters.T`. Raises InputError for
    an unknown name."""
    if name.startswith(PARAMETER):
        return _of_parameter(name.removeprefix(PARAMETER))
    if name not in QUANTITIES:
        raise InputError(
            Problem(f"unknown quantity '{name}'", hint=choose_from(name, [*QUANTITIES, f"{PARAMETER}NAME"]))
        )
    return QUANTITIES[name]


# --- stability() ------------------------------------------------------------------------------------------------------


#: The methods that are tried by default, and the number of grid values.
METHODS, POINTS = ("none", "baumgarte", "gopm", "gpopm"), 25
#: The relative precision of a limit, and the most changes of state that are bisected for a method.
PRECISION, CHANGES = 0.005, 6
#: The number of steps for a scene that gives neither a step nor a tolerance.
DEFAULT_STEPS = 1000


@dataclass(frozen=True)
class StateChange:
    """A change of state between two points, `below` and `above`, with nearly the same value."""

    below: StabilityPoint
    above: StabilityPoint

    @property
    def value(self) -> float:
        """The limit: the geometric mean of the two values."""
        return float(np.sqrt(self.below.value * self.above.value))


@dataclass(frozen=True)
class MethodTrack:
    """The result of one method: its points by increasing value, from the grid and from bisection."""

    method: str
    points: tuple[StabilityPoint, ...]

    @property
    def changes(self) -> tuple[StateChange, ...]:
        """The changes of state between neighbours."""
        return tuple(StateChange(*pair) for pair in _changes(self.points))

    @property
    def digits(self) -> int:
        """The number of digits to which a change is known: more for small motions, which are bisected further."""
        return 8 if self.method == NAME else 4


@dataclass(frozen=True)
class StabilityMap(Tabled):
    """The tracks of all methods over the quantity `vary`. `span` has the range of values and the scene's own value.
    `analytic` is the limit from theory, where there is one; `setting` is the common setting of all runs."""

    title: str
    vary: str
    unit: str
    span: ValueSpan
    tracks: tuple[MethodTrack, ...]
    setting: Setting
    until: float
    limits: Limits
    analytic: float | None
    length: float

    @property
    def table(self) -> Table:
        """A table with a row for each method and value. Its column of values is named after the quantity."""
        names = {"value": self.vary, "closure": "open_by", "energy": "energy_off_by", "time": "first_bad_time"}
        return Table.of(
            {"projection": track.method} | {names.get(name, name): value for name, value in vars(point).items()}
            for track in self.tracks
            for point in track.points
        )

    @property
    def line(self) -> str:
        """A line with the quantity and the limits of each method."""
        parts = [
            f"{track.method} {', '.join(f'{change.value:.{track.digits}g}' for change in track.changes) or 'none'}"
            for track in self.tracks
        ]
        return f"{self.title}: {self.vary}{f' ({self.unit})' if self.unit else ''}; limits: {'; '.join(parts)}"

    __repr__ = Tabled.__repr__


def stability(
    scene: Scene,
    vary: str,
    *,
    projections: Sequence[str] | None = None,
    low: float | None = None,
    high: float | None = None,
    points: int = POINTS,
    until: float | None = None,
    limits: Limits | None = None,
    processes: Where = None,
    fresh: bool = False,
    tell: Tell = silent,
) -> StabilityMap:
    """Vary `vary` (a name of `QUANTITIES`, or `parameters.NAME`) from `low` to `high` for each projection method. For a
    parameter, the first track is that of small motions.

    Raises InputError where the scene does not have this quantity, or a projection method does not depend on it."""
    quantity, mechanism = quantity_named(vary), Mechanism.to_choose_for(scene)
    names = _methods(quantity, projections)
    subject = Subject(
        scene, _with_fixed_step(mechanism, until_of(scene, until)), until_of(scene, until), limits or Limits()
    )
    usual = quantity.span(subject)
    whole = ValueSpan(low or usual.low, usual.own, high or usual.high)
    if not 0.0 < whole.low < whole.high:
        message = f"there is nothing between {whole.low:g} and {whole.high:g}"
        raise InputError(Problem(message, hint="let --from be below --to"))
    _refuse_endless(quantity.changed(subject, whole.low), quantity.changed(subject, whole.high))
    what = {
        "study": "stability",
        **mechanism.identity,
        "vary": vary,
        "setting": subject.setting.command_line(),
        "until": subject.until,
        "limits": vars(subject.limits),
        "span": vars(whole),
        "points": points,
    }
    study = Study(what, tuple[StabilityPoint, ...], processes, fresh, tell)
    grid = values(whole, points)
    subjects = {name: _with_method(subject, name) for name in names}
    if quantity.of_forces and not integrators()[subject.setting.integrator].implicit:
        subjects |= _implicit(subjects)
    if quantity.of_motion:
        subjects = {NAME: replace(subject, is_linear=True), **subjects}
    walked = study.each(_points_of, (vary, grid), subjects, "methods")
    analytic = real_axis_limit(tableau_of(subject.setting.integrator)) if quantity.option == "gains" else np.inf
    step = subject.setting.step or 1.0
    return StabilityMap(
        title=scene.title,
        vary=vary,
        unit=quantity.unit or _unit_of(scene, vary),
        span=whole,
        tracks=tuple(map(MethodTrack, subjects, walked)),
        setting=subject.setting,
        until=subject.until,
        limits=subject.limits,
        analytic=analytic / step if np.isfinite(analytic) else None,
        length=mechanism.system.length,
    )


def _unit_of(scene: Scene, vary: str) -> str:
    """The SI unit of a parameter; "" where the scene does not tell it."""
    if not vary.startswith(PARAMETER):
        return ""
    return SceneText(scene.text, "scene", scene.path).units().get(tuple(vary.split(".", 1)), "")


def values(span: ValueSpan, points: int) -> list[float]:
    """The values of a span, evenly spaced in their logarithms, with the scene's own value among them."""
    grid = np.geomspace(span.low, span.high, points)
    nearest = int(np.argmin(np.abs(np.log(grid / span.own))))
    if span.low <= span.own <= span.high:
        grid[nearest] = span.own
    return [float(value) for value in grid]


def _methods(quantity: VariedQuantity, projections: Sequence[str] | None) -> tuple[str, ...]:
    """The methods to try. Raises InputError for an unknown method, or one without the option that is varied."""
    option = quantity.option
    able = [name for name, entry in PROJECTIONS.items() if not option or option in entry.options]
    for name in projections or ():
        if name not in PROJECTIONS:
            raise InputError(Problem(f"unknown projection method '{name}'", hint=choose_from(name, PROJECTIONS)))
        if name not in able:
            raise InputError(Problem(f"'{name}' has no '{option}' to vary", hint=f"these have: {', '.join(able)}"))
    return tuple(dict.fromkeys(projections or (able if option else METHODS)))


def _refuse_endless(*ends: Subject) -> None:
    """Raises InputError where a run at an end of the span would take too many steps."""
    for subject in ends:
        step, most = subject.setting.step, THRESHOLDS.most_steps
        if step is not None and subject.until / step > most:
            message = f"a run of {subject.until:.6g} s in steps of {step:.6g} s would take {subject.until / step:.3g}"
            raise InputError(Problem(f"{message} steps, and at most {most:g} are made", hint="vary it less"))


def _with_fixed_step(mechanism: Mechanism, until: float) -> Setting:
    """The scene's setting with a fixed step: its own, or the mean step that its tolerance leads to."""
    setting = Setting.of(mechanism.scene.settings)
    if setting.step is not None:
        return setting
    steps = DEFAULT_STEPS
    if setting.tolerance is not None:
        report = solve(mechanism, setting, sample_times(until, 1)).report
        steps = report.counters["steps"] if report is not None else steps
    return replace(setting, integrator=with_fixed_steps(setting.integrator), step=until / steps, tolerance=None)


def _with_method(subject: Subject, name: str) -> Subject:
    """Return the subject with another projection method, without the options that this method does not take."""
    setting = subject.setting
    taken = {option: getattr(setting, option) for option in PROJECTIONS[name].options}
    return replace(subject, setting=replace(setting, **{"alpha": None, "gains": None, **taken}, projection=name))


def _implicit(subjects: Mapping[str, Subject]) -> dict[str, Subject]:
    """The subjects with an implicit integrator, for each projection that corrects and that the kernel has."""
    return {
        f"{name}, {WHERE_STIFF}": replace(each, setting=replace(each.setting, integrator=WHERE_STIFF))
        for name, each in subjects.items()
        if PROJECTIONS[name].corrects and PROJECTIONS[name].compiled
    }


def _points_of(shared: tuple[str, list[float]], subject: Subject) -> tuple[StabilityPoint, ...]:
    """The points of a method: the grid, and then bisections between neighbours with different states."""
    vary, grid = shared
    quantity, precision = quantity_named(vary), VERDICT_PRECISION if subject.is_linear else PRECISION
    judge = small_motions if subject.is_linear else quantity.run

    def at(value: float) -> StabilityPoint:
        try:
            return judge(quantity.changed(subject, value), value)
        except MbprojError as error:
            where, time = (error.where, error.time) if isinstance(error, SimulationError) else (None, 0.0)
            return StabilityPoint(value, FAILS, np.nan, np.nan, time, where, cause_of(error), ended=False)

    known = judged_in_blocks(partial(quantity.changed, subject), grid) if judge is judged else {}
    points = [known.get(number) or at(value) for number, value in enumerate(grid)]
    for _ in range(CHANGES):
        wide = [pair for pair in _changes(points) if _gap(*pair) > precision]
        if not wide:
            break
        below, above = wide[0]
        while _gap(below, above) > precision:
            middle = at(exp(0.5 * (log(below.value) + log(above.value))))
            insort(points, middle, key=lambda point: point.value)
            below, above = (middle, above) if middle.state == below.state else (below, middle)
    return tuple(points)


def _gap(below: StabilityPoint, above: StabilityPoint) -> float:
    """The distance of two values in their logarithms."""
    return log(above.value / below.value)


def _changes(points: Sequence[StabilityPoint]) -> list[tuple[StabilityPoint, StabilityPoint]]:
    """The pairs of neighbours with different states."""
    return [(one, two) for one, two in pairwise(points) if one.state != two.state]
