"""`mbproj tradeoff` and `mbproj.tradeoff`: accuracy against cost, measured on a mechanism."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from mbproj.base.registry import FORMULATIONS
from mbproj.commands.declared import Asked, Told, declared, read, study_command, with_values
from mbproj.commands.kinds import OneOf, Positive
from mbproj.commands.options import Option, Part
from mbproj.commands.study_options import At, Effort, Repeat, Until, answer, in_folder, integrators, projections
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import TRADEOFF

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure
    from typing_extensions import Unpack

    from mbproj.commands.arguments import Quantity, SceneLike
    from mbproj.studies.tradeoff import Tradeoff

Projections = Annotated["str | Sequence[str] | None", projections("gpopm,gopm,none,baumgarte")]
Integrators = Annotated["str | Sequence[str] | None", integrators("all that are explicit")]
Formulation = Annotated[
    "str | None",
    Option(Part.INTEGRATION, "Formulation of all settings [default: the scene's].", OneOf(FORMULATIONS)),
]
Longest = Annotated[
    "Quantity", Option(Part.EFFORT, "End a sweep with the first run that takes longer.", Positive("s"), "TIME")
]


@declared
def tradeoff(
    scene: SceneLike,
    *,
    projections: Projections = None,
    integrators: Integrators = None,
    formulation: Formulation = None,
    at: At = (),
    until: Until = None,
    longest: Longest = "0.5 s",
    repeat: Repeat = 5,
    **effort: Unpack[Effort],
) -> Tradeoff:
    """Measures accuracy against cost on a scene over a grid of settings.

    The grid has projections, integrators, steps, tolerances and schedules. Prints the cheapest setting for each
    error; writes all settings as CSV and HDF5, and work-precision diagrams. An interrupted study resumes where it
    stopped.

    In Python the error is the largest up to `until` s (the duration) at the markers `at` (all of them; the bodies'
    centres where the scene has none). A finished study gives the same tables again, unless `fresh`. Raises InputError
    for what cannot be run at all.
    """
    from mbproj.studies.tradeoff import tradeoff as measure_tradeoff

    asked = read(tradeoff, locals())
    names = ("projections", "integrators", "formulation", "at", "until", "longest")
    return measure_tradeoff(asked.scene, **with_values(asked, *names), repetitions=asked.repeat, **asked.effort)


EXAMPLES = (
    ("Draw error against cost for every method.", "mbproj tradeoff five_bar.yaml --until 2 -o tradeoff"),
    (
        "Look at one method and one integrator only.",
        "mbproj tradeoff five_bar.yaml --until 2 --projections gopm --integrators rk4",
    ),
)


def _before(asked: Asked[Any]) -> None:
    from mbproj.studies.tradeoff import KIND

    asked.report.check(_whole(asked), KIND)


def _whole(asked: Asked[Any]) -> Path:
    """The file with the whole grid."""
    return Path(f"{asked.report.stem}.h5")


def _told(asked: Asked[Any], result: Tradeoff) -> Told:
    from mbproj.studies.tradeoff import write_hdf5

    beside = [write_hdf5(_whole(asked), result, force=asked.report.force)]
    numbers = report_of(TRADEOFF, result, until=result.reference.times[-1], trials=result.table.records)
    return Told(result.table, "\n".join(_report(result)), numbers, lambda: _page(result), result.notes, beside)


command = study_command(
    tradeoff,
    EXAMPLES,
    _told,
    first=("setting", "projection"),
    stem="tradeoff",
    files=(answer, in_folder),
    before=_before,
)


def _report(result: Tradeoff) -> Iterator[str]:
    """Yield the tables."""
    import numpy as np

    from mbproj.commands.report.text import columns
    from mbproj.studies.tradeoff import CLOSED

    yield result.line
    yield f"errors of {', '.join(result.points)}; the reference is uncertain by {result.floor:.1e} m"
    errors = result.error[np.isfinite(result.seconds)]
    limits = 10.0 ** np.arange(-14.0, 3.0)[::-1]
    limits = limits[(limits > max(result.floor, errors.min(initial=np.inf))) & (limits <= WORTHLESS * result.size)]
    closed = CLOSED * max(1.0, result.size)
    kinds = {"the cheapest setting for an error": np.inf, f"the same with joints closed to {closed:.0e}": closed}
    shown: list[list[str]] = []
    seen = compared = [_cells(result, index) for index in result.compared]
    for title, most in kinds.items():
        best = {result.cheapest(limit, most): limit for limit in limits}  # of equal settings keep the smallest error
        rows = [[f"<= {limit:.0e}", *_cells(result, index)] for index, limit in best.items() if index is not None]
        if rows and rows != shown:
            shown = rows
            seen = seen + rows
            yield ""
            yield f"{title}:"
            yield columns(["error, m", *HEADINGS], rows)
    if result.compared:
        yield ""
        yield "the same steps with other projections:"
        yield columns(HEADINGS, compared)
    if any(row[-1].endswith(WARNED) for row in seen):
        yield ""
        yield f"{WARNED.strip()} this run notes that the motion may be wrong, by its energy"
    if result.own is not None:
        yield ""
        yield from _scene_setting(result, result.own)


#: Errors above this part of the mechanism's size have no line.
WORTHLESS = 0.1
#: The mark behind a setting whose own run warns of a wrong motion.
WARNED = " (!)"
HEADINGS = ["is", "|C|", "CPU, ms", "spread", "evaluations", "projections", "setting"]


def _cells(result: Tradeoff, index: int) -> list[str]:
    from mbproj.commands.report.text import milliseconds, number

    trial, timing = result.trials[index], result.timings.get(index)
    spread = " to ".join(milliseconds(end) for end in timing.spread) if timing else "-"
    return [
        number(float(result.error[index])),
        number(trial.position_violation),
        milliseconds(result.seconds[index]),
        spread,
        str(trial.counters["evaluations"]),
        str(trial.counters["projections"]),
        trial.setting.label + WARNED * (trial.doubt > 1.0),
    ]


def _scene_setting(result: Tradeoff, index: int) -> Iterator[str]:
    """Yield how far the scene's own setting is from the front."""
    from mbproj.commands.report.text import milliseconds

    trial = result.trials[index]
    if trial.failure is not None:
        yield f"the scene's own setting ({trial.setting.label}) failed: {trial.failure}"
        return
    seconds, error = result.seconds[index], result.error[index]
    yield f"the scene's own setting ({trial.setting.label}): error {error:.1e} m in {milliseconds(seconds)} ms"
    same_error, same_cost = result.cheapest(error), result.most_accurate(seconds)
    if same_error == same_cost == index:
        yield "  nothing that was timed is cheaper and as accurate, or more accurate for the same time"
    if same_error is not None and same_error != index:
        cheaper = result.seconds[same_error]
        yield (
            f"  as accurate for {milliseconds(cheaper)} ms ({seconds / cheaper:.2g} times cheaper): "
            f"{result.trials[same_error].setting.label}"
        )
    if same_cost is not None and same_cost != index:
        better = result.error[same_cost]
        times = f" ({error / better:.2g} times more accurate)" if better > 0.0 else ""
        yield f"  for the same time {better:.1e} m{times}: {result.trials[same_cost].setting.label}"


def _page(result: Tradeoff) -> Figure:
    import numpy as np

    from mbproj.show.figures.studies import Cloud, Diagram, work_precision
    from mbproj.studies.tradeoff import by_integrator, by_projection, studied

    def cloud(indices: list[int]) -> Cloud:
        return Cloud(
            evaluations=np.array([result.trials[i].counters.get("evaluations", np.nan) for i in indices], dtype=float),
            seconds=np.where(np.isfinite(result.seconds[indices]), result.seconds[indices], np.nan),
            error=result.error[indices],
            violation=result.violation[indices],
        )

    front, name = list(result.front), studied(result.trials, result.front)
    return work_precision(
        Diagram(
            by_integrator={label: cloud(indices) for label, indices in by_integrator(result.trials).items()},
            timed=cloud(sorted(result.timings)),
            by_projection={label: cloud(indices) for label, indices in by_projection(result.trials, name).items()},
            integrator=name,
            front=np.column_stack([result.seconds[front], result.error[front]]),
            scene_setting=None
            if result.own is None or not np.isfinite(result.seconds[result.own])
            else (float(result.seconds[result.own]), float(result.error[result.own])),
            floor=result.floor,
            points=", ".join(result.points) if len(result.points) <= 3 else "the worst point",
        ),
        result.title,
    )
