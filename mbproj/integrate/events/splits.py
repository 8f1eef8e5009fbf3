"""Splits of fixed steps: a short move or pulse between two events may be narrower than a few steps, or than one.

A method evaluates a function of time at its stages. Over such a stretch the quadrature Σ b_i f(c_i) by the given steps
may be wrong. Then the stretch is divided into as many equal parts as the quadrature needs. The grid of steps does not
change.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.functions.program_set import ProgramSet
from mbproj.integrate.events.time_events import OF_MOTIONS, Stretch, stretches
from mbproj.model.system import System
from mbproj.registry import with_fixed_steps
from mbproj.scene.records import Settings
from mbproj.scene.sampling import output_interval
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from mbproj.integrate.steppers.implicit_tableau import ImplicitTableau
    from mbproj.integrate.steppers.tableau import Tableau

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
    from mbproj.integrate.steppers.tableau import tableau_of

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
