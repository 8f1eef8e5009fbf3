"""`mbproj stability`: the values of one quantity at which each method holds, degrades and fails."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.errors import Place, placed_at
from mbproj.commands import study_options
from mbproj.commands.options import Part, Positive, explained, one_of, option, overrides, parameters, scene_options_of
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import STABILITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.studies.stability import MethodTrack, StabilityMap


def _quantities() -> Collection[str]:
    from mbproj.studies.stability import QUANTITIES

    return QUANTITIES


EXAMPLES = (
    ("Find the step at which each method fails.", "mbproj stability five_bar.yaml --vary step --duration 2"),
    (
        "Compare two methods as the masses become unequal.",
        "mbproj stability five_bar.yaml --vary mass-ratio --projections gopm,gpopm",
    ),
)


@explained("stability", EXAMPLES)
@scene_options_of("stability")
@option(
    Part.WHAT,
    "--vary",
    required=True,
    metavar="QUANTITY",
    shell_complete=one_of(_quantities),
    help="step, mass-ratio, inertia-ratio, speed, length-scale, stiffness, damping, baumgarte-gain, penalty, duration, "
    "or parameters.NAME of the scene.",
)
@study_options.projections("none,baumgarte,gopm,gpopm")
@option(
    Part.WHAT, "--from", "low", type=Positive(""), metavar="NUMBER", help="Lowest value [default: by the quantity]."
)
@option(
    Part.WHAT, "--to", "high", type=Positive(""), metavar="NUMBER", help="Highest value [default: by the quantity]."
)
@option(Part.WHAT, "--points", default=25, show_default=True, type=click.IntRange(2), help="Number of values.")
@option(
    Part.ACCURACY,
    "--closed",
    type=Positive(""),
    metavar="NUMBER",
    help="Largest violation of a run that holds [default: 1e-6 of the mechanism's length, or rad].",
)
@option(
    Part.ACCURACY,
    "--energy",
    type=Positive(""),
    metavar="NUMBER",
    help="Largest relative energy error of a run that holds [default: 0.01].",
)
@study_options.study
@study_options.in_folder
def command(
    scene: str,
    settings: tuple[str, ...],
    vary: str,
    projections: tuple[str, ...] | None,
    closed: float | None,
    energy: float | None,
    **options: Any,
) -> None:
    """Varies one quantity of SCENE and finds where each method fails.

    Finds each limit by bisection, and names the first bad time and joint beyond it. For a parameter, it also finds
    where small motions about the equilibrium begin to grow, with sampled controllers too. Writes a figure and all
    points as CSV. Other options change the setting that is studied, as for `mbproj run`. An interrupted study resumes
    where it stopped.
    """
    from mbproj.commands.study import Study
    from mbproj.scene.scene import read_scene
    from mbproj.studies.stability import Limits, quantity_named, stability

    what = read_scene(scene, parameters(settings), overrides(options))
    with placed_at(Place("--vary")):
        quantity_named(vary)
    study = Study(options, ("projection", vary), f"{Path(scene).stem}-stability-{vary}")
    given = {name: value for name, value in (("closed", closed), ("energy", energy)) if value is not None}
    with placed_at(Place("--vary")):
        bounds = study.result(
            stability,
            what,
            vary,
            projections=projections,
            limits=Limits(**given),
            **{name: options[name] for name in ("low", "high", "points")},
        )
    methods = {track.method: track for track in bounds.tracks}
    numbers = report_of(STABILITY, bounds, setting=_setting(bounds), methods=methods)
    study.hand_over(bounds.table, _report(bounds), numbers, lambda: _page(bounds))


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
    own = bounds.span.own if judged and bounds.span.low <= bounds.span.own <= bounds.span.high else None
    shown = Map(
        strips,
        f"{bounds.vary}{unit}",
        own,
        bounds.analytic,
        bounds.limits.closed if judged else None,
        bounds.limits.energy if judged else None,
    )
    return stability_page(shown, f"{bounds.title}; {_setting(bounds)}; runs that stop are not drawn")
