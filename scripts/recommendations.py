"""Whether recommendations hold: ten mechanisms, three errors each.

    python scripts/recommendations.py [MECHANISM ...]

For each, the recommended setting runs afresh and is held against a reference that the recommender did not see: DOP853
with error control at 1e-14, whose own uncertainty is its distance to the same at 1e-13. Then a dense grid (every
integrator, steps and tolerances between those that the search tries, five ways to enforce the constraints) is searched
for something that keeps the error for fewer evaluations; of what closes the joints after every step, which is all that
is recommended, what comes nearest is timed against the recommendation in turn.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mbproj.base.mechanisms_folder import mechanism
from mbproj.base.registry import explicit_integrators, integrators
from mbproj.scene.scene import read_scene
from mbproj.studies.measure.measurement import Measurement, time_settings
from mbproj.studies.measure.reference import Reference, sampled
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Mechanism, solve
from mbproj.studies.recommend import Bench, Recommendation, families, recommend, with_closed_joints

#: Mechanisms, and until when (s): their duration, or less where the motion is chaotic.
CASES = {
    "delta_robot": None,
    "double_pendulum": None,
    "five_bar": 5.0,
    "free_body": None,
    "heavy_top": None,
    "hooke_shaft": None,
    "physical_pendulum": None,
    "planar_four_bar": None,
    "spatial_four_bar": None,
    "spatial_slider_crank": None,
}
ERRORS = (1e-3, 1e-6, 1e-9)
WAYS = (
    Setting("gpopm"),
    Setting("gpopm", every=5),
    Setting("gopm"),
    Setting("none"),
    Setting("baumgarte", gains=(25.0, 25.0)),
)
#: How dense the grid is, in cost and in tolerance, and how many of what it finds are timed, how often.
PACE, A_DECADE, TIMED, REPETITIONS = 1.07, 11, 4, 7


def main(names: list[str]) -> None:
    """Prints the table; the exit code is 1 where a promise is broken."""
    heading = (
        "mechanism",
        "E, m",
        "recommended",
        "true error",
        "± m",
        "evaluations",
        "over the fewest",
        "time over the shortest",
        "over the fewest, drifting joints too",
    )
    print(" | ".join(heading), flush=True)
    broken = 0
    for name in names or CASES:
        scene = read_scene(mechanism(name))
        unseen, grid = Unseen(Mechanism.of(scene), CASES.get(name)), dict[Setting, Measurement]()
        for goal in ERRORS:
            found = recommend(scene, goal, until=CASES.get(name))
            bench = Bench(unseen.mechanism, unseen.reference, goal, tuple(range(len(unseen.mechanism.points))))
            fresh = bench.fresh(found.setting, Mechanism.of(scene))
            rivals = [one for one in unseen.grid(bench, 1.2 * fresh.evaluations, grid) if one.at() <= goal]
            closed = [one for one in rivals if with_closed_joints(one.setting) == one.setting]
            fewest, drifting = (
                min([fresh.evaluations, *(one.evaluations for one in some)]) for some in (closed, rivals)
            )
            clock = clock_ratio(bench, found, closed)
            holds = fresh.at() <= goal + found.uncertain and found.reached
            broken += not holds or fresh.evaluations > 1.5 * drifting or clock > 1.5
            print(
                f"{name} | {goal:.0e} | {found.setting.label} | {fresh.at():.2e} | {bench.uncertainty[-1]:.0e} | "
                f"{fresh.evaluations:.0f} | {fresh.evaluations / fewest:.2f} | {clock:.2f} | "
                f"{fresh.evaluations / drifting:.2f}"
                f"{'' if holds else ' | DOES NOT HOLD'}",
                flush=True,
            )
    sys.exit(1 if broken else 0)


class Unseen:
    """A mechanism with a reference of its own, and a grid of settings around any recommendation."""

    def __init__(self, ready: Mechanism, until: float | None) -> None:
        times = sampled(ready.scene, until)
        tight, loose = (solve(ready, Setting(integrator="dop853", tolerance=tol), times) for tol in (1e-14, 1e-13))
        apart = np.linalg.norm(tight.position - loose.position, axis=2)
        self.mechanism, self._costs = ready, dict[tuple[str, float], float]()
        self.reference = Reference(
            ready.points, times, tight.position, tight.velocity, np.maximum.accumulate(apart, axis=0), "1e-14", "1e-13"
        )

    def grid(self, bench: Bench, budget: float, known: dict[Setting, Measurement]) -> Iterator[Measurement]:
        """Measurements of all settings of the grid that take at most `budget` evaluations."""
        for setting in self.settings(budget):
            if setting not in known:
                known[setting] = bench.fresh(setting, self.mechanism)
            one = known[setting]
            if one.evaluations <= budget:
                yield one

    def settings(self, budget: float) -> Iterator[Setting]:
        """The grid; settings with error control that are beyond the budget are among them."""
        interval, intervals = float(self.reference.times[1]), len(self.reference.times) - 1
        for way in WAYS:
            for family in families(way, interval):
                fineness = 1
                while not family.by_error and family.fixed_cost(fineness, intervals) <= budget:
                    yield family.setting(fineness)
                    fineness = max(fineness + 1, int(PACE * fineness))
            for name in explicit_integrators():
                exponents = np.arange(-1.0, -13.0, -1.0 / A_DECADE) if integrators()[name].embedded else ()
                for exponent in exponents:
                    tolerance = float(f"{10.0**exponent:.3g}")
                    if self.cost(name, tolerance) > 1.2 * budget:
                        break
                    yield replace(way, integrator=name, tolerance=tolerance)

    def cost(self, integrator: str, tolerance: float) -> float:
        """Evaluations of a run with error control, projected by GPOPM."""
        key = (integrator, tolerance)
        if key not in self._costs:
            solution = solve(self.mechanism, Setting("gpopm", integrator, tolerance=tolerance), self.reference.times)
            self._costs[key] = float("inf") if solution.report is None else solution.report.counters["evaluations"]
        return self._costs[key]


def clock_ratio(bench: Bench, found: Recommendation, rivals: list[Measurement]) -> float:
    """The recommendation's time over the fastest rival's, each the median of runs in turn."""
    chosen = [found.setting, *(one.setting for one in sorted(rivals, key=lambda each: each.evaluations)[:TIMED])]
    medians = [each.median for each in time_settings(bench.mechanism, chosen, bench.reference.times, REPETITIONS)]
    return medians[0] / min(medians)


if __name__ == "__main__":
    main(sys.argv[1:])
