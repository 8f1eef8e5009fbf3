"""The designed grid: ladders of settings that differ only in the size of their steps, from coarse to fine. A ladder is
swept until a finer setting brings nothing more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.registry import AUTOMATIC, is_embedded
from mbproj.studies.measure.accuracy import Yardstick
from mbproj.studies.measure.measurement import Measurement
from mbproj.studies.measure.setting import Setting, shortest
from mbproj.studies.measure.spans import divisors
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell
from mbproj.studies.parallel.resumable import resumable
from mbproj.studies.store import ValueCache

#: The fewest and the most steps over the whole span, and the least ratio between neighbouring numbers.
FEWEST, MOST, RATIO = 20, 400_000, 1.4
#: Exponents of the tolerances, from the loosest to the tightest, a decade apart.
TOLERANCES = range(2, 14)
#: Schedules of the projection: every k-th step, or above thresholds that are parts of the mechanism's size.
EVERY = (2, 5, 20)
THRESHOLDS = (1e-3, 1e-6, 1e-9)
#: A sweep ends when this many settings in a row have not brought the error below this part of the best error.
PATIENCE, FALLING = 3, 0.7


@dataclass(frozen=True)
class Ladder:
    """Settings that add to `base` a step or, with `by_tolerance`, a tolerance."""

    base: Setting
    by_tolerance: bool

    @property
    def label(self) -> str:
        """A short label, e.g. "rk4, gpopm every 5 steps" or "dop853 to a tolerance, none"."""
        base, method = self.base, f"{self.base.integrator}{' to a tolerance' if self.by_tolerance else ''}"
        return f"{method}, {schedule_label(base)}"

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


def schedule_label(setting: Setting) -> str:
    """The projection of a setting and its schedule."""
    text = setting.projection + " with energy row" * setting.energy_row
    if setting.every != 1:
        text += f" every {setting.every} steps"
    return text if setting.threshold is None else f"{text} above {shortest(setting.threshold)}"


def step_numbers(intervals: int) -> list[int]:
    """Numbers of steps that divide `intervals` or are multiples of it, in ratios of at least `RATIO`."""
    parts = [part for part in divisors(intervals) if part >= FEWEST]
    numbers = [*parts, *(intervals * k for k in range(2, MOST // intervals + 1))]
    chosen: list[int] = []
    for number in numbers:
        if not chosen or number >= RATIO * chosen[-1]:
            chosen.append(number)
    return chosen


def integrator_ladders(base: Setting, names: Sequence[str]) -> list[Ladder]:
    """A ladder with fixed steps for each integrator, and one with tolerances where the integrator estimates its
    error."""
    found = []
    for name in names:
        if name != AUTOMATIC:
            found.append(Ladder(_sizeless(base, integrator=name), by_tolerance=False))
        if is_embedded(name):
            found.append(Ladder(_sizeless(base, integrator=name), by_tolerance=True))
    return found


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
    found = resumable(sweep, track, dict(zip(keys, ladders, strict=True)), kept, processes, phase, tell)
    return [found[key] for key in keys]
