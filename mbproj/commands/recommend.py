"""`mbproj recommend`: the cheapest setting with an error below a goal, as a command line or written into the scene."""

from __future__ import annotations

import shlex
from functools import partial
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.errors import ExitCode, InputError, Place, Problem
from mbproj.commands import study_options
from mbproj.commands.figure_options import plot_option
from mbproj.commands.options import Part, Positive, explained, option, scene_file
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import RECOMMEND

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.scene.scene import Scene
    from mbproj.studies.measure.measurement import Measurement
    from mbproj.studies.recommend import Recommendation

EXAMPLES = (
    (
        "Find the cheapest setting that is right to a millimetre for 2 s.",
        'mbproj recommend five_bar.yaml --error "1 mm" --until 2',
    ),
    (
        "Keep the error of one marker, and write the setting into the scene.",
        "mbproj recommend five_bar.yaml --error 1e-6 --at tip --write",
    ),
)


@explained("recommend", EXAMPLES)
@click.argument("scene", type=scene_file())
@option(
    Part.ACCURACY, "--error", "goal", required=True, type=Positive("m"), metavar="E", help="The largest error allowed."
)
@study_options.at
@study_options.until
@option(
    Part.ACCURACY,
    "--output-step",
    metavar="TIME",
    help="Time between the samples at which the error is measured [default: the scene's].",
)
@study_options.changes
@option(
    Part.OUTPUT,
    "--write",
    is_flag=True,
    help="Write the setting into the scene's simulation block; the rest of the file stays as it is.",
)
@partial(study_options.study, quiet="Print only the command line.")
@plot_option
def command(
    scene: str,
    goal: float,
    at: tuple[str, ...] | None,
    until: float | None,
    output_step: str | None,
    changes: tuple[str, ...],
    write: bool,
    **options: Any,
) -> int:
    """Finds the cheapest integrator and step that keep the error below E.

    For integrators with error control it finds the tolerance. The error is measured against a reference on which two
    other methods agree, and once more in a final run. Prints the command line first. An interrupted search resumes
    where it stopped. Exit code 4: no setting keeps the error to the end; the printed one keeps it up to the time that
    is printed.
    """
    from mbproj.commands.options import parameters
    from mbproj.commands.study import Study
    from mbproj.results.output_files import check_rewritable
    from mbproj.scene.scene import read_scene
    from mbproj.studies.recommend import recommend, write_back

    if write and changes:
        hint = "change the parameter in the scene, and leave out --set"
        raise InputError(Problem("--write does not go with changed parameters", Place("--set"), hint))
    study = Study(options, ("kind", "setting"))
    what = read_scene(scene, parameters(changes), {"output_step": output_step})
    if write:
        check_rewritable(what.path)
    recommendation = study.result(recommend, what, goal, at=at, until=until)
    line = _command_line(what, scene, changes, output_step, recommendation)
    short = (
        f"no setting keeps {goal:g} m until t = {recommendation.wanted:.6g} s: {recommendation.why}; "
        f"this one keeps it until {recommendation.until:.6g} s"
    )
    text, notes = "\n".join([line, *_lines(recommendation)]), [] if recommendation.reached else [short]
    numbers = report_of(
        RECOMMEND,
        recommendation,
        command=line,
        best=_measured(recommendation.best),
        contenders=[_measured(each) for each in recommendation.contenders],
        own=None if recommendation.own is None else _measured(recommendation.own),
        why=recommendation.why or None,
    )
    study.hand_over(recommendation.table, text, numbers, lambda: _page(recommendation, what.title), notes, left=line)
    if write and recommendation.reached:
        click.echo(f"written into {write_back(what, recommendation.settings)}", err=True)
    return ExitCode.DONE if recommendation.reached else ExitCode.CHECK_FAILED


def _command_line(
    scene: Scene, name: str, changes: tuple[str, ...], output_step: str | None, recommendation: Recommendation
) -> str:
    from mbproj.studies.measure.setting import shortest

    words = ["mbproj", "run", name, *(word for change in changes for word in ("--set", change))]
    words += shlex.split(recommendation.setting.command_line(scene.settings))
    settings = recommendation.settings
    assert settings.duration is not None and settings.output_step is not None
    if f"{settings.duration:.12g}" != f"{scene.settings.duration or 0.0:.12g}":
        words += ["--duration", f"{settings.duration:.12g}"]
    if settings.output_step != scene.settings.output_step or output_step:
        words += ["--output-step", output_step or shortest(settings.output_step)]
    return shlex.join(words)


def _measured(best: Measurement) -> dict[str, Any]:
    point = best.worst()
    cost = {"evaluations": best.evaluations, "seconds": best.seconds}
    setting = {name: value for name, value in vars(best.setting).items() if value is not None}
    return {"setting": setting, "point": point, "error": best.error[point], "time": best.when[point], **cost}


def _lines(recommendation: Recommendation) -> list[str]:
    from mbproj.commands.report.text import table

    best, point = recommendation.best, recommendation.best.worst()
    rows: dict[str, str] = {
        "error": f"{best.at():.2g} m at most, of {point} at t = {best.when[point]:.4g} s; "
        f"{recommendation.goal:g} m is asked for, until t = {recommendation.until:.6g} s",
        "reference": f"uncertain by {recommendation.uncertain:.1g} m: {recommendation.method}",
        "checked by": recommendation.check,
        "cost": _cost(best),
    }
    rows |= {f"near it ({place})": _in_words(other) for place, other in enumerate(recommendation.contenders[1:], 1)}
    if recommendation.own is not None:
        rows["the scene's own"] = _in_words(recommendation.own)
    return list(table(rows, "  "))


def _in_words(other: Measurement) -> str:
    return f"{other.setting.label}: {'fails' if other.failure else f'{other.at():.2g} m, {_cost(other)}'}"


def _cost(of: Measurement) -> str:
    return f"{of.evaluations:.0f} evaluations, {1e3 * of.seconds:.3g} ms"


def _page(recommendation: Recommendation, title: str) -> Figure:
    import numpy as np

    from mbproj.show.figures.studies import search_page
    from mbproj.studies.tradeoff import grouped, kind

    costs = np.array([(each.evaluations, each.at()) for each in recommendation.tried])
    families = {name: costs[indices] for name, indices in grouped(recommendation.tried, kind).items()}
    best = recommendation.best.evaluations, recommendation.best.at()
    return search_page(
        families, best, recommendation.goal, recommendation.uncertain, ", ".join([title, recommendation.setting.label])
    )
