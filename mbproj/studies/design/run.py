"""find_design(): the searches of a design from many starts, each stored as it ends; the best design, and its
accuracy.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from functools import partial
from importlib.util import find_spec
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.stats import qmc

from mbproj.base.arrays import Array, Flags
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.scene.ranges import column_of
from mbproj.studies.design.slopes import Counted, derivative
from mbproj.studies.design.spec import DesignSpec
from mbproj.studies.design.target import Target
from mbproj.studies.design.trial import Trial, Wish, tried, tried_by_arrays
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell
from mbproj.studies.study import Study

# --- The starts of searches -------------------------------------------------------------------------------------------
# The scene's own numbers and the best of many points. A design that does not run is moved to one that runs, by least
# squares of what it lacks.


#: The number of points tried for each start.
POINTS = 8
#: The least distance of a search's start from a bound, as a part of the range.
INSIDE = 1e-6
#: The most evaluations to move a design to one that runs, and the step of their differences.
EFFORT, STEP = 20, 1e-6


def points_of(spec: DesignSpec) -> tuple[Array, bool]:
    """Return points of Sobol's sequence as shares (n, d), and whether the scene's own numbers come first. They do where
    all are known and within the bounds."""
    count = max(POINTS * spec.starts, 2)
    sampler = qmc.Sobol(len(spec.paths), rng=np.random.default_rng(spec.seed))
    points = sampler.random_base2(int(np.ceil(np.log2(count))))[:count]
    scene_point = (spec.scene_numbers - spec.low) / (spec.high - spec.low)
    within = bool(np.all((scene_point >= 0.0) & (scene_point <= 1.0)))
    points = np.concatenate([scene_point[None], points]) if within else points
    return np.clip(points, INSIDE, 1.0 - INSIDE), within


def looked_at(wish: Wish, points: Sequence[list[float]]) -> list[list[float]]:
    """Return the ranks of points, lists that are compared entry by entry; smaller is better. A work item."""
    return [_rank(trial) for trial in tried_by_arrays(wish, [np.array(point) for point in points])]


def _rank(trial: Trial) -> list[float]:
    """Designs that run come first; of these, those that keep the constraints."""
    if trial.runs:
        broken = violation(trial)
        return [0.0, broken, value_of(trial)]
    lacking = float(np.linalg.norm(trial.lacking))
    return [1.0, lacking if np.isfinite(lacking) else np.inf, 0.0]


def value_of(trial: Trial) -> float:
    """Return the value to be minimised: half the sum of squares, or the sum of the goals."""
    return trial.cost if len(trial.residuals) else float(trial.goals.sum())


def violation(trial: Trial, equal: Flags | None = None) -> float:
    """Return the root of the sum of squares of the constraints' violations; `equal` (c,) marks those that must be 0."""
    broken = np.minimum(trial.limits, 0.0)
    if equal is not None:
        broken = np.where(equal, trial.limits, broken)
    return float(np.linalg.norm(broken))


def brought_in(trials: Counted, u: Array) -> Array | None:
    """Return a design near u that runs, found by least squares: the violation of its rows, and the part of the duration
    that it does not run. None where none is found."""
    if trials(u).runs:
        return u
    if not np.isfinite(trials(u).lacking).all():
        return None
    poses: list[Array] = []

    def lacking(v: Array) -> Array:
        trial = trials(v)
        if trial.runs:
            poses.append(v.copy())
            raise StopIteration
        values = np.zeros(size)
        known = trial.lacking[: size - 1]
        values[: len(known)], values[-1] = known, 1.0 - trial.reached
        return values

    size, inside = max(len(trials(u).lacking), 2), np.clip(u, INSIDE, 1.0 - INSIDE)
    with suppress(StopIteration, ValueError):  # ValueError where values are NaN
        least_squares(
            lacking,
            inside,
            lambda v: np.nan_to_num(derivative(lacking, v, lacking(v), STEP, central=False)),
            bounds=(0.0, 1.0),
            max_nfev=EFFORT,
        )
    return poses[0] if poses else None


# --- The search engines by name, and a search from one start with counted trials --------------------------------------


#: The most iterations of a search with derivatives.
ITERATIONS = 200
#: Such a search ends at these relative changes of the value and of the shares.
SMALLEST = 1e-15
#: The runs of an evolution strategy for each varied number, and its initial width.
EVOLVED, WIDTH = 400, 0.25
#: The tolerance of a constraint in the end, relative to its bound or to 1.
BROKEN = 1e-8


@dataclass(frozen=True)
class SearchTask:
    """A search from the shares `u` (d,), by an engine, with a seed for its random numbers."""

    u: tuple[float, ...]
    engine: str
    seed: int


class Watched:
    """Trials of one search, the best of them, and the trace: (runs, value) at each improvement."""

    def __init__(self, wish: Wish) -> None:
        self.trials, self._equal = Counted(wish), equalities(wish)
        self._allowed = np.array([BROKEN * max(abs(limit.bound), 1.0) for limit in wish.limits])
        self.best: tuple[float, float, Array] | None = None
        self.trace: list[tuple[int, float]] = []

    def __call__(self, u: Array) -> Trial:
        """The trial at u."""
        trial = self.trials(u)
        if trial.runs:
            broken = violation(trial, self._equal)
            excess = 0.0 if broken <= np.linalg.norm(self._allowed) else broken
            if self.best is None or (excess, value_of(trial)) < self.best[:2]:
                self.best = excess, value_of(trial), u.copy()
                self.trace.append((self.trials.count, value_of(trial)))
        return trial


def searched(wish: Wish, task: SearchTask) -> Search:
    """Return the result of one search. A work item."""
    watched = Watched(wish)
    start = np.array(task.u)
    first = watched(start)
    inside = brought_in(watched.trials, start)
    if inside is not None:
        ENGINES[task.engine](wish, watched, np.clip(inside, INSIDE, 1.0 - INSIDE), task.seed)
    broken, value, end = watched.best or (np.nan, np.nan, None)
    return Search(
        start=wish.values(start),
        end=np.full(len(start), np.nan) if end is None else wish.values(end),
        value=float(value),
        broken=float(broken),
        runs=watched.trials.count,
        trace=np.array(watched.trace, dtype=float).reshape(-1, 2),
        cause="" if end is not None else first.cause,
    )


def _by_least_squares(wish: Wish, watched: Watched, u: Array, seed: int) -> None:
    """Levenberg-Marquardt's method in a trust region with bounds (Branch, Coleman, Li 1999). A trial that does not run
    makes the region smaller."""

    def residuals(v: Array) -> Array:
        return watched(v).residuals

    def slopes(v: Array) -> Array:
        return np.nan_to_num(watched.trials.slopes(lambda trial: trial.residuals, v, central=False))

    least_squares(
        residuals,
        u,
        slopes,
        bounds=(0.0, 1.0),
        x_scale="jac",
        ftol=SMALLEST,
        xtol=SMALLEST,
        gtol=SMALLEST,
        max_nfev=ITERATIONS,
    )


def _by_quadratic_programs(wish: Wish, watched: Watched, u: Array, seed: int) -> None:
    """Sequential quadratic programs (Kraft 1988: SLSQP). A trial that does not run gets a value above the last one,
    growing with its distance, so that the line search goes back."""
    equal = equalities(wish)
    size = max(abs(value_of(watched(u))), 1e-300)
    last = u.copy()

    def all_of(trial: Trial) -> Array:
        return np.array([value_of(trial) / size, *trial.limits])

    def both(v: Array) -> Array:
        return all_of(watched(v))

    def value(v: Array) -> float:
        merit = float(both(v)[0])
        if np.isfinite(merit):
            return merit
        return float(both(last)[0]) + 1.0 + float(np.linalg.norm(v - last))

    def slopes(v: Array) -> Array:
        nonlocal last
        at = both(v)
        if not np.isfinite(at).all():
            return np.zeros((len(at), len(v)))
        last = v.copy()
        return np.nan_to_num(watched.trials.slopes(all_of, v, central=True))

    def limits(rows: Flags, sign: str) -> dict[str, Any]:
        return {
            "type": sign,
            "fun": lambda v: np.nan_to_num(both(v)[1:][rows], nan=-1.0),
            "jac": lambda v: slopes(v)[1:][rows],
        }

    constraints = [limits(rows, sign) for rows, sign in ((~equal, "ineq"), (equal, "eq")) if rows.any()]
    minimize(
        value,
        u,
        jac=lambda v: slopes(v)[0],
        bounds=[(0.0, 1.0)] * len(u),
        method="SLSQP",
        constraints=constraints,
        options={"maxiter": ITERATIONS, "ftol": SMALLEST},
    )


def _by_evolution(wish: Wish, watched: Watched, u: Array, seed: int) -> None:
    """Evolution with an adapted covariance matrix (Hansen: CMA-ES), which needs no derivative. Points that keep the
    constraints come first, then the others by their violation (Deb 2000). The method needs at least two numbers: a
    single number gets an idle second one."""
    import cma

    equal = equalities(wish)
    strategy = cma.CMAEvolutionStrategy(
        [*u.tolist(), *([0.5] if len(u) == 1 else [])],
        WIDTH,
        {"bounds": [0.0, 1.0], "seed": seed + 1, "verbose": -9, "maxfevals": EVOLVED * len(u), "tolfun": 1e-12},
    )
    while not strategy.stop():
        points = strategy.ask()
        designs = [np.array(point[: len(u)]) for point in points]
        watched.trials.ahead(designs)
        trials = [watched(v) for v in designs]
        lacks = [lacking(trial, equal) for trial in trials]
        worst = max((value_of(each) for each, lack in zip(trials, lacks, strict=True) if lack == 0.0), default=0.0)
        ranks = [
            value_of(each) if lack == 0.0 else worst + 1.0 + min(lack, 1e6)
            for each, lack in zip(trials, lacks, strict=True)
        ]
        strategy.tell(points, ranks)


def lacking(trial: Trial, equal: Flags) -> float:
    """Return 0 for a design that runs and keeps the constraints; else a measure of its distance from one."""
    if trial.runs:
        broken = violation(trial, equal)
        return broken if broken > BROKEN else 0.0
    far = float(np.linalg.norm(trial.lacking))
    return 1e3 * (1.0 + far) if np.isfinite(far) else 1e6


def equalities(wish: Wish) -> Flags:
    """Return whether each constraint is an equality, (c,)."""
    return np.array([limit.side == "equals" for limit in wish.limits], dtype=bool)


LEAST_SQUARES, QUADRATIC, EVOLUTION, FRONT = "least_squares", "slsqp", "cma", "nsga2"
ENGINES: Mapping[str, Callable[[Wish, Watched, Array, int], None]] = {
    LEAST_SQUARES: _by_least_squares,
    QUADRATIC: _by_quadratic_programs,
    EVOLUTION: _by_evolution,
}


# --- find_design() ----------------------------------------------------------------------------------------------------


#: The engines that use derivatives.
BY_SLOPES = (LEAST_SQUARES, QUADRATIC)
#: The number of starting points in one work item.
TOGETHER = 16
#: Measures whose slope jumps where another sample, or another peak, becomes the extreme one.
KINKED = ("largest", "maximum", "minimum", "range")
#: The number of best designs at one of which each number must have an effect, and the relative size of an effect that
#: counts as none.
LOOKED_AT, NO_EFFECT = 2, 1e-9
#: Residuals below this part of the matched values are round-off.
ROUND_OFF = 1e-13
#: A number this near to a bound, as a part of its range, touches it.
TOUCHES = 1e-6


@dataclass(frozen=True, eq=False)
class Search:
    """The result of one start: the initial and the final numbers (d,), in SI units; the final ones are NaN where no
    design runs. `value` is half the sum of squares, or the first goal. `trace` (n, 2): the number of runs, and the
    value reached by then. With several goals a search stands for a design of the front, with `goals` (g,) to be
    minimised."""

    start: Annotated[Array, "d"]
    end: Annotated[Array, "d"]
    value: float
    broken: float
    runs: int
    trace: Annotated[Array, "r 2"]
    cause: str
    goals: Array = field(default_factory=lambda: np.zeros(0))

    def rank(self) -> tuple[float, float]:
        """The violation of the constraints, then the value: a smaller rank is better."""
        return (self.broken, self.value) if np.isfinite(self.value) else (np.inf, np.inf)


@dataclass(frozen=True, eq=False)
class FoundDesign:
    """The best design: its numbers `x` (d,), its trial, and all `searches`, the best first. With several goals it is
    the most balanced design of the front.

    `engine` searched, for the reason `why`. `reused`: the number of starts with stored searches. `runs`: the number of
    all runs. `knowledge`: the accuracy of numbers fitted to data. `error` (m,): the change of the residuals with steps
    half as long. `notes` are remarks. `differences`: the reason why slopes came from differences of runs. It is empty
    where dual numbers gave them, and None for engines without slopes."""

    spec: DesignSpec
    x: Array
    trial: Trial
    searches: tuple[Search, ...]
    engine: str
    why: str
    reused: int
    runs: int
    knowledge: Knowledge | None
    error: Array
    notes: tuple[str, ...]
    differences: str | None

    @property
    def why_differences(self) -> dict[str, str]:
        """The reasons, by measure, why their slopes came from differences, where dual numbers gave slopes of other
        measures."""
        if self.differences != "" or self.trial.followed is None:
            return {}
        return {each.name: why for each, why in self.trial.followed.missing.items()}

    @property
    def deviations(self) -> Iterator[tuple[Target, Array]]:
        """Yield the targets, each with the run's deviation from its values, (N, k), in its unit."""
        at = 0
        for target in self.spec.targets:
            part = self.trial.residuals[at : (at := at + target.values.size)].reshape(target.values.T.shape)
            yield target, part.T * target.deviation / target.weight**0.5


def engine_of(spec: DesignSpec, asked: str | None) -> tuple[str, str]:
    """The engine of the search, and the reason. Raises InputError where the requested engine cannot solve this design,
    or is not installed."""
    kinked = [each.measure.name for each in (*spec.goals,) if each.measure.at in KINKED]
    if (len(spec.goals) > 1) != (asked == FRONT) and (asked is not None or len(spec.goals) > 1):
        if asked is None:
            return _installed(FRONT), "there are several goals"
        what = "one goal alone" if len(spec.goals) > 1 else "several goals"
        raise InputError(Problem(f"'{asked}' is for {what}", hint="leave --engine out"))
    if asked == LEAST_SQUARES and (spec.goals or spec.limits):
        what = "goals" if spec.goals else "constraints"
        hint = f"leave --engine out, or take {QUADRATIC}"
        raise InputError(Problem(f"least squares know no {what}", spec.place("subject_to"), hint))
    if asked is not None:
        return _installed(asked), "it was asked for"
    if spec.targets and not spec.limits:
        return LEAST_SQUARES, "all that is wanted are residuals"
    if not kinked:
        return QUADRATIC, "what is wanted is smooth" if spec.goals else "there are constraints beside the residuals"
    if find_spec("cma") is not None:
        return EVOLUTION, f"'{kinked[0]}' has kinks where another sample becomes the {_word(spec, kinked[0])}"
    return QUADRATIC, f"'{kinked[0]}' has kinks, and pip install 'mbproj[design]' brings a search for such"


def _word(spec: DesignSpec, name: str) -> str:
    return next(str(each.measure.at) for each in spec.goals if each.measure.name == name)


def _installed(name: str) -> str:
    package = {EVOLUTION: "cma", FRONT: "optuna"}.get(name)
    if package is not None and find_spec(package) is None:
        raise InputError(Problem(f"'{name}' is not installed", hint="pip install 'mbproj[design]'"))
    return name


def find_design(
    spec: DesignSpec,
    where: Where = None,
    *,
    engine: str | None = None,
    fresh: bool = False,
    tell: Tell = lambda *_: None,
) -> FoundDesign:
    """Searches from the spec's starts, and returns the best design. Stored searches are taken from the store, unless
    `fresh`. Raises InputError where no design runs, and KeyboardInterrupt after Ctrl-C; finished searches stay
    stored."""
    chosen, why = engine_of(spec, engine)
    wish = Wish.of(spec)
    kind = list[list[float]] | Front | Search
    study = Study(["design", _identity(spec), chosen], kind, where, fresh, tell, d=len(spec.paths))
    points, scene_first = points_of(spec)
    blocks = {f"look {k}": points[k : k + TOGETHER].tolist() for k in range(0, len(points), TOGETHER)}
    ranks = [rank for block in study.each(looked_at, wish, blocks, "blocks of starting points") for rank in block]
    order = sorted(range(len(points)), key=ranks.__getitem__)
    if scene_first:
        order.sort(key=bool)  # the scene's own numbers are always among the starts
    _check_effects(spec, wish, [points[k] for k in order])
    tasks = {f"start {k}": SearchTask(tuple(points[k].tolist()), chosen, spec.seed) for k in order[: spec.starts]}
    reused = sum(name in study.results for name in tasks)
    search, best = (front_of, None) if chosen == FRONT else (searched, partial(_so_far, spec))
    found = study.each(search, wish, tasks, "searches", best)
    runs = len(points) + sum(each.runs for each in found)
    searches = _on_the_front(spec, wish, found) if chosen == FRONT else sorted(found, key=Search.rank)
    if not np.isfinite(searches[0].value):
        causes = [each.cause for each in searches]
        message = f"no design runs; most often: {max(causes, key=causes.count)}"
        raise InputError(Problem(message, spec.place("vary"), "widen the bounds, or mend the scene"))
    return _best_design(spec, wish, tuple(searches), (chosen, why), reused, runs)


def _check_effects(spec: DesignSpec, wish: Wish, points: Sequence[Array]) -> None:
    """Raises InputError for each number without effect on residuals, goals and constraints at the best starting
    designs."""

    def all_of(trial: Trial) -> Array:
        return np.concatenate([trial.residuals, trial.goals, trial.limits])

    effects, trials = [], Counted(wish)
    for u in points[:LOOKED_AT]:
        if np.isfinite(all_of(trials(u))).all():
            slopes = np.nan_to_num(trials.slopes(all_of, u, central=False), nan=1.0)
            effects.append(np.abs(slopes).max(axis=0) / max(float(np.abs(slopes).max()), 1e-300))
    if effects:
        idle = [path for path, effect in zip(spec.paths, np.max(effects, axis=0), strict=True) if effect < NO_EFFECT]
        problems = [
            Problem(f"'{column_of(path)}' changes nothing of what is wanted", spec.place("vary", path), "leave it out")
            for path in idle
        ]
        if problems:
            raise InputError(problems)


def _so_far(spec: DesignSpec, found: Search) -> tuple[tuple[float, float], str]:
    """The rank of a search, and words on it for the progress report."""
    value, broken = found.value, found.broken
    if not np.isfinite(value):
        return (np.inf, np.inf), "none has found a design that runs"
    if broken > 0.0:
        return (broken, value), "none keeps the constraints yet"
    if spec.goals:
        goal = spec.goals[0]
        return (broken, value), f"best {goal.measure.name} {goal.sign * value:.4g} {goal.measure.unit}".rstrip()
    count = sum(target.values.size for target in spec.targets)
    words = f"best rms of residuals {np.sqrt(2.0 * value / count):.2g}"
    alone = spec.targets[0] if len(spec.targets) == 1 and spec.targets[0].weight == 1.0 else None
    return (broken, value), words if alone is None or alone.deviation != 1.0 else f"{words} {alone.unit}".rstrip()


def _on_the_front(spec: DesignSpec, wish: Wish, fronts: Sequence[Front]) -> list[Search]:
    """The undominated designs of all fronts: the most balanced one, then the others by the first goal. Raises
    InputError where there is none."""
    ends, goals = merged(fronts)
    if not len(ends):
        hint = "widen the bounds, or ask for less"
        raise InputError(Problem("no design runs and keeps the constraints", spec.place("vary"), hint))
    first = balanced(goals)
    order = [first, *(k for k in range(len(ends)) if k != first)]
    nothing, none = np.full(len(spec.paths), np.nan), np.zeros((0, 2))
    return [Search(nothing, wish.values(ends[k]), float(goals[k, 0]), 0.0, 0, none, "", goals[k]) for k in order]


def _identity(spec: DesignSpec) -> list[Any]:
    """The data that determine the searches, as a key: the file, the scene, the measurements."""
    data = [[target.abscissa.tolist(), target.values.tolist()] for target in spec.targets]
    return [spec.text, spec.scene.whole, data]


def _best_design(
    spec: DesignSpec,
    wish: Wish,
    searches: tuple[Search, ...],
    engine: tuple[str, str],
    reused: int,
    runs: int,
) -> FoundDesign:
    best = searches[0]
    u = wish.shares(best.end)
    trials = Counted(wish)
    trial, finer = trials(u), tried(replace(wish, finer=2), u)
    error = finer.residuals - trial.residuals
    known = None
    if spec.targets:
        slopes = trials.slopes(lambda trial: trial.residuals, u, central=True)
        known = knowledge(spec.paths, best.end, spec.high - spec.low, slopes, trial.residuals, error)
    notes = (*spec.notes, *_notes(spec, best, u, trial, known, error))
    misses = trial.followed.misses if trial.followed is not None else ""
    why = trials.why or misses if engine[0] in BY_SLOPES else None
    return FoundDesign(spec, best.end, trial, searches, *engine, reused, runs, known, error, notes, why)


def _notes(spec: DesignSpec, best: Search, u: Array, trial: Trial, known: Knowledge | None, error: Array) -> list[str]:
    notes = []
    for path, share in zip(spec.paths, u, strict=True):
        if share < TOUCHES or share > 1.0 - TOUCHES:
            notes.append(f"'{column_of(path)}' is at its {'lower' if share < 0.5 else 'upper'} bound")
    if best.broken > 0.0:
        notes.append(f"no design keeps all constraints: the best one found is off by {best.broken:.3g}")
    if known is not None:
        notes += known.unseen
        scatter, off = float(np.linalg.norm(trial.residuals)), float(np.linalg.norm(error))
        grain = ROUND_OFF * sum(np.linalg.norm(each.values) / each.deviation for each in spec.targets)
        if off > 0.1 * scatter and off > grain:
            size = "larger than" if off > scatter else f"{off / scatter:.2g} of"
            notes.append(f"the runs' own error is {size} the residuals: take a finer step")
        if not known.is_white and scatter > max(10.0 * off, grain):
            notes.append("the residuals are no noise: neighbours are alike, the model lacks something")
    return notes


# --- Several goals ----------------------------------------------------------------------------------------------------
# Designs none of which another design improves in one goal without loss in another (a Pareto front).


#: The number of designs in a generation.
POPULATION = 40
#: The value of each goal for a design that does not run.
WORST = 1e300


@dataclass(frozen=True, eq=False)
class Front:
    """The front of one search: the shares `ends` and the `goals` of designs that run and keep the constraints, and the
    number of `runs`."""

    ends: Annotated[Array, "n d"]
    goals: Annotated[Array, "n g"]
    runs: int


def front_of(wish: Wish, task: SearchTask) -> Front:
    """Return the front of one search. The method is NSGA-II (Deb et al. 2002), with `lacking` as its constraint. A work
    item."""
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)
    sampler = optuna.samplers.NSGAIISampler(population_size=POPULATION, seed=task.seed)
    study = optuna.create_study(directions=["minimize"] * len(wish.goals), sampler=sampler)
    shares: dict[str, Any] = {path: optuna.distributions.FloatDistribution(0.0, 1.0) for path in wish.paths}
    study.enqueue_trial(dict(zip(wish.paths, task.u, strict=True)))
    ends, goals, equal, count = [], [], equalities(wish), EVOLVED * len(wish.paths)
    for first in range(0, count, POPULATION):
        asked = [study.ask(shares) for _ in range(min(POPULATION, count - first))]
        points = [np.array([trial.params[path] for path in wish.paths]) for trial in asked]
        for trial, u, result in zip(asked, points, tried_by_arrays(wish, points), strict=True):
            lack = lacking(result, equal)
            trial.set_constraint("lacking", lack)
            study.tell(trial, result.goals.tolist() if result.runs else [WORST] * len(wish.goals))
            if lack == 0.0:
                ends.append(u)
                goals.append(result.goals)
    reached = np.array(goals).reshape(-1, len(wish.goals))
    best = undominated(reached)
    return Front(np.array(ends).reshape(-1, len(wish.paths))[best], reached[best], count)


def undominated(goals: Array) -> Flags:
    """Return whether each of n designs with goals (n, g) is undominated: no other is as good in all goals and better in
    one."""
    as_good = np.all(goals[:, None] <= goals[None], axis=2)
    better = np.any(goals[:, None] < goals[None], axis=2)
    return np.asarray(~np.any(as_good & better, axis=0))


def merged(fronts: Sequence[Front]) -> tuple[Array, Array]:
    """Return several fronts as one, shares (n, d) and goals (n, g), in the order of the first goal."""
    ends, goals = (np.concatenate([getattr(front, of) for front in fronts]) for of in ("ends", "goals"))
    best = undominated(goals)
    order = np.lexsort(goals[best].T[::-1])
    return ends[best][order], goals[best][order]


def balanced(goals: Array) -> int:
    """Return the number of the design nearest to the best values of all goals, each scaled to its range on the
    front."""
    low, span = goals.min(axis=0), np.ptp(goals, axis=0)
    return int(np.argmin(np.linalg.norm((goals - low) / np.where(span > 0.0, span, 1.0), axis=1)))


# --- How accurate fitted numbers are ----------------------------------------------------------------------------------
# Also the numbers that the measurements do not determine. Both follow from the residuals' slopes.


#: A direction whose singular value is below this part of the largest one has no effect on the data. Slopes by
#: differences of runs are exact to about 1e-8.
UNSEEN = 1e-6
#: Components of an unseen direction below this part of the largest one are round-off. Exponents this near to whole
#: numbers count as whole, if they are at most `LARGEST`.
NOTHING, WHOLE, LARGEST = 1e-3, 1e-2, 6
#: Residuals are no noise where the correlation of neighbours exceeds this number of standard deviations for noise.
WHITE = 3.0


@dataclass(frozen=True, eq=False)
class Knowledge:
    """The accuracy of fitted numbers. `deviation` (d,): their standard deviations from the residuals' scatter, with
    `shift` (d,) included: their change by the error of the run's steps. Both are NaN for numbers that the data do not
    determine. `correlation` (d, d) is that of the numbers. `singular`: singular values of the slopes by shares of the
    ranges, largest first. `unseen`: the undetermined combinations, in words. `scatter`: the residuals' standard
    deviation. `lag`: the correlation of neighbouring residuals, in its standard deviations for noise."""

    deviation: Array
    shift: Array
    correlation: Array
    singular: Array
    unseen: tuple[str, ...]
    scatter: float
    lag: float

    @property
    def is_white(self) -> bool:
        """Whether the residuals look like noise."""
        return abs(self.lag) <= WHITE


def knowledge(paths: Sequence[str], x: Array, width: Array, slopes: Array, residuals: Array, error: Array) -> Knowledge:
    """Return the knowledge from the residuals (m,) at the numbers x (d,) and their slopes (m, d) by shares of the
    ranges `width` (d,). `error` (m,): the differences to the residuals of a run with finer steps."""
    m, d = slopes.shape
    _, singular, directions = np.linalg.svd(slopes, full_matrices=False)
    singular = np.concatenate([singular, np.zeros(d - len(singular))])
    whole = np.linalg.svd(slopes)[2] if m < d else directions
    seen = singular > UNSEEN * max(float(singular[0]), 1e-300)
    freedom = max(m - int(seen.sum()), 1)
    scatter = float(np.sqrt(residuals @ residuals / freedom))
    covariance = (whole[seen].T / singular[seen] ** 2) @ whole[seen] * scatter**2
    deviation = np.sqrt(np.diag(covariance))
    shift = np.abs(whole[seen].T @ (whole[seen] @ (slopes.T @ np.nan_to_num(error)) / singular[seen] ** 2))
    scale = np.where(deviation > 0.0, deviation, 1.0)
    free = np.any(np.abs(whole[~seen]) > NOTHING, axis=0) if (~seen).any() else np.zeros(d, dtype=bool)
    return Knowledge(
        deviation=np.where(free, np.nan, np.hypot(deviation, shift) * width),
        shift=np.where(free, np.nan, shift * width),
        correlation=covariance / np.outer(scale, scale),
        singular=singular,
        unseen=tuple(_in_words(paths, x, width, whole[~seen])),
        scatter=scatter,
        lag=_lag(residuals),
    )


def _lag(residuals: Array) -> float:
    """The correlation of each residual with the next, in its standard deviations for white noise."""
    size = float(residuals @ residuals)
    if len(residuals) < 3 or size == 0.0:
        return 0.0
    return float(residuals[1:] @ residuals[:-1] / size * np.sqrt(len(residuals)))


def _in_words(paths: Sequence[str], x: Array, width: Array, unseen: Array) -> list[str]:
    """Describe the directions (k, d), in shares of the ranges, that the data do not determine. Each is reduced to as
    few numbers as possible: "only mass * length^2 is seen"."""
    names = [column_of(path) for path in paths]
    sentences = []
    for direction in _sparse(unseen):
        involved = np.flatnonzero(np.abs(direction) > NOTHING * np.abs(direction).max())
        if len(involved) == 1:
            sentences.append(f"'{names[involved[0]]}' has no effect on what is matched")
            continue
        exponents = _whole(direction[involved] * width[involved] / x[involved]) if np.all(x[involved] != 0.0) else None
        if exponents is not None:
            sentences.append(
                f"only {_constant_products([names[k] for k in involved], exponents)} is seen, not its factors"
            )
            continue
        shares = direction[involved] * width[involved]
        moved = ", ".join(
            f"{names[k]} {share / np.abs(shares).max():+.3g}" for k, share in zip(involved, shares, strict=True)
        )
        sentences.append(f"nothing changes where these move together: {moved}")
    return sentences


def _sparse(unseen: Array) -> Array:
    """Return directions with many zeros that span the same space (k, d): Gauss-Jordan elimination with complete
    pivoting."""
    rows = unseen.copy()
    for k in range(len(rows)):
        row, column = np.unravel_index(np.argmax(np.abs(rows[k:])), rows[k:].shape)
        rows[[k, k + row]] = rows[[k + row, k]]
        rows[k] /= rows[k, column]
        others = np.arange(len(rows)) != k
        rows[others] -= rows[others, column][:, None] * rows[k]
    return rows


def _whole(powers: Array) -> list[int] | None:
    """Return small whole numbers in the ratios of the relative changes `powers`; None where there are none."""
    for unit in range(1, LARGEST + 1):
        scaled = powers / np.abs(powers).min() * unit
        near = np.round(scaled)
        if np.abs(scaled - near).max() <= WHOLE * unit and np.abs(near).max() <= LARGEST:
            return [int(value) for value in near]
    return None


def _constant_products(names: Sequence[str], exponents: Sequence[int]) -> str:
    """Return, in words, the products a^q / b^p of neighbouring names that relative changes in the ratio of the
    exponents p, q leave constant."""
    products = []
    for (first, p), (second, q) in pairwise(zip(names, exponents, strict=True)):
        divisor = int(np.gcd(p, q))
        a, b = q // divisor, -p // divisor
        if a < 0:
            a, b = -a, -b
        products.append(f"{_power(first, a)}{' * ' if b > 0 else ' / '}{_power(second, abs(b))}")
    return " and ".join(products)


def _power(name: str, exponent: int) -> str:
    return name if exponent == 1 else f"{name}^{exponent}"
