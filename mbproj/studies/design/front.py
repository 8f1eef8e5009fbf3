"""Several goals: designs none of which another design improves in one goal without loss in another (a Pareto front)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.studies.design.searches import EVOLVED, SearchTask, equalities, lacking
from mbproj.studies.design.trial import Wish, tried_by_arrays

#: The number of designs in a generation.
POPULATION = 40
#: The value of each goal for a design that does not run.
WORST = 1e300


def front_of(wish: Wish, task: SearchTask) -> dict[str, Any]:
    """Return the front of one search as plain data for JSON. It has the shares `ends` (n, d) and the `goals` (n, g) of
    designs that run and keep the constraints, and the number of `runs`. The method is NSGA-II (Deb et al. 2002), with
    `lacking` as its constraint. A work item."""
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
        for trial, u, trial_made in zip(asked, points, tried_by_arrays(wish, points), strict=True):
            lack = lacking(trial_made, equal)
            trial.set_constraint("lacking", lack)
            study.tell(trial, trial_made.goals.tolist() if trial_made.runs else [WORST] * len(wish.goals))
            if lack == 0.0:
                ends.append(u.tolist())
                goals.append(trial_made.goals.tolist())
    best = undominated(np.array(goals).reshape(-1, len(wish.goals)))
    kept = np.flatnonzero(best).tolist()
    return {"ends": [ends[k] for k in kept], "goals": [goals[k] for k in kept], "runs": count}


def undominated(goals: Array) -> Flags:
    """Return whether each of n designs with goals (n, g) is undominated: no other is as good in all goals and better in
    one."""
    as_good = np.all(goals[:, None] <= goals[None], axis=2)
    better = np.any(goals[:, None] < goals[None], axis=2)
    return np.asarray(~np.any(as_good & better, axis=0))


def merged(fronts: Sequence[dict[str, Any]], sizes: tuple[int, int]) -> tuple[Array, Array]:
    """Return several fronts as one, shares (n, d) and goals (n, g), in the order of the first goal; `sizes` are d and
    g."""
    ends = np.array([end for front in fronts for end in front["ends"]], dtype=float).reshape(-1, sizes[0])
    goals = np.array([goal for front in fronts for goal in front["goals"]], dtype=float).reshape(-1, sizes[1])
    best = undominated(goals)
    order = np.lexsort(goals[best].T[::-1])
    return ends[best][order], goals[best][order]


def balanced(goals: Array) -> int:
    """Return the number of the design nearest to the best values of all goals, each scaled to its range on the
    front."""
    low, span = goals.min(axis=0), np.ptp(goals, axis=0)
    return int(np.argmin(np.linalg.norm((goals - low) / np.where(span > 0.0, span, 1.0), axis=1)))
