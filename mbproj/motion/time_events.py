"""Times that a run's steps must not pass over: kinks, jumps and narrow features of the scene's functions of time, those
inside force laws too, and `break_times`.
"""

from __future__ import annotations

import dataclasses
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.registry import with_fixed_steps
from mbproj.base.settings import Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.program_set import ProgramSet
from mbproj.model.channels import ElementStates, Motions
from mbproj.model.forces import Forces
from mbproj.model.system import Names, System
from mbproj.motion.steppers.tableau import Tableau
from mbproj.scene.sampling import SampleTimes, output_every, output_interval, output_times, whole_steps

if TYPE_CHECKING:
    from mbproj.motion.steppers.tableau import ImplicitTableau, Tableau


#: The number of orders that count: for forces the value, for motions also velocity and acceleration.
OF_FORCES, OF_MOTIONS = 1, 3
#: The kind of events with direction 1 where contacts begin to share a force arbitrarily, and -1 where that ends.
SHARED = "shared"
#: The kind of events at stops where the motion begins to depend on how they share a force.
DECIDES = "share decides"


@dataclasses.dataclass(frozen=True, order=True)
class Event:
    """An event: its time, its owner ("force 'push'", "motion 'm'", "stop 's'", "break_times"), and its kind.

    `direction` is 1 or -1, and 0 for events in time. An impact has an `impulse` in N s or N m s and a loss of `energy`
    in J."""

    time: float
    name: str
    kind: str
    direction: int = 0
    impulse: float = 0.0
    energy: float = 0.0


class Stretch(NamedTuple):
    """A time between two neighbouring events of a function, or from its start to the first one. `parts`: the parts of
    the function that depend on time alone; `orders`: the number of orders that count."""

    owner: str
    parts: tuple[ProgramSet, ...]
    orders: int
    low: float
    high: float


def time_events(
    system: System, start: float, end: float, interval: float, asked: tuple[float, ...] = ()
) -> tuple[Event, ...]:
    """Return the events from `start` to `end`, in order: of each function the first `most_kinks` kinks, and the narrow
    features. `interval` is the time between two samples, in s. A later end adds events and changes none."""
    events, _ = _of_scene(system.forces, system.motions, system.states, system.names, start, end, interval, 0.0)
    return tuple(sorted({*events, *(Event(t, "break_times", "asked for") for t in asked if start < t < end)}))


def stretches(system: System, start: float, end: float, interval: float, longest: float) -> tuple[Stretch, ...]:
    """Return the stretches shorter than `longest` that begin between `start` and `end`; they may end later. A later end
    adds some and changes none."""
    return _of_scene(system.forces, system.motions, system.states, system.names, start, end, interval, longest)[1]


def events_of(system: System, start: float, settings: Settings) -> tuple[Event, ...]:
    """Return the time events of a run from `start`."""
    assert settings.duration is not None
    return time_events(system, start, start + settings.duration, output_interval(settings), settings.break_times)


def crowded(events: tuple[Event, ...]) -> tuple[str, ...]:
    """Return the owners with so many kinks that further ones are ignored."""
    names = [event.name for event in events]
    return tuple(name for name in dict.fromkeys(names) if names.count(name) >= THRESHOLDS.most_kinks)


@lru_cache(maxsize=256)
def _of_scene(
    forces: Forces,
    motions: Motions,
    states: ElementStates,
    names: Names,
    start: float,
    end: float,
    interval: float,
    longest: float,
) -> tuple[tuple[Event, ...], tuple[Stretch, ...]]:
    """Return events and stretches of a scene. The result is cached: studies run one mechanism many times."""
    events: set[Event] = set()
    narrow: list[Stretch] = []
    sets = (
        (forces.programs, tuple(f"force '{name}'" for name in forces.program_owners), OF_FORCES),
        (states.programs, tuple(f"state '{name}'" for name in names.states), OF_FORCES),
        (motions.programs, tuple(f"motion '{name}'" for name in names.motions), OF_MOTIONS),
    )
    for programs, owners, orders in sets:
        seen: dict[tuple[bytes, bytes], list[tuple[float, str]]] = {}
        for index, owner in enumerate(owners):
            from mbproj.functions.program_set import time_parts

            parts, marks = time_parts(programs, index), {start}
            for part in parts:
                code = slice(*part.start)
                same = part.op[code].tobytes(), part.operand[code].tobytes()
                if same not in seen:
                    seen[same] = list(_of_function(part, start, end, interval, orders, longest))
                events |= {Event(t, owner, kind) for t, kind in seen[same] if kind and t <= end}
                marks |= {t for t, _ in seen[same]}
            pairs = pairwise(sorted(marks))
            narrow += [
                Stretch(owner, parts, orders, *pair) for pair in pairs if pair[0] < end and pair[1] - pair[0] < longest
            ]
    return tuple(sorted(events)), tuple(narrow)


def _of_function(
    part: ProgramSet, start: float, end: float, interval: float, orders: int, longest: float
) -> Iterator[tuple[float, str]]:
    """The times and kinds of events, also beyond the end. The kind is "" at the end of a feature that a kink begins."""
    from mbproj.functions.kinks import features, kinks, look_windows

    counted = 0
    for low, high in look_windows(start, end + longest, interval):
        beside = THRESHOLDS.round_off_grains * float(np.spacing(max(abs(low), abs(high))))
        finite = [kink for kink in kinks(part, 0, low, high) if _goes_on(part, kink.t, beside, start, end)]
        for feature in features(part, 0, low, high, finite, orders):
            if feature.after_kink:
                yield feature.end, ""
            else:
                yield feature.start, "narrow feature begins"
                yield feature.end, "narrow feature ends"
        for kink in finite[: THRESHOLDS.most_kinks - counted]:
            yield kink.t, "jump" if any(kink.jump[:orders]) else "kink"
        counted += len(finite)
        if counted >= THRESHOLDS.most_kinks:
            return


def _goes_on(part: ProgramSet, t: float, beside: float, start: float, end: float) -> bool:
    """Whether a function has finite values at both sides of t. Without them the run stops there, with an error that
    names the function."""
    from mbproj.functions.series import run, time_series

    times = np.clip([t - beside, t + beside], start, end)
    return bool(np.all(np.isfinite(run(part, 0, [time_series(times)])[0])))


# --- Splits of fixed steps --------------------------------------------------------------------------------------------
# A short move or pulse between two events may be narrower than a few steps, or than one.
# A method evaluates a function of time at its stages. Over such a stretch the quadrature Σ b_i f(c_i) by the given
# steps may be wrong. Then the stretch is divided into as many equal parts as the quadrature needs. The grid of steps
# does not change.


Method: TypeAlias = "Tableau | ImplicitTableau"


@dataclass(frozen=True)
class Split:
    """Equal `parts` from `low` to `high`; `resolved`: whether they resolve the function of `owner` there."""

    owner: str
    low: float
    high: float
    parts: int
    resolved: bool

    @property
    def times(self) -> list[float]:
        """The times at which the parts begin and end."""
        inner = (self.low + k / self.parts * (self.high - self.low) for k in range(1, self.parts))
        return [self.low, *inner, self.high]


def splits_of(system: System, start: float, settings: Settings) -> tuple[Split, ...]:
    """Return the splits of a run with fixed steps from `start`; none with error control."""
    if settings.step is None or (system.forces.is_empty and not system.driven):
        return ()
    assert settings.duration is not None
    end, integrator = start + settings.duration, with_fixed_steps(settings.integrator)
    return _of_system(system, start, end, output_interval(settings), settings.step, integrator)


@lru_cache(maxsize=16)
def _of_system(
    system: System, start: float, end: float, interval: float, step: float, integrator: str
) -> tuple[Split, ...]:
    """Return the splits of a run. The result is cached: studies run one mechanism many times."""
    from mbproj.motion.steppers.tableau import tableau_of

    splits, method = [], tableau_of(integrator)
    for stretch in stretches(system, start, end, interval, THRESHOLDS.split_parts * step):
        grain = float(np.spacing(max(abs(stretch.low), abs(stretch.high))))
        most = int((stretch.high - stretch.low) / (2.0 * THRESHOLDS.round_off_grains * grain))
        if most < 1:  # both ends are one event
            continue
        needed, resolved = _parts_needed(stretch, step, method, THRESHOLDS.closed_grains * grain)
        if needed > 1:
            parts = min(needed, most)
            splits.append(Split(stretch.owner, stretch.low, stretch.high, parts, resolved and parts == needed))
    return tuple(splits)


def unresolved(splits: tuple[Split, ...]) -> tuple[str, ...]:
    """Return the stretches that the parts do not resolve: "force 'push', 0.0001 s wide at 0.4567 s"."""
    left = [each for each in splits if not each.resolved]
    return tuple(f"{each.owner}, {each.high - each.low:.2g} s wide at {each.low:.6g} s" for each in left)


def _parts_needed(stretch: Stretch, step: float, method: Method, aside: float) -> tuple[int, bool]:
    """Return the number of parts of the stretch, 1 where the given steps suffice; and whether that number is enough."""
    at_hand, fewest = max(int((stretch.high - stretch.low) / step), 1), THRESHOLDS.split_parts
    if _resolve(at_hand, -(-fewest // at_hand), stretch, method, aside):
        return 1, True
    count = max(fewest, min(_parts_by_motion(stretch, aside), 2**THRESHOLDS.most_halvings))
    while not _resolve(count, 2, stretch, method, aside):
        if count >= 2**THRESHOLDS.most_halvings:
            return count, False
        count *= 2
    return count, True


def _parts_by_motion(stretch: Stretch, aside: float) -> int:
    """Return the number of parts in which no driven coordinate moves by more than 1 rad or 1 m; 0 for forces, and where
    a function has no value."""
    if stretch.orders < OF_MOTIONS:
        return 0
    from mbproj.functions.series import run, time_series

    ends = time_series(np.array([stretch.low + aside, stretch.high - aside]))
    with np.errstate(all="ignore"):
        moved = sum(float(np.abs(np.diff(run(part, 0, [ends])[0])).sum()) for part in stretch.parts)
    return int(np.ceil(moved / THRESHOLDS.widest_turn)) if np.isfinite(moved) else 0


def _resolve(count: int, finer: int, stretch: Stretch, method: Method, aside: float) -> bool:
    """Whether `count` steps integrate the functions as accurately as steps that are `finer` times shorter. They are
    compared step by step, as a step of the grid may end between them. True also where a function has no value: the run
    stops there."""
    with np.errstate(all="ignore"):
        for part in stretch.parts:
            coarse, _ = _moments(part, stretch, count, method, aside)
            fine, size = _moments(part, stretch, count * finer, method, aside)
            off = np.abs(coarse - fine.reshape(*coarse.shape, finer).sum(axis=-1)).sum(axis=-1).max(axis=0)
            round_off = THRESHOLDS.same_written * size[0] / (stretch.high - stretch.low) ** np.arange(len(size))
            if np.any(off > THRESHOLDS.split_to * size + round_off):
                return False
    return True


def _moments(part: ProgramSet, stretch: Stretch, count: int, method: Method, aside: float) -> tuple[Array, Array]:
    """Return ∫f dθ and, for methods of order 3, ∫θ f dθ over each of `count` steps, θ from 0 to 1 over the stretch.

    f stands for the function and the derivatives that count, (1 or 2, orders, count). The second result is ∫|f| dθ over
    all steps, (orders,)."""
    from mbproj.functions.series import run, time_series

    low, high, stages = stretch.low, stretch.high, len(method.b)
    theta = np.add.outer(np.arange(count), method.c[:stages]) / count
    times = np.clip(low + theta * (high - low), low + aside, high - aside)
    series = run(part, 0, [time_series(times)])[: stretch.orders]
    values = np.array([np.broadcast_to(each, times.shape) for each in series])
    moments = np.array([values @ method.b, (theta * values) @ method.b]) / count
    return moments[: 1 + (method.order > 2)], (np.abs(values) @ np.abs(method.b)).sum(axis=-1) / count


# --- Breaks: the times at which steps end -----------------------------------------------------------------------------
# Steps before and after evaluate functions of time from their own side.


class Break(NamedTuple):
    """A time at which a step ends. Before it functions of time are evaluated no later than `left`, after it no earlier
    than `right`. `actions`: the controllers' actions at this time, in order. `asks`: whether the run waits there for
    inputs."""

    time: float
    left: float
    right: float
    actions: tuple[int, ...] = ()
    asks: bool = False


@dataclass(frozen=True)
class TimeWindow:
    """The window between two breaks, in which functions of time are evaluated."""

    first: float = -np.inf
    last: float = np.inf

    def clip(self, t: float) -> float:
        """Return the time within the window at which functions are evaluated for t."""
        return min(max(t, self.first), self.last)


def breaks_of(system: System, start: float, settings: Settings, asks: float | None = None) -> tuple[Break, ...]:
    """Return the breaks of a run, in their order.

    They are its events, the points that split its fixed steps, and the actions of controllers. With a period `asks`
    there are also the times at which the run waits. A break at the start or the end selects the side for evaluations
    there."""
    assert settings.duration is not None
    breaks: list[Break] = []
    grid = None
    interval, end = output_interval(settings), start + settings.duration
    times = {event.time for event in events_of(system, start, settings)}
    inner = {t for split in splits_of(system, start, settings) for t in split.times if start < t < end}
    slack = THRESHOLDS.round_off_grains * float(np.spacing(max(abs(start), interval)))
    acts = system.actions.instants(start, end, slack) if system.actions.size else {}
    waits = set((start + np.arange(int((end - start) / asks * (1.0 + 1e-12)) + 1) * asks).tolist()) if asks else set()
    for time in sorted(times | inner | acts.keys() | waits):
        grain = float(np.spacing(max(abs(start), abs(time), interval)))
        actions, waiting = acts.get(time, ()), time in waits
        grid = _grid(settings, start) if grid is None else grid
        left, right = time - THRESHOLDS.closed_grains * grain, time + THRESHOLDS.closed_grains * grain
        if breaks and time - breaks[-1].time <= THRESHOLDS.round_off_grains * grain:
            together = tuple(sorted({*breaks[-1].actions, *actions}))
            right, waiting = max(right, breaks[-1].right), waiting or breaks[-1].asks
            breaks[-1] = breaks[-1]._replace(right=right, actions=together, asks=waiting)
        else:
            at = _snapped(time, grid, settings, THRESHOLDS.round_off_grains * grain)
            breaks.append(Break(at, left, right, actions, waiting))
    return tuple(breaks)


def _grid(settings: Settings, start: float) -> Sequence[float]:
    """Return the times of samples for a run with error control; for fixed steps, the start."""
    return output_times(settings, start) if settings.step is None else [start]


def _snapped(t: float, grid: Sequence[float], settings: Settings, slack: float) -> float:
    """Return t, or the time of a step or a sample within `slack` of it."""
    if settings.step is not None:
        assert settings.duration is not None
        near = [grid[0] + round((t - grid[0]) / settings.step) * settings.step, grid[0] + settings.duration]
    else:
        at = bisect_left(grid, t)
        near = [*grid[max(at - 1, 0) : at + 1]]
    closest = min(near, key=lambda time: abs(time - t))
    return closest if abs(closest - t) <= slack else t


class BreakCursor:
    """The place of one run among its breaks: the number of breaks passed. `interval`: the time between two samples, in
    s."""

    def __init__(self, breaks: Sequence[Break], start: float, interval: float) -> None:
        self._breaks, self._passed, self._interval, self._acted = breaks, 0, interval, 0
        self.pass_break(start)

    @property
    def next(self) -> float:
        """The time at which the next step must end; infinite where no break follows."""
        return self._breaks[self._passed].time if self._passed < len(self._breaks) else np.inf

    @property
    def passed(self) -> int:
        """The number of breaks passed."""
        return self._passed

    @property
    def window(self) -> TimeWindow:
        """The window from the last break to the next one."""
        before, after = self._breaks[: self._passed][-1:], self._breaks[self._passed :][:1]
        return TimeWindow(before[0].right if before else -np.inf, after[0].left if after else np.inf)

    def is_at(self, t: float) -> bool:
        """Whether a step that ends at t ends at the next break."""
        return bool(self.next <= t + self._beside(t))

    def cuts(self, t: float) -> bool:
        """Whether a step to t would pass over the next break."""
        return bool(self.next < t - self._beside(t))

    def pass_break(self, t: float) -> None:
        """Mark the breaks up to t as passed."""
        while self.is_at(t):
            self._passed += 1

    def take_actions(self) -> list[int]:
        """Return the controllers' actions at breaks that were passed since the last call."""
        actions = [action for each in self._breaks[self._acted : self._passed] for action in each.actions]
        self._acted = self._passed
        return actions

    def _beside(self, t: float) -> float:
        """Return the tolerance within which a time counts as t, in s."""
        return float(16.0 * np.finfo(float).eps * max(abs(t), self._interval))


# --- The leg of a run -------------------------------------------------------------------------------------------------
# The times of breaks, steps and samples; and their form in the kernel's classes.


@dataclass(frozen=True)
class Leg:
    """A run from `start` over `duration`, in s.

    Fixed steps: `count` steps of size `step`, of which every `every`-th is recorded. With error control: samples at
    `times`. `interval` is the time between two samples."""

    start: float
    duration: float
    interval: float
    breaks: tuple[Break, ...]
    step: float | None = None
    count: int = 0
    every: int = 1
    times: SampleTimes | None = None

    @classmethod
    def whole(cls, system: System, settings: Settings, start: float, asks: float | None = None) -> Leg:
        """Return the leg of a run with these settings. With a period `asks` in s the run waits at its start, and once
        in each period."""
        assert settings.duration is not None  # settings_to_run requires it
        duration, interval = settings.duration, output_interval(settings)
        breaks = breaks_of(system, start, settings, asks)
        if settings.step is None:
            return cls(start, duration, interval, breaks, times=output_times(settings, start))
        steps, every = whole_steps(settings), output_every(settings)
        return cls(start, duration, interval, breaks, settings.step, steps, every)

    @property
    def without_samples(self) -> Leg:
        """This leg with error control, and with samples only at its start and end."""
        return replace(self, times=SampleTimes(self.start, self.end, self.start, self.duration))

    @property
    def end(self) -> float:
        """The time at which the leg ends, in s."""
        return self.start + self.duration


def kernel_tableau(core: ModuleType, tableau: Tableau | ImplicitTableau, *, kinematic: bool) -> Any:
    """Return a tableau as the kernel's class."""
    return core.Tableau(tableau=tableau, kinematic=kinematic)


def kernel_breaks(leg: Leg) -> list[tuple[Any, ...]]:
    """Return the times at which steps end, as the kernel takes them."""
    return [(*each[:3], list(each.actions), each.asks) for each in leg.breaks]


def kernel_steps(core: ModuleType, settings: Settings, leg: Leg) -> Any:
    """Return the steps of a run as the kernel's class: fixed, or by error control."""
    breaks = kernel_breaks(leg)
    if leg.step is not None:
        return core.Steps.fixed(leg.start, leg.duration, leg.step, leg.count, leg.every, breaks)
    assert leg.times is not None
    samples = (leg.times.origin, leg.times.interval, leg.times.offset, leg.times.number)
    return core.Steps.by_error(leg.start, leg.duration, settings.tolerance, samples, breaks)
