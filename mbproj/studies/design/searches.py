"""The search engines by name, and a search from one start with counted trials."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.optimize import least_squares, minimize

from mbproj.arrays import Array, Flags
from mbproj.dataclass import dataclass
from mbproj.studies.design.slopes.derivative import Counted
from mbproj.studies.design.start import INSIDE, brought_in, value_of, violation
from mbproj.studies.design.trial import Trial, Wish

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
            kept = 0.0 if broken <= np.linalg.norm(self._allowed) else broken
            if self.best is None or (kept, value_of(trial)) < self.best[:2]:
                self.best = kept, value_of(trial), u.copy()
                self.trace.append((self.trials.count, value_of(trial)))
        return trial


def searched(wish: Wish, task: SearchTask) -> dict[str, Any]:
    """Return the result of one search as plain data for JSON: `end` (d,) or None, its `value`, the violation of
    constraints `broken`, the number of `runs`, and the `trace`. `cause`: the reason where nothing was found. A work
    item."""
    watched = Watched(wish)
    start = np.array(task.u)
    first = watched(start)
    inside = brought_in(watched.trials, start)
    if inside is not None:
        ENGINES[task.engine](wish, watched, np.clip(inside, INSIDE, 1.0 - INSIDE), task.seed)
    broken, value, end = watched.best if watched.best is not None else (np.nan, np.nan, None)
    return {
        "start": [*task.u],
        "end": None if end is None else end.tolist(),
        "value": float(value),
        "broken": float(broken),
        "runs": watched.trials.count,
        "trace": [[count, float(reached)] for count, reached in watched.trace],
        "cause": "" if end is not None else first.cause,
    }


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
        own = float(both(v)[0])
        if np.isfinite(own):
            return own
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
