"""The verdict on one run: whether it holds, degrades or fails, from which time on, and at which joint."""

from __future__ import annotations

from dataclasses import replace
from math import ceil

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.observe.recorded import Block
from mbproj.errors import MbprojError, SimulationError
from mbproj.integrate import Report, simulate
from mbproj.model import System
from mbproj.scene.records import Settings
from mbproj.studies.measure.mechanism import Mechanism, of_scene
from mbproj.studies.stability.subject import DEGRADES, FAILS, HOLDS, Limits, StabilityPoint, Subject, cause_of

#: The most samples of a run. Between samples nothing is checked.
SAMPLES = 400
#: Energies below this part of the work of gravity over the mechanism's length count as zero.
STILL = 1e-9


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
        self._system = system
        self._times: list[Array] = []
        self._open: list[Array] = []
        self._energies: list[Array] = []

    def write(self, block: Block) -> None:
        """Record a block of T samples."""
        length, angle = block["joints/violation_length"], block["joints/violation_angle"]
        self._times.append(block["time"])
        self._open.append(np.maximum(length / self._system.length, angle))
        names = ("energy_balance", "kinetic_energy", "potential_energy", "work")
        self._energies.append(np.column_stack([block[f"diagnostics/{name}"] for name in names]))

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
            joint = f"joint '{self._system.names.joints[int(np.argmax(opened[first]))]}'"
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
        weight = float(self._system.mass.sum() * np.linalg.norm(self._system.gravity) * self._system.length)
        least = max(STILL * weight, float(np.median(finite)) if len(finite) else 0.0, np.finfo(float).tiny)
        with np.errstate(invalid="ignore"):  # both overflow where a run is lost
            return np.asarray(np.abs(balance) / np.maximum(size, least))
