"""`mbproj recommend` and `mbproj.recommend`: the cheapest setting with an error below a goal."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import click

from mbproj.base.errors import ExitCode, InputError, Place, Problem
from mbproj.commands.declared import Asked, Told, declared, read, study_command
from mbproj.commands.figure_options import plot_option
from mbproj.commands.kinds import Positive
from mbproj.commands.options import Option, Part, option
from mbproj.commands.study_options import At, Effort, Until, answer
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import RECOMMEND

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from typing_extensions import Unpack

    from mbproj.commands.arguments import Quantity, SceneLike
    from mbproj.scene.scene import Scene
    from mbproj.studies.measure.measurement import Measurement
    from mbproj.studies.recommend import Recommendation

Error = Annotated["Quantity", Option(Part.ACCURACY, "The largest error allowed.", Positive("m"), "E")]
OutputStep = Annotated[
    "Quantity | None",
    Option(
        Part.ACCURACY, "Time between the samples at which the error is measured [default: the scene's].", None, "TIME"
    ),
]


@declared
def recommend(
    scene: SceneLike,
    error: Error,
    at: At = (),
    until: Until = None,
    timed: bool = True,
    *,
    output_step: OutputStep = None,
    **effort: Unpack[Effort],
) -> Recommendation:
    """Finds the cheapest integrator and step that keep the error below a goal.

    For integrators with error control it finds the tolerance. The error is measured against a reference on which two
    other methods agree, and once more in a final run. Prints the command line first. An interrupted search resumes
    where it stopped. Exit code 4: no setting keeps the error to the end; the printed one keeps it up to the time that
    is printed.

    In Python `recommendation.settings` are the settings to run with. Without `timed` the fewest evaluations decide.
    Raises InputError for an unknown name or a missing duration, `mbproj.studies.recommend.Unreachable` where no
    setting keeps the error at all.
    """
    from mbproj.studies.recommend import recommend as cheapest_setting

    asked = read(recommend, locals())
    return cheapest_setting(asked.scene, asked.error, asked.at, asked.until, timed, **asked.effort)


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
WRITE = option(
    Part.OUTPUT,
    "--write",
    is_flag=True,
    help="Write the setting into the scene's simulation block; the rest of the file stays as it is.",
)


def _refuse(options: Mapping[str, Any]) -> None:
    if options["write"] and options["changes"]:
        hint = "change the parameter in the scene, and leave out --set"
        raise InputError(Problem("--write does not go with changed parameters", Place("--set"), hint))


def _before(asked: Asked[Any]) -> None:
    from mbproj.results.output_files import check_rewritable

    if asked.typed["write"]:
        check_rewritable(asked.scene.path)


def _told(asked: Asked[Any], recommendation: Recommendation) -> Told:
    line = _command_line(asked.scene, asked.path, asked.typed["changes"], asked.typed["output_step"], recommendation)
    short = (
        f"no setting keeps {recommendation.goal:g} m until t = {recommendation.wanted:.6g} s: {recommendation.why}; "
        f"this one keeps it until {recommendation.until:.6g} s"
    )
    numbers = report_of(
        RECOMMEND,
        recommendation,
        command=line,
        best=_measured(recommendation.best),
        contenders=[_measured(each) for each in recommendation.contenders],
        own=None if recommendation.own is None else _measured(recommendation.own),
        why=recommendation.why or None,
    )
    return Told(
        recommendation.table,
        "\n".join([line, *_lines(recommendation)]),
        numbers,
        lambda: _page(recommendation, asked.scene.title),
        [] if recommendation.reached else [short],
        left=line,
        code=ExitCode.DONE if recommendation.reached else ExitCode.CHECK_FAILED,
    )


def _after(asked: Asked[Any], recommendation: Recommendation) -> None:
    from mbproj.studies.recommend import write_back

    if asked.typed["write"] and recommendation.reached:
        click.echo(f"written into {write_back(asked.scene, recommendation.settings)}", err=True)


command = study_command(
    recommend,
    EXAMPLES,
    _told,
    first=("kind", "setting"),
    files=(WRITE, partial(answer, quiet="Print only the command line."), plot_option),
    refuse=_refuse,
    before=_before,
    after=_after,
)


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
