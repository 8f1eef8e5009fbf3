"""Trials of designs: the scene with their numbers, run and measured. For a design that does not run, a trial has the
reason."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from math import nan
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, SimulationError
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import nearest
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.motions import drive_at
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.kernel_run import FollowedSteps
from mbproj.results.analysis.expectations import SampleSource, measured
from mbproj.scene.expressions.evaluate import Value, evaluate
from mbproj.scene.expressions.syntax_tree import parse
from mbproj.scene.records import Expectation
from mbproj.scene.scene import Scene, SceneText
from mbproj.scene.settings import settings_to_run
from mbproj.studies.case_arrays import case_of
from mbproj.studies.case_blocks import CaseBlock, by_arrays, common_values, values_of
from mbproj.studies.design.neighbours import Followed
from mbproj.studies.design.spec import DesignLimit, DesignSpec, Goal
from mbproj.studies.design.target import Target
from mbproj.studies.measure.solve import Mechanism

#: The smallest tolerance of finer runs.
TIGHTEST = 1e-13


@dataclass(frozen=True, eq=False)
class Wish:
    """The common data of all trials: the scene, the paths and bounds (d,) of the varied numbers, targets, goals and
    constraints. `finer`: the divisor of steps; its fourth power divides tolerances."""

    text: SceneText
    paths: tuple[str, ...]
    low: Array
    high: Array
    targets: tuple[Target, ...]
    goals: tuple[Goal, ...]
    limits: tuple[DesignLimit, ...]
    finer: int = 1

    @classmethod
    def of(cls, spec: DesignSpec) -> Wish:
        """Return the wish of a design's file."""
        shared = spec.paths, spec.low, spec.high, spec.targets, spec.goals, spec.limits
        return cls(spec.scene, *shared)

    @property
    def measures(self) -> tuple[Expectation, ...]:
        """The measures of goals and constraints."""
        of_limits = [limit.measure for limit in self.limits if limit.measure is not None]
        return (*(goal.measure for goal in self.goals), *of_limits)

    @property
    def needed(self) -> tuple[Expectation, ...]:
        """All measures that a run must record."""
        return (*self.measures, *(each for target in self.targets for each in target.needed))

    def values(self, u: Array) -> Array:
        """The numbers (d,) at the shares u (d,) of the ranges: 0 at the lower bound, 1 at the upper one."""
        return np.asarray(self.low + u * (self.high - self.low))

    def shares(self, x: Array) -> Array:
        """The shares of numbers, (d,)."""
        return np.asarray((x - self.low) / (self.high - self.low))

    def scene(self, u: Array) -> Scene:
        """The scene with the numbers at these shares. Raises InputError where it is not valid."""
        return self.scene_with(self.values(u).tolist())

    def scene_with(self, values: Sequence[Any]) -> Scene:
        """The scene with these numbers."""
        return self.text.scene(dict(zip(self.paths, values, strict=True)))

    def settings(self, scene: Scene) -> Settings:
        """The settings with which a scene is run."""
        return _finer(settings_to_run(scene, by_options=False), self.finer)


@dataclass(frozen=True, eq=False)
class Trial:
    """The result of a design. `residuals` (m,) of the targets; `goals` (g,), each to be minimised; `limits` (c,), the
    margins of the constraints, which hold where they are 0 or more (for `equals` where they are 0).

    For a design that does not run these are NaN, and `cause` is the reason. `open` (r,): the violation of its rows at
    the nearest pose, in rad and parts of the length. `reached`: the part of the duration that it ran. Neighbouring
    trials follow its `steps` of error control. `followed` is the run itself, for slopes along it."""

    residuals: Array
    goals: Array
    limits: Array
    open: Array
    reached: float = 1.0
    cause: str = ""
    steps: FollowedSteps = field(default_factory=FollowedSteps)
    followed: Followed | None = None

    @property
    def runs(self) -> bool:
        """Whether the design closed, ran to its end, and has all wanted values."""
        return not self.cause

    @property
    def lacking(self) -> Array:
        """The violation of the rows and the missing part of the duration: 0 for a design that runs."""
        return np.append(self.open, 1.0 - self.reached)

    @property
    def cost(self) -> float:
        """Half the sum of the residuals' squares; NaN where the design does not run."""
        return 0.5 * float(self.residuals @ self.residuals)


def tried(wish: Wish, u: Array, beside: FollowedSteps | None = None) -> Trial:
    """Return the trial of the design at these shares, by a run that follows the steps `beside` of another trial, if
    given."""
    try:
        scene = wish.scene(u)
    except InputError as error:
        return _failed(wish, error.problems[0].message)
    try:
        mechanism = Mechanism.of(scene)
    except InputError as error:
        return _failed(wish, error.problems[0].message, _left_open(scene), reached=0.0)
    settings = wish.settings(scene)
    followed = Followed(mechanism, settings, wish.needed)
    try:
        samples = followed.run(beside)
    except SimulationError as error:
        return _failed(wish, str(error), np.zeros(1), error.time / settings.duration if settings.duration else 0.0)
    except InputError as error:
        return _failed(wish, error.problems[0].message)
    trial = trial_of(wish, scene.parameters, samples, settings.duration)
    return replace(trial, steps=followed.steps, followed=None if beside else followed)


def tried_by_arrays(wish: Wish, points: Sequence[Array]) -> list[Trial]:
    """Return the trials of the designs at some shares, with the bits of `tried`. Designs run by arrays where these are
    supported. These trials have no run to follow."""
    cases = [tuple(wish.values(u).tolist()) for u in points]
    trials = by_arrays(cases, partial(_of_a_group, wish), apart=lambda case: common_values(wish.paths, case))
    return [trials.get(at) or replace(tried(wish, u), followed=None) for at, u in enumerate(points)]


def _of_a_group(wish: Wish, cases: Sequence[tuple[float, ...]]) -> list[Trial | None]:
    scene = wish.scene_with(values_of(cases))
    settings, parameters = wish.settings(scene), {**scene.parameters}
    return [
        None if samples is None else trial_of(wish, case_of(parameters, at), samples, settings.duration)
        for at, samples in enumerate(CaseBlock.of(scene, settings, len(cases)).samples(wish.needed))
    ]


def trial_of(
    wish: Wish,
    parameters: Mapping[str, float],
    samples: SampleSource,
    duration: float | None,
    unseen: Collection[Expectation] = (),
) -> Trial:
    """Return the trial from the samples of a run of `duration` in s, with the scene's parameters. Values that depend on
    `unseen` measures are NaN."""
    values = {each.name: nan for each in unseen}
    for each in wish.measures:
        if each in unseen:
            continue
        value = measured(each, samples, duration)
        if value is None or not np.isfinite(value.values[0]):
            return _failed(wish, f"'{each.name}' has no value: the run never gets there")
        values[each.name] = float(value.values[0])
    residuals = [
        np.full(target.values.size, nan) if any(each in unseen for each in target.needed) else target.residuals(samples)
        for target in wish.targets
    ]
    for target, off in zip(wish.targets, residuals, strict=True):
        if off is None:
            return _failed(wish, f"'{target.name}': '{target.over}' does not pass all values")
    return Trial(
        residuals=np.concatenate([np.zeros(0), *(off for off in residuals if off is not None)]),
        goals=np.array([goal.sign * values[goal.measure.name] for goal in wish.goals]),
        limits=np.array([_margin(limit, values, parameters) for limit in wish.limits]),
        open=np.zeros(1),
    )


def _failed(wish: Wish, cause: str, left_open: Array | None = None, reached: float = 1.0) -> Trial:
    """Return the trial of a design that does not run. `open` is NaN where nothing measures its distance from one that
    runs."""
    sizes = sum(target.values.size for target in wish.targets), len(wish.goals), len(wish.limits)
    residuals, goals, limits = (np.full(size, nan) for size in sizes)
    return Trial(residuals, goals, limits, np.array([nan]) if left_open is None else left_open, reached, cause)


def _finer(settings: Settings, finer: int) -> Settings:
    if finer == 1:
        return settings
    step = None if settings.step is None else settings.step / finer
    tolerance = None if settings.tolerance is None else max(settings.tolerance / finer**4, TIGHTEST)
    return replace(settings, step=step, tolerance=tolerance)


def _margin(limit: DesignLimit, values: dict[str, float], parameters: Mapping[str, float]) -> float:
    if limit.measure is not None:
        value = values[limit.measure.name]
    else:
        names = {name: Value(number, None) for name, number in parameters.items()}
        value = evaluate(parse(limit.expression, frozenset(names)), names).number
    return limit.bound - value if limit.side == "at_most" else value - limit.bound


def _left_open(scene: Scene) -> Array:
    """Return the violation of the rows at the pose nearest to closing, in rad and parts of the length."""
    try:
        system = compile_system(scene)
        guess = initial_guess(scene, system)
        return nearest(system, guess.q, guess.start, drive_at(system, 0.0), 1e-12)[1]
    except InputError:
        return np.array([nan])
