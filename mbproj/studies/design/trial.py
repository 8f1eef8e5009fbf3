"""Designs that are tried: the scene with their numbers, run and measured. Why one cannot be run is information, too."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import field, replace
from functools import lru_cache, partial
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.analysis.expectations import measured
from mbproj.analysis.observed import SampleSource
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import nearest
from mbproj.dynamics.equations.motions import drive_at
from mbproj.errors import InputError, SimulationError
from mbproj.integrate.loop.followed_steps import FollowedSteps
from mbproj.lanes import lane
from mbproj.model import compile_system, initial_guess
from mbproj.scene.expressions.evaluate import Value, evaluate
from mbproj.scene.expressions.syntax_tree import parse
from mbproj.scene.read import SceneText
from mbproj.scene.records import Expectation, Scene, Settings
from mbproj.scene.settings import settings_to_run
from mbproj.studies.design.slopes.neighbours import Followed
from mbproj.studies.design.spec import DesignLimit, DesignSpec, Goal
from mbproj.studies.design.target import Target
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.together.block import samples_of_block
from mbproj.studies.together.groups import by_arrays, shared
from mbproj.studies.together.signature import signature_of, values_of

#: Scenes that a process keeps taken apart.
SCENES = 4
#: Error control does not go below this tolerance.
TIGHTEST = 1e-13


@dataclass(frozen=True, eq=False)
class Wish:
    """What all trials share: the scene's text and what messages call it, the paths of what varies with its bounds (d,),
    what is wanted. `finer`: steps are divided by so many, and tolerances by its fourth power."""

    text: str
    name: str
    paths: tuple[str, ...]
    low: Array
    high: Array
    targets: tuple[Target, ...]
    goals: tuple[Goal, ...]
    limits: tuple[DesignLimit, ...]
    finer: int = 1

    @classmethod
    def of(cls, spec: DesignSpec) -> Wish:
        """Of a design's file."""
        shared = spec.paths, spec.low, spec.high, spec.targets, spec.goals, spec.limits
        return cls(spec.scene.text, str(spec.scene.path), *shared)

    @property
    def measures(self) -> tuple[Expectation, ...]:
        """Of goals and constraints."""
        of_limits = [limit.measure for limit in self.limits if limit.measure is not None]
        return (*(goal.measure for goal in self.goals), *of_limits)

    @property
    def watched(self) -> tuple[Expectation, ...]:
        """All that a run has to record."""
        return (*self.measures, *(each for target in self.targets for each in target.watched))

    def values(self, u: Array) -> Array:
        """The numbers, (d,), at shares u of the ways from the lower bounds to the upper ones."""
        return np.asarray(self.low + u * (self.high - self.low))

    def shares(self, x: Array) -> Array:
        """The shares of numbers, (d,)."""
        return np.asarray((x - self.low) / (self.high - self.low))

    def scene(self, u: Array) -> Scene:
        """The scene with the numbers at these shares. Raises InputError where it is wrong."""
        return self.scene_with(self.values(u).tolist())

    def scene_with(self, values: Sequence[Any]) -> Scene:
        """The scene with these numbers."""
        return _taken_apart(self.text, self.name).scene(dict(zip(self.paths, values, strict=True)))

    def settings(self, scene: Scene) -> Settings:
        """How a scene is run."""
        return _finer(settings_to_run(scene, by_options=False), self.finer)


@dataclass(frozen=True, eq=False)
class Trial:
    """What became of a design. `residuals` (m,) of what is matched; `goals` (g,), each to be as small as it can be;
    `limits` (c,), which hold where they are 0 or more (those of `equals` where they are 0).

    One that does not run has NaN in these, and says why in `cause`. `open`, (r,), is how far its rows stay from
    closing, in rad and parts of the length; `reached` is the share of the duration that it ran. Trials beside it follow
    its `steps`, where error control chose them; `followed` is the run itself, for slopes along it."""

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
        """Whether it closed, ran to its end, and has a number of everything that is asked for."""
        return not self.cause

    @property
    def lacking(self) -> Array:
        """What is 0 of a design that runs, as far as there is a measure of it."""
        return np.append(self.open, 1.0 - self.reached)

    @property
    def cost(self) -> float:
        """Half the sum of the residuals' squares; NaN where it does not run."""
        return 0.5 * float(self.residuals @ self.residuals)


def tried(wish: Wish, u: Array, beside: FollowedSteps | None = None) -> Trial:
    """The design at these shares, run once; with the steps of a trial `beside` it."""
    try:
        scene = wish.scene(u)
    except InputError as error:
        return _failed(wish, error.problems[0].message)
    try:
        mechanism = Mechanism.of(scene)
    except InputError as error:
        return _failed(wish, error.problems[0].message, _left_open(scene), reached=0.0)
    settings = wish.settings(scene)
    followed = Followed(mechanism, settings, wish.watched)
    try:
        samples = followed.run(beside)
    except SimulationError as error:
        return _failed(wish, str(error), np.zeros(1), error.time / settings.duration if settings.duration else 0.0)
    except InputError as error:
        return _failed(wish, error.problems[0].message)
    trial = trial_of(wish, scene.parameters, samples, settings.duration)
    return replace(trial, steps=followed.steps, followed=None if beside else followed)


def tried_together(wish: Wish, points: Sequence[Array]) -> list[Trial]:
    """The designs at some shares, each run once, with the bits of `tried`: by arrays where these know their way. Such
    trials are not followed."""
    cases = [tuple(wish.values(u).tolist()) for u in points]
    trials = by_arrays(cases, partial(_of_a_group, wish), apart=lambda case: shared(wish.paths, case))
    return [trials.get(at) or replace(tried(wish, u), followed=None) for at, u in enumerate(points)]


def _of_a_group(wish: Wish, cases: Sequence[tuple[float, ...]]) -> list[Trial | None]:
    scene = wish.scene_with(values_of(cases))
    settings, parameters = wish.settings(scene), {**scene.parameters}
    return [
        None if samples is None else trial_of(wish, lane(parameters, at), samples, settings.duration)
        for at, samples in enumerate(samples_of_block(signature_of(scene, settings), wish.watched, len(cases)))
    ]


def trial_of(
    wish: Wish,
    parameters: Mapping[str, float],
    samples: SampleSource,
    duration: float | None,
    unseen: Collection[Expectation] = (),
) -> Trial:
    """What a run of `duration` in s has of what is asked for, with the scene's parameters. What follows from measures
    that are `unseen` is NaN."""
    values = {each.name: nan for each in unseen}
    for each in wish.measures:
        if each in unseen:
            continue
        value = measured(each, samples, duration)
        if value is None or not np.isfinite(value.values[0]):
            return _failed(wish, f"'{each.name}' has no value: the run never gets there")
        values[each.name] = float(value.values[0])
    residuals = [
        np.full(target.values.size, nan)
        if any(each in unseen for each in target.watched)
        else target.residuals(samples)
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
    """A design that does not run; where nothing measures how far it is from that, all is NaN."""
    sizes = sum(target.values.size for target in wish.targets), len(wish.goals), len(wish.limits)
    residuals, goals, limits = (np.full(size, nan) for size in sizes)
    return Trial(residuals, goals, limits, np.array([nan]) if left_open is None else left_open, reached, cause)


@lru_cache(SCENES)
def _taken_apart(text: str, name: str) -> SceneText:
    return SceneText(text, name, Path(name))


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
    """What is left of the rows' violation at the pose nearest to closing, in rad and parts of the length."""
    try:
        system = compile_system(scene)
        guess = initial_guess(scene, system)
        return nearest(system, guess.q, guess.start, drive_at(system, 0.0), 1e-12)[1]
    except InputError:
        return np.array([nan])
