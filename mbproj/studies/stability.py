"""The subject of a stability map, a scene with a setting, and the verdict on it: whether it holds, degrades or fails,
from which time on, and at which joint. A run is judged, or the small motions about the equilibrium are: by the modes,
or from one round of a sampled controller's instants to the next."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from math import ceil

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.observe.recorded import Block
from mbproj.errors import InputError, MbprojError, Problem, SimulationError
from mbproj.integrate import Report, simulate
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.modes import modes
from mbproj.linear.reference import reference_at
from mbproj.linear.state_space.instants import round_of
from mbproj.model import System
from mbproj.scene.read import Scene
from mbproj.scene.records import Settings
from mbproj.studies.cases.array import OneCaseOnly, case_of
from mbproj.studies.cases.block import CaseBlock, as_one
from mbproj.studies.cases.groups import by_arrays
from mbproj.studies.measure.mechanism import Mechanism, of_scene
from mbproj.studies.measure.setting import Setting
from mbproj.thresholds import THRESHOLDS

#: The three states of a point, from best to worst.
HOLDS, DEGRADES, FAILS = "holds", "degrades", "fails"
#: The most samples of a run. Between samples nothing is checked.
SAMPLES = 400
#: Energies below this part of the work of gravity over the mechanism's length count as zero.
STILL = 1e-9
#: The most values that are judged in one block.
BLOCK = 50
#: The name of the track, and the relative precision of its limits: each point costs little.
NAME, PRECISION = "small motions", 1e-8
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
    """Run the subject and judge it. An error becomes the cause of a failed point."""
    try:
        mechanism = Mechanism.of(subject.scene)
    except MbprojError as error:
        return StabilityPoint(value, FAILS, np.nan, np.nan, 0.0, None, cause_of(error), ended=False)
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
        own = subjects[0]
        if own.setting.energy_row or any(replace(each, scene=own.scene) != own for each in subjects):
            raise OneCaseOnly("settings of several cases differ")
        # a run does not depend on the texts of changes
        scenes = [replace(each.scene, overrides=own.scene.overrides) for each in subjects]
        cases = CaseBlock.of(as_one(scenes), settings_of(own), len(group))
        blocks, ended = cases.observed()
        watch = _Watch(cases.mechanism.system)
        for block in blocks:
            watch.write(block)
        return [
            watch.of_case(at).point(value, own.limits, None) if ended[at] else None for at, value in enumerate(group)
        ]

    return by_arrays(
        values,
        run,
        lambda value, point: repr(judged(changed(value), value)) == repr(point),
        lambda value: values.index(value) // BLOCK,
    )


def _with_energy_row(point: StabilityPoint, report: Report, subject: Subject) -> StabilityPoint:
    """Return the point with the energy that the projection's energy row gave or took as an error of the balance."""
    limits, given = subject.limits, report.rows.furthest / max(report.exchanged, np.finfo(float).tiny)
    if point.state == FAILS or not given > max(limits.energy, point.energy):
        return replace(point, energy=max(point.energy, given)) if given > 0.0 else point
    state = FAILS if given > limits.lost else DEGRADES
    said = point.cause or f"the energy row gave or took {given:.1e} of it"
    return replace(point, state=state, energy=given, time=point.time or subject.until, cause=said)


def settings_of(subject: Subject) -> Settings:
    """The settings of the run, with a sample every few steps. Raises InputError where they do not fit each other."""
    step = subject.setting.step
    if step is None:
        return of_scene(subject.scene, subject.setting.settings(subject.until, subject.until / SAMPLES))
    steps = max(1, ceil(subject.until / step / SAMPLES))
    return replace(of_scene(subject.scene, subject.setting.settings(subject.until, step)), output_step=steps * step)


class _Watch:
    """A recorder of how far each joint is open, and of the energies."""

    def __init__(self, system: System) -> None:
        self._length, self._joints = system.length, system.names.joints
        self._weight = system.mass.sum() * np.linalg.norm(system.gravity) * system.length
        self._times: list[Array] = []
        self._open: list[Array] = []
        self._energies: list[Array] = []

    def write(self, block: Block) -> None:
        """Record a block of T samples."""
        length, angle = block["joints/violation_length"], block["joints/violation_angle"]
        self._times.append(block["time"])
        self._open.append(np.maximum(length / self._length, angle))
        names = ("energy_balance", "kinetic_energy", "potential_energy", "work")
        self._energies.append(np.column_stack([block[f"diagnostics/{name}"] for name in names]))

    def of_case(self, at: int) -> _Watch:
        """The recorded data of one case of a block."""
        watch = copy(self)
        vars(watch).update({name: case_of(value, at) for name, value in vars(self).items()})
        return watch

    def point(self, value: float, limits: Limits, stopped: MbprojError | None) -> StabilityPoint:
        """Judge what was recorded. `stopped` is the error that ended the run, if any."""
        where = stopped.where if isinstance(stopped, SimulationError) else None
        end = stopped.time if isinstance(stopped, SimulationError) else 0.0
        cause = "" if stopped is None else f"stops at {end:.3g} s: {cause_of(stopped)}"
        if not self._times:
            return StabilityPoint(value, FAILS, np.nan, np.nan, end, where, cause, ended=False)
        times, opened, off = np.concatenate(self._times), np.concatenate(self._open), self._balance_error()
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
        balance, kinetic, potential, work = np.concatenate(self._energies).T
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
