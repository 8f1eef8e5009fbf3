"""stability(): a map of where each method holds, degrades and fails while one quantity varies. Bisection finds the
limits."""

from __future__ import annotations

from bisect import insort
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from math import exp, log

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem, choose_from
from mbproj.integrate.steppers.stability_region import real_axis_limit
from mbproj.integrate.steppers.tableau import tableau_of
from mbproj.registry import PROJECTIONS, WHERE_STIFF, integrators, with_fixed_steps
from mbproj.results.views.table import Table, Tabled
from mbproj.scene.read import Scene, SceneText
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import sample_times, solve
from mbproj.studies.measure.spans import span as until_of
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.parallel.resumable import resumable
from mbproj.studies.stability.judge import (
    FAILS,
    NAME,
    Limits,
    StabilityPoint,
    Subject,
    cause_of,
    judged,
    judged_in_blocks,
    small_motions,
)
from mbproj.studies.stability.judge import PRECISION as PRECISE
from mbproj.studies.stability.quantities import PARAMETER, ValueSpan, VariedQuantity, quantity_named
from mbproj.studies.store import ValueCache
from mbproj.thresholds import THRESHOLDS

#: The methods that are tried by default, and the number of grid values.
METHODS, POINTS = ("none", "baumgarte", "gopm", "gpopm"), 25
#: The relative precision of a limit, and the most changes of state that are bisected for a method.
PRECISION, CHANGES = 0.005, 6
#: The number of steps for a scene that gives neither a step nor a tolerance.
DEFAULT_STEPS = 1000


@dataclass(frozen=True)
class StateChange:
    """A change of state between two points, `below` and `above`, with nearly the same value."""

    below: StabilityPoint
    above: StabilityPoint

    @property
    def value(self) -> float:
        """The limit: the geometric mean of the two values."""
        return float(np.sqrt(self.below.value * self.above.value))


@dataclass(frozen=True)
class MethodTrack:
    """The result of one method: its points by increasing value, from the grid and from bisection."""

    method: str
    points: tuple[StabilityPoint, ...]

    @property
    def changes(self) -> tuple[StateChange, ...]:
        """The changes of state between neighbours."""
        return tuple(StateChange(*pair) for pair in _changes(self.points))

    @property
    def digits(self) -> int:
        """The number of digits to which a change is known: more for small motions, which are bisected further."""
        return 8 if self.method == NAME else 4


@dataclass(frozen=True)
class StabilityMap(Tabled):
    """The tracks of all methods over the quantity `vary`. `span` has the range of values and the scene's own value.
    `analytic` is the limit from theory, where there is one; `setting` is the common setting of all runs."""

    title: str
    vary: str
    unit: str
    span: ValueSpan
    tracks: tuple[MethodTrack, ...]
    setting: Setting
    until: float
    limits: Limits
    analytic: float | None
    length: float

    @property
    def table(self) -> Table:
        """A table with a row for each method and value. Its column of values is named after the quantity."""
        names = {"value": self.vary, "closure": "open_by", "energy": "energy_off_by", "time": "first_bad_time"}
        return Table.of(
            {"projection": track.method} | {names.get(name, name): value for name, value in vars(point).items()}
            for track in self.tracks
            for point in track.points
        )

    @property
    def line(self) -> str:
        """A line with the quantity and the limits of each method."""
        parts = [
            f"{track.method} {', '.join(f'{change.value:.{track.digits}g}' for change in track.changes) or 'none'}"
            for track in self.tracks
        ]
        return f"{self.title}: {self.vary}{f' ({self.unit})' if self.unit else ''}; limits: {'; '.join(parts)}"

    __repr__ = Tabled.__repr__


def stability(
    scene: Scene,
    vary: str,
    *,
    projections: Sequence[str] | None = None,
    low: float | None = None,
    high: float | None = None,
    points: int = POINTS,
    until: float | None = None,
    limits: Limits | None = None,
    processes: Where = None,
    fresh: bool = False,
    tell: Tell = silent,
) -> StabilityMap:
    """Vary `vary` (a name of `QUANTITIES`, or `parameters.NAME`) from `low` to `high` for each projection method. For a
    parameter, the first track is that of small motions.

    Raises InputError where the scene does not have this quantity, or a projection method does not depend on it."""
    quantity, mechanism = quantity_named(vary), Mechanism.to_choose_for(scene)
    names = _methods(quantity, projections)
    subject = Subject(
        scene, _with_fixed_step(mechanism, until_of(scene, until)), until_of(scene, until), limits or Limits()
    )
    own_span = quantity.span(subject)
    whole = ValueSpan(low or own_span.low, own_span.own, high or own_span.high)
    if not 0.0 < whole.low < whole.high:
        message = f"there is nothing between {whole.low:g} and {whole.high:g}"
        raise InputError(Problem(message, hint="let --from be below --to"))
    _refuse_endless(quantity.changed(subject, whole.low), quantity.changed(subject, whole.high))
    what = {
        "study": "stability",
        **mechanism.identity,
        "vary": vary,
        "setting": subject.setting.command_line(),
        "until": subject.until,
        "limits": vars(subject.limits),
        "span": vars(whole),
        "points": points,
    }
    kept = ValueCache(what, fresh, (StabilityPoint,))
    grid = values(whole, points)
    subjects = {name: _with_method(subject, name) for name in names}
    if quantity.of_forces and not integrators()[subject.setting.integrator].implicit:
        subjects |= _implicit(subjects)
    if quantity.of_motion:
        subjects = {NAME: replace(subject, is_linear=True), **subjects}
    walked = resumable(_points_of, (vary, grid), subjects, kept, processes, "methods", tell)
    analytic = real_axis_limit(tableau_of(subject.setting.integrator)) if quantity.option == "gains" else np.inf
    step = subject.setting.step or 1.0
    return StabilityMap(
        title=scene.title,
        vary=vary,
        unit=quantity.unit or _unit_of(scene, vary),
        span=whole,
        tracks=tuple(MethodTrack(*each) for each in walked.items()),
        setting=subject.setting,
        until=subject.until,
        limits=subject.limits,
        analytic=analytic / step if np.isfinite(analytic) else None,
        length=mechanism.system.length,
    )


def _unit_of(scene: Scene, vary: str) -> str:
    """The SI unit of a parameter; "" where the scene does not tell it."""
    if not vary.startswith(PARAMETER):
        return ""
    return SceneText(scene.text, "scene", scene.path).units().get(tuple(vary.split(".", 1)), "")


def values(span: ValueSpan, points: int) -> list[float]:
    """The values of a span, evenly spaced in their logarithms, with the scene's own value among them."""
    grid = np.geomspace(span.low, span.high, points)
    nearest = int(np.argmin(np.abs(np.log(grid / span.own))))
    if span.low <= span.own <= span.high:
        grid[nearest] = span.own
    return [float(value) for value in grid]


def _methods(quantity: VariedQuantity, projections: Sequence[str] | None) -> tuple[str, ...]:
    """The methods to try. Raises InputError for an unknown method, or one without the option that is varied."""
    option = quantity.option
    able = [name for name, entry in PROJECTIONS.items() if not option or option in entry.options]
    for name in projections or ():
        if name not in PROJECTIONS:
            raise InputError(Problem(f"unknown projection method '{name}'", hint=choose_from(name, PROJECTIONS)))
        if name not in able:
            raise InputError(Problem(f"'{name}' has no '{option}' to vary", hint=f"these have: {', '.join(able)}"))
    return tuple(dict.fromkeys(projections or (able if option else METHODS)))


def _refuse_endless(*ends: Subject) -> None:
    """Raises InputError where a run at an end of the span would take too many steps."""
    for subject in ends:
        step, most = subject.setting.step, THRESHOLDS.most_steps
        if step is not None and subject.until / step > most:
            message = f"a run of {subject.until:.6g} s in steps of {step:.6g} s would take {subject.until / step:.3g}"
            raise InputError(Problem(f"{message} steps, and at most {most:g} are made", hint="vary it less"))


def _with_fixed_step(mechanism: Mechanism, until: float) -> Setting:
    """The scene's setting with a fixed step: its own, or the mean step that its tolerance leads to."""
    own = Setting.of(mechanism.scene.settings)
    if own.step is not None:
        return own
    steps = DEFAULT_STEPS
    if own.tolerance is not None:
        report = solve(mechanism, own, sample_times(until, 1)).report
        steps = report.counters["steps"] if report is not None else steps
    return replace(own, integrator=with_fixed_steps(own.integrator), step=until / steps, tolerance=None)


def _with_method(subject: Subject, name: str) -> Subject:
    """Return the subject with another projection method, without the options that this method does not take."""
    own = subject.setting
    taken = {option: getattr(own, option) for option in PROJECTIONS[name].options}
    return replace(subject, setting=replace(own, **{"alpha": None, "gains": None, **taken}, projection=name))


def _implicit(subjects: Mapping[str, Subject]) -> dict[str, Subject]:
    """The subjects with an implicit integrator, for each projection that corrects and that the kernel has."""
    return {
        f"{name}, {WHERE_STIFF}": replace(each, setting=replace(each.setting, integrator=WHERE_STIFF))
        for name, each in subjects.items()
        if PROJECTIONS[name].corrects and PROJECTIONS[name].compiled
    }


def _points_of(shared: tuple[str, list[float]], subject: Subject) -> tuple[StabilityPoint, ...]:
    """The points of a method: the grid, and then bisections between neighbours with different states."""
    vary, grid = shared
    quantity, precision = quantity_named(vary), PRECISE if subject.is_linear else PRECISION
    judge = small_motions if subject.is_linear else quantity.run

    def at(value: float) -> StabilityPoint:
        try:
            changed = quantity.changed(subject, value)
        except InputError as error:
            return StabilityPoint(value, FAILS, np.nan, np.nan, 0.0, None, cause_of(error), ended=False)
        return judge(changed, value)

    known = judged_in_blocks(partial(quantity.changed, subject), grid) if judge is judged else {}
    points = [known.get(number) or at(value) for number, value in enumerate(grid)]
    for _ in range(CHANGES):
        wide = [pair for pair in _changes(points) if _gap(*pair) > precision]
        if not wide:
            break
        below, above = wide[0]
        while _gap(below, above) > precision:
            middle = at(exp(0.5 * (log(below.value) + log(above.value))))
            insort(points, middle, key=lambda point: point.value)
            below, above = (middle, above) if middle.state == below.state else (below, middle)
    return tuple(points)


def _gap(below: StabilityPoint, above: StabilityPoint) -> float:
    """The distance of two values in their logarithms."""
    return log(above.value / below.value)


def _changes(points: Sequence[StabilityPoint]) -> list[tuple[StabilityPoint, StabilityPoint]]:
    """The pairs of neighbours with different states."""
    return [(one, two) for one, two in pairwise(points) if one.state != two.state]
