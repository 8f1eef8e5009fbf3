"""`mbproj stability` and `mbproj.stability`: the values of one quantity at which each method holds, degrades and
fails."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Annotated, Any

from mbproj.base.errors import Place, placed_at
from mbproj.commands.declared import Asked, Told, declared, read, study_command, with_values
from mbproj.commands.kinds import Count, Positive
from mbproj.commands.options import Option, Part, one_of
from mbproj.commands.study_options import EffortOnSetting, answer, in_folder, projections
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import STABILITY

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure
    from typing_extensions import Unpack

    from mbproj.commands.arguments import Quantity, SceneLike
    from mbproj.studies.stability import Limits, MethodTrack, StabilityMap


def _quantities() -> Collection[str]:
    from mbproj.studies.stability import QUANTITIES

    return QUANTITIES


Vary = Annotated[
    str,
    Option(
        Part.WHAT,
        "step, mass-ratio, inertia-ratio, speed, length-scale, stiffness, damping, baumgarte-gain, penalty, duration, "
        "or parameters.NAME of the scene.",
        None,
        "QUANTITY",
        complete=one_of(_quantities),
    ),
]
Projections = Annotated["str | Sequence[str] | None", projections("none,baumgarte,gopm,gpopm")]
Low = Annotated[
    "Quantity | None",
    Option(Part.WHAT, "Lowest value [default: by the quantity].", None, "NUMBER", names=("--from",)),
]
High = Annotated[
    "Quantity | None",
    Option(Part.WHAT, "Highest value [default: by the quantity].", None, "NUMBER", names=("--to",)),
]
Points = Annotated[int, Option(Part.WHAT, "Number of values.", Count(2))]
Closed = Annotated[
    "Quantity | None",
    Option(
        Part.ACCURACY,
        "Largest violation of a run that holds [default: 1e-6 of the mechanism's length, or rad].",
        Positive(""),
        "NUMBER",
    ),
]
Energy = Annotated[
    "Quantity | None",
    Option(Part.ACCURACY, "Largest relative energy error of a run that holds [default: 0.01].", Positive(""), "NUMBER"),
]


@declared
def stability(
    scene: SceneLike,
    vary: Vary,
    *,
    projections: Projections = None,
    low: Low = None,
    high: High = None,
    points: Points = 25,
    until: Quantity | None = None,
    closed: Closed = None,
    energy: Energy = None,
    limits: Limits | None = None,
    **effort: Unpack[EffortOnSetting],
) -> StabilityMap:
    """Varies one quantity of a scene and finds where each method fails.

    Finds each limit by bisection, and names the first bad time and joint beyond it. For a parameter, it also finds
    where small motions about the equilibrium begin to grow, with sampled controllers too. Writes a figure and all
    points as CSV. Other options change the setting that is studied, as for `mbproj run`. An interrupted study resumes
    where it stopped.

    In Python `limits` has both `closed` and `energy`. Raises InputError where the scene does not have this quantity,
    or a method does not depend on it.
    """
    from mbproj.studies.stability import Limits, quantity_named
    from mbproj.studies.stability import stability as map_stability

    with placed_at(Place("--vary")):
        unit = quantity_named(vary).unit
    asked = read(stability, locals())
    asked.low, asked.high = (
        None if value is None else Positive(unit).of(value, option)
        for value, option in ((asked.low, "--from"), (asked.high, "--to"))
    )
    asked.until = None if until is None else Positive("s").of(until, "--until")
    bounds = with_values(asked, "closed", "energy")
    with placed_at(Place("--vary")):
        return map_stability(
            asked.scene,
            vary,
            **with_values(asked, "projections", "low", "high", "points", "until"),
            limits=Limits(**bounds) if bounds else limits,
            **asked.effort,
        )


EXAMPLES = (
    ("Find the step at which each method fails.", "mbproj stability five_bar.yaml --vary step --duration 2"),
    (
        "Compare two methods as the masses become unequal.",
        "mbproj stability five_bar.yaml --vary mass-ratio --projections gopm,gpopm",
    ),
)


def _told(asked: Asked[Any], bounds: StabilityMap) -> Told:
    methods = {track.method: track for track in bounds.tracks}
    numbers = report_of(STABILITY, bounds, setting=_setting(bounds), methods=methods)
    return Told(bounds.table, _report(bounds), numbers, lambda: _page(bounds))


command = study_command(
    stability,
    EXAMPLES,
    _told,
    first=("projection", "{vary}"),
    stem="stability-{vary}",
    files=(answer, in_folder),
)


def _report(bounds: StabilityMap) -> str:
    from mbproj.commands.report.text import columns

    lines = [line for track in bounds.tracks for line in _intervals(track)]
    table = columns(["method", "from", "to", "state", "first bad"], [line[:-1] for line in lines]).splitlines()
    rows = [f"{row}  {line[-1]}".rstrip() for row, line in zip(table[1:], lines, strict=True)]
    aligned = "\n".join([table[0], *rows])
    unit = f" ({bounds.unit})" if bounds.unit else ""
    head = f"{bounds.title}: {bounds.vary}{unit}; its own {bounds.span.own:.4g}; {_setting(bounds)}"
    theory = "" if bounds.analytic is None else f"\n\n{_theory(bounds)}"
    return f"{head}\n\n{aligned}{theory}"


def _setting(bounds: StabilityMap) -> str:
    """The setting that all runs share, in words."""
    step = [] if bounds.vary == "step" else [f"h = {bounds.setting.step:.4g} s"]
    until = [] if bounds.vary in ("duration", "baumgarte-gain") else [f"{bounds.until:g} s"]
    return ", ".join([bounds.setting.integrator, *step, *until])


def _intervals(track: MethodTrack) -> list[list[str]]:
    """A row for each interval of one state: from, to, and the first fault, at the end that is nearer to where the
    method holds."""
    edges = [track.points[0].value, *(change.value for change in track.changes), track.points[-1].value]
    starts = [track.points[0], *(change.above for change in track.changes)]
    ends = [*(change.below for change in track.changes), track.points[-1]]
    lines = []
    for number, (first, last) in enumerate(zip(starts, ends, strict=True)):
        shown = last if number == 0 and len(starts) > 1 else first
        time = "-" if shown.time is None or first.state == "holds" else f"{shown.time:.3g} s"
        why = "" if first.state == "holds" else _shortened(shown.cause, shown.joint)
        ends_at = (f"{value:.{track.digits}g}" for value in edges[number : number + 2])
        lines.append([track.method if number == 0 else "", *ends_at, first.state, time, why])
    return lines


def _shortened(cause: str, joint: str | None) -> str:
    text = cause if joint is None or joint in cause else f"{joint}: {cause}"
    return text if len(text) <= 70 else text[:67] + "..."


def _theory(bounds: StabilityMap) -> str:
    assert bounds.analytic is not None and bounds.setting.step is not None
    name, product = bounds.setting.integrator, bounds.analytic * bounds.setting.step
    return (
        f"theory: α h = {product:.4g}, the real stability limit of {name}, α = {bounds.analytic:.4g} 1/s at this step, "
        "for a mechanism that hardly moves in a step"
    )


def _page(bounds: StabilityMap) -> Figure:
    import numpy as np

    from mbproj.show.figures.studies import Map, Strip, stability_page

    strips = [
        Strip(
            track.method,
            np.array([point.value for point in track.points]),
            tuple(point.state for point in track.points),
            np.array([point.closure if point.ended else np.nan for point in track.points], dtype=float),
            np.array([point.energy if point.ended else np.nan for point in track.points], dtype=float),
        )
        for track in bounds.tracks
    ]
    unit = f" ({bounds.unit})" if bounds.unit else ""
    judged = bounds.analytic is None
    scene_value = bounds.span.own if judged and bounds.span.low <= bounds.span.own <= bounds.span.high else None
    shown = Map(
        strips,
        f"{bounds.vary}{unit}",
        scene_value,
        bounds.analytic,
        bounds.limits.closed if judged else None,
        bounds.limits.energy if judged else None,
    )
    return stability_page(shown, f"{bounds.title}; {_setting(bounds)}; runs that stop are not drawn")
