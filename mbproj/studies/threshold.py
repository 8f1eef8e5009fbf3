"""threshold_study(): the savings and the cost of projecting only where the violation exceeds a threshold.

The paper recommends this in one sentence (sect. 4.3) without a test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import nan
from typing import Any

import numpy as np

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.registry import PROJECTIONS
from mbproj.results.views import Table, Tabled
from mbproj.scene.scene import Scene
from mbproj.studies.measure.measurement import REPETITIONS, Measurement, SettingsStudy, Timing, timing_columns
from mbproj.studies.measure.reference import Reference, certain_reference, span
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Mechanism
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent

#: Exponents of the thresholds, powers of ten, for a mechanism of 1 m.
EXPONENTS = range(-13, 0)
#: The error may be this factor larger than with a projection after every step.
TOLERATED = 1.1
#: A threshold must save at least this part of the projections to be recommended.
SAVES = 0.01


@dataclass(frozen=True, eq=False)
class ThresholdStudy(Tabled):
    """Trials and timings (None where the run failed) of a setting. The first projects after every step, the next ones
    above each threshold in rising order, the last never.

    `recommended` is the index of the largest threshold whose error is tolerated; None where it saves hardly any
    projection. `exceeded` are the indices of smaller thresholds with a larger error, as errors do not grow evenly.
    `points` are those whose error counts; empty for all."""

    title: str
    trials: tuple[Measurement, ...]
    timings: tuple[Timing | None, ...]
    reference: Reference
    recommended: int | None
    exceeded: tuple[int, ...]
    notes: tuple[str, ...]
    points: tuple[str, ...] = ()

    def saved(self, index: int) -> float:
        """The part of the projections that a trial leaves out; NaN where it failed."""
        every = self.trials[0].counters.get("projections", 0)
        done = self.trials[index].counters.get("projections")
        return float("nan") if done is None or not every else 1.0 - done / every

    @property
    def table(self) -> Table:
        """A table with a row for each trial."""
        return Table.of(map(self._row, range(len(self.trials))))

    @property
    def line(self) -> str:
        """A line with the title and the recommendation."""
        best = None if self.recommended is None else self.trials[self.recommended].setting.threshold
        return f"{self.title}: {'project after every step' if best is None else f'threshold {best:g}'}"

    __repr__ = Tabled.__repr__

    def _row(self, index: int) -> dict[str, Any]:
        trial = self.trials[index]
        return {
            "threshold": trial.setting.threshold,
            "projection": trial.setting.projection,
            "error": trial.at(self.points),
            "position_violation": trial.position_violation,
            "velocity_violation": trial.velocity_violation,
            "energy_drift": trial.energy_drift,
            "steps": trial.counters.get("steps", nan),
            "projections": trial.counters.get("projections", nan),
            "projections_saved": self.saved(index),
            **timing_columns(self.timings[index]),
            "recommended": index == self.recommended,
            "failure": trial.failure or "",
        }


def threshold_study(
    scene: Scene,
    *,
    thresholds: Sequence[float] | None = None,
    at: Sequence[str] = (),
    until: float | None = None,
    repetitions: int = REPETITIONS,
    processes: Where = None,
    fresh: bool = False,
    tell: Tell = silent,
) -> ThresholdStudy:
    """Varies the threshold (m or rad, and per s) of the scene's own setting, and measures error, violation and cost.

    Raises InputError where the scene's setting has no projection, or does not run."""
    mechanism = Mechanism.to_choose_for(scene)
    columns = mechanism.columns(at)
    scene_setting = _every_step(Setting.of(scene.settings), scene)
    size = round(np.log10(mechanism.system.length))
    usual = [float(f"1e{size + exponent}") for exponent in EXPONENTS]
    chosen = sorted(usual if thresholds is None else {*map(float, thresholds)})
    same = {name: getattr(scene_setting, name) for name in ("integrator", "step", "tolerance", "formulation")}
    without = replace(scene_setting.projected_by("none"), **same)
    settings = [scene_setting, *(replace(scene_setting, threshold=value) for value in chosen), without]
    truth, notes = certain_reference(mechanism, span(scene, until), scene_setting, (scene_setting.integrator,), tell)
    study = SettingsStudy("threshold", mechanism, truth, processes, fresh, tell)
    trials = study.measured(settings)
    if trials[0].failure is not None:
        raise InputError(Problem(f"the scene's own setting fails: {trials[0].failure}", hint="choose a smaller step"))
    if not trials[0].counters["projections"]:
        raise InputError(Problem("there is nothing to project: no joint, and no motion, constrains this mechanism"))
    timings = study.timed([trial.setting for trial in trials if trial.failure is None], repetitions)
    recommended, exceeded = _recommended(trials[:-1], tuple(at), float(truth.uncertainty[-1, columns].max()))
    return ThresholdStudy(
        title=scene.title,
        trials=tuple(trials),
        timings=tuple(map(timings.get, settings)),
        reference=truth,
        recommended=recommended,
        exceeded=exceeded,
        notes=tuple(notes),
        points=tuple(at),
    )


def _every_step(setting: Setting, scene: Scene) -> Setting:
    if not PROJECTIONS[setting.projection].corrects:
        problem = Problem(
            f"'{setting.projection}' makes no projections",
            scene.place("simulation", "projection"),
            "choose one with --projection, gpopm for example",
        )
        raise InputError(problem)
    if setting.step is None and setting.tolerance is None:
        problem = Problem(
            "the scene has neither step nor tolerance",
            scene.place("simulation"),
            "add one of them to 'simulation', or --step or --tolerance",
        )
        raise InputError(problem)
    return replace(setting, every=1, threshold=None)


def _recommended(
    trials: Sequence[Measurement], at: tuple[str, ...], floor: float
) -> tuple[int | None, tuple[int, ...]]:
    """The index (from 1) of the last threshold whose error is tolerated, or None where it saves hardly any projection;
    then the indices of the thresholds before it whose error is not tolerated."""
    errors = [trial.at(at) for trial in trials]
    limit = max(TOLERATED * errors[0], errors[0] + floor)
    last = max(index for index in range(len(errors)) if errors[index] <= limit)
    if trials[last].counters.get("projections", 0) > (1.0 - SAVES) * trials[0].counters["projections"]:
        return None, ()
    return last, tuple(index for index in range(1, last) if not errors[index] <= limit)
