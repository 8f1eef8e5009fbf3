"""tradeoff(): accuracy and cost of settings on a mechanism, measured over a designed grid.

First each integrator is swept with one projection. Integrators that need few evaluations for some error are then swept
with the other projections and schedules. All sweeps run in parallel. Then the settings near the front are timed: alone,
in turn, several times over.

The settings of a ladder differ only in the size of their steps, from coarse to fine. A ladder is swept until a finer
setting brings nothing more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import product
from math import ceil, inf

import numpy as np

from mbproj import registry
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.scene.read import Scene
from mbproj.studies.measure.accuracy import Yardstick, attempt
from mbproj.studies.measure.certain import certain_reference
from mbproj.studies.measure.measurement import MEASUREMENT_RECORDS, Measurement
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting, only_full
from mbproj.studies.measure.spans import divisors, span
from mbproj.studies.measure.timing import REPETITIONS, Timing, kept_timings
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.parallel.resumable import resumable
from mbproj.studies.store import ValueCache
from mbproj.studies.tradeoff.fronts import CLOSED, NONE, projections_at_one_size, to_time
from mbproj.studies.tradeoff.result import Tradeoff

#: Projections of the grid by default: one of each kind that every formulation has.
PROJECTIONS_TRIED = ("gpopm", "gopm", "none", "baumgarte")
#: Sweeps end at an error of this multiple of the reference's uncertainty, or of this part of the mechanism's size.
ABOVE_FLOOR, FINEST = 3.0, 1e-11
#: The fewest and the most steps over the whole span, and the least ratio between neighbouring numbers.
FEWEST, MOST, RATIO = 20, 400_000, 1.4
#: Exponents of the tolerances, from the loosest to the tightest, a decade apart.
TOLERANCES = range(2, 14)
#: Schedules of the projection: every k-th step, or above thresholds that are parts of the mechanism's size.
EVERY = (2, 5, 20)
THRESHOLDS = (1e-3, 1e-6, 1e-9)
#: A sweep ends when this many settings in a row have not brought the error below this part of the best error.
PATIENCE, FALLING = 3, 0.7
#: A ladder is promising where its evaluations are within this factor of the fewest for some error limit. At most
#: `PROMISING` ladders are chosen. The limits are a decade apart.
NEAR_IN_EVALUATIONS, PROMISING = 1.5, 2


def tradeoff(
    scene: Scene,
    *,
    projections: Sequence[str] = PROJECTIONS_TRIED,
    integrators: Sequence[str] | None = None,
    formulation: str | None = None,
    at: Sequence[str] = (),
    until: float | None = None,
    longest: float = 0.5,
    repetitions: int = REPETITIONS,
    processes: Where = None,
    fresh: bool = False,
    tell: Tell = silent,
) -> Tradeoff:
    """Measures accuracy against cost over `projections`, `integrators` (by default the explicit ones), steps,
    tolerances and schedules.

    The error is the largest up to `until` s (the duration) at the markers `at` (all of them; the bodies' centres where
    the scene has none). A sweep ends with a run that takes more than `longest` s. An interrupted study resumes, and a
    finished one gives the same tables again, unless `fresh`. Raises InputError for what cannot be run at all.
    """
    mechanism, own = Mechanism.to_choose_for(scene), Setting.of(scene.settings)
    points = tuple(mechanism.points[k] for k in mechanism.columns(at))
    names = tuple(integrators or registry.explicit_integrators())
    for projection, name in product(projections, names):
        free = name == registry.AUTOMATIC  # raises InputError for an unknown name
        Setting(projection, name, None if free else 1.0, 1e-3 if free else None).settings(1.0, 1.0)
    # all runs are in one formulation: seconds of different formulations are not comparable
    own = replace(own, formulation=formulation or ("full" if only_full(projections) else own.formulation))
    base = replace(own, step=None, tolerance=None)
    truth, notes = certain_reference(mechanism, span(scene, until), own, names, tell)
    goal = max(ABOVE_FLOOR * float(truth.uncertainty[-1].max()), FINEST * mechanism.system.length)
    track = SweepSetup(Yardstick(scene, truth), goal, longest)
    what = {
        "study": "tradeoff",
        **mechanism.identity,
        "base": asdict(base),
        "until": float(truth.times[-1]),
        "projections": list(projections),
        "integrators": list(names),
        "longest": longest,
        "repetitions": repetitions,
    }
    kept = ValueCache(what, fresh, (Timing, *MEASUREMENT_RECORDS))
    mine = own if own.step or own.tolerance else None
    trials = _accuracy(track, base, mine, projections, names, kept, processes, tell)
    numbers = {trial.setting: index for index, trial in enumerate(trials)}
    if mine is not None and mine not in numbers:
        numbers[mine] = len(trials)
        trials += attempt(mechanism, [mine], truth, kept, 1)
    errors = np.array([trial.at(points) for trial in trials])
    compared = projections_at_one_size(trials, errors, mine)
    closed = CLOSED * max(1.0, mechanism.system.length)
    wanted = to_time(trials, errors, closed, [*compared, *([numbers[mine]] if mine is not None else [])])
    timings = kept_timings(
        kept, mechanism, [trials[index].setting for index in wanted], float(truth.times[-1]), repetitions, tell
    )
    return Tradeoff(
        title=scene.title,
        size=mechanism.system.length,
        points=points,
        trials=tuple(trials),
        timings=dict(zip(wanted, timings, strict=True)),
        own=None if mine is None else numbers[mine],
        compared=tuple(compared),
        reference=truth,
        notes=tuple(notes),
    )


def _accuracy(
    track: SweepSetup,
    base: Setting,
    own: Setting | None,
    projections: Sequence[str],
    names: Sequence[str],
    kept: ValueCache,
    processes: Where,
    tell: Tell,
) -> list[Measurement]:
    """The trials of the grid: first all integrators, then projections and schedules of the promising ladders and the
    scene's own."""
    methods = [
        replace(base.projected_by(name), every=1, threshold=None, formulation=base.formulation) for name in projections
    ]
    ladders = integrator_ladders(methods[0], names)
    first = sweeps(track, ladders, kept, processes, "integrators", tell)
    others: list[Ladder] = []
    constrained = track.yardstick.mechanism.system.joints.size > 0
    owned = [each for each in ladders if own is not None and each.holds(own)]
    for ladder in dict.fromkeys((*promising(ladders, first), *owned)) if constrained else ():
        others += projection_ladders(ladder, methods[1:])
        if registry.PROJECTIONS[methods[0].projection].corrects:
            others += schedule_ladders(ladder, track.yardstick.mechanism.system.length)
    second = sweeps(track, others, kept, processes, "projections and schedules", tell)
    unique = {trial.setting: trial for swept in (*first, *second) for trial in swept}
    return list(unique.values())


def promising(ladders: Sequence[Ladder], swept: Sequence[Sequence[Measurement]]) -> list[Ladder]:
    """The ladders that need about the fewest evaluations for most of the error limits, which are a decade apart."""
    flat = [(number, trial) for number, trials in enumerate(swept) for trial in trials if np.isfinite(trial.at())]
    errors = np.array([trial.at() for _, trial in flat])
    evaluations = np.array([trial.counters["evaluations"] for _, trial in flat], dtype=float)
    owner = np.array([number for number, _ in flat])
    if not len(flat):
        return []
    wins = np.zeros(len(ladders))
    lowest, highest = np.log10(np.array([errors.min(), errors.max()]).clip(NONE))
    for limit in 10.0 ** np.arange(np.ceil(lowest), highest + 1.0):
        able = np.where(errors <= limit, evaluations, inf)
        best = np.array([able[owner == number].min(initial=inf) for number in range(len(ladders))])
        wins += best <= NEAR_IN_EVALUATIONS * best.min()
    chosen = [number for number in np.argsort(-wins, kind="stable") if wins[number]][:PROMISING]
    return [ladders[number] for number in sorted(chosen)]


@dataclass(frozen=True)
class Ladder:
    """Settings that add to `base` a step or, with `by_tolerance`, a tolerance."""

    base: Setting
    by_tolerance: bool

    @property
    def label(self) -> str:
        """A short label, e.g. "rk4, gpopm every 5 steps" or "dop853 to a tolerance, none"."""
        base, method = self.base, f"{self.base.integrator}{' to a tolerance' if self.by_tolerance else ''}"
        return f"{method}, {base.schedule}"

    def holds(self, setting: Setting) -> bool:
        """Whether a setting has the integrator and the kind of step of this ladder."""
        by_tolerance = setting.tolerance is not None
        return (setting.integrator, by_tolerance) == (self.base.integrator, self.by_tolerance)

    def sizes(self, times: Array) -> list[Setting]:
        """The settings of the ladder from coarse to fine: all tolerances, or steps that meet some of `times`."""
        if self.by_tolerance:
            return [replace(self.base, step=None, tolerance=float(f"1e-{k}")) for k in TOLERANCES]
        until = float(times[-1])
        return [replace(self.base, step=until / steps, tolerance=None) for steps in step_numbers(len(times) - 1)]


def step_numbers(intervals: int) -> list[int]:
    """Numbers of steps that divide `intervals` or are multiples of it, in ratios of at least `RATIO`."""
    chosen: list[int] = []
    for part in divisors(intervals):
        if part >= (RATIO * chosen[-1] if chosen else FEWEST):
            chosen.append(part)
    while (number := intervals * (max(2, ceil(RATIO * chosen[-1] / intervals)) if chosen else 2)) <= MOST:
        chosen.append(number)
    return chosen


def integrator_ladders(base: Setting, names: Sequence[str]) -> list[Ladder]:
    """A ladder with fixed steps for each integrator, and one with tolerances where the integrator estimates its
    error."""
    ladders = []
    for name in names:
        if name != registry.AUTOMATIC:
            ladders.append(Ladder(_sizeless(base, integrator=name), by_tolerance=False))
        if registry.is_embedded(name):
            ladders.append(Ladder(_sizeless(base, integrator=name), by_tolerance=True))
    return ladders


def projection_ladders(ladder: Ladder, methods: Sequence[Setting]) -> list[Ladder]:
    """The ladder with other projections: those of the settings `methods`."""
    base = ladder.base
    return [
        Ladder(_sizeless(method, integrator=base.integrator, formulation=base.formulation), ladder.by_tolerance)
        for method in methods
    ]


def schedule_ladders(ladder: Ladder, size: float) -> list[Ladder]:
    """The ladder with an energy row, and with less frequent projections. `size` (m) is the mechanism's."""
    often = [replace(ladder.base, every=k) for k in EVERY]
    above = [replace(ladder.base, threshold=float(f"{part * size:.1g}")) for part in THRESHOLDS]
    kept = [] if ladder.base.energy_row else [replace(ladder.base, energy_row=True)]
    return [Ladder(base, ladder.by_tolerance) for base in (*kept, *often, *above)]


def _sizeless(setting: Setting, **changes: str) -> Setting:
    return replace(setting, step=None, tolerance=None, **changes)  # type: ignore[arg-type]


@dataclass(frozen=True)
class SweepSetup:
    """The common data of all sweeps: the yardstick, the error (m) at which a sweep may end, and the seconds of a run
    from which on no finer one is tried."""

    yardstick: Yardstick
    goal: float
    longest: float


def sweep(track: SweepSetup, ladder: Ladder) -> list[Measurement]:
    """Run a ladder's settings from coarse to fine and return their measurements."""
    trials: list[Measurement] = []
    best, stuck = float("inf"), 0
    for setting in ladder.sizes(track.yardstick.reference.times):
        trials.append(track.yardstick.measure(setting))
        reached = trials[-1].at()
        if reached < float("inf"):
            stuck = 0 if reached < FALLING * best else stuck + 1
            best = min(best, reached)
            if best <= track.goal or trials[-1].seconds > track.longest or stuck >= PATIENCE:
                break
    return trials


def sweeps(
    track: SweepSetup, ladders: Sequence[Ladder], kept: ValueCache, processes: Where, phase: str, tell: Tell
) -> list[list[Measurement]]:
    """Run the sweeps of all ladders in parallel; return them in the order of `ladders`. Sweeps in the store `kept` are
    not run again."""
    keys = [f"sweep {ladder.base.command_line()}{' by tolerance' * ladder.by_tolerance}" for ladder in ladders]
    records = resumable(sweep, track, dict(zip(keys, ladders, strict=True)), kept, processes, phase, tell)
    return [records[key] for key in keys]
