"""`mbproj threshold` and `mbproj.threshold`: the violation above which a projection is worth its cost."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from mbproj.commands.declared import Asked, Told, declared, read, study_command, with_values
from mbproj.commands.kinds import Positive, Several
from mbproj.commands.options import Option, Part
from mbproj.commands.study_options import At, EffortOnSetting, Repeat, answer, in_folder

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure
    from typing_extensions import Unpack

    from mbproj.commands.arguments import Quantity, SceneLike
    from mbproj.studies.threshold import ThresholdStudy

#: The columns of the lines for a projection after every step, and for none.
COSTS = ("error", "position_violation", "projections", "cpu_seconds")

Thresholds = Annotated[
    "Sequence[Quantity] | Quantity | None",
    Option(
        Part.PROJECTION,
        "Thresholds to try [default: decades up to a tenth of the mechanism's size].",
        Several(Positive("")),
        "NUMBER,..",
    ),
]


@declared
def threshold(
    scene: SceneLike,
    *,
    thresholds: Thresholds = None,
    at: At = (),
    until: Quantity | None = None,
    repeat: Repeat = 5,
    **effort: Unpack[EffortOnSetting],
) -> ThresholdStudy:
    """Varies the projection threshold on a scene and recommends one.

    Measures error, violation, projections saved and CPU time. Recommends the largest threshold that raises the error by
    at most 10 %, compared with a projection after every step. Other options change the setting that is studied, as for
    `mbproj run`. An interrupted study resumes where it stopped.

    In Python the thresholds are in m or rad, and per s. Raises InputError where the setting has no projection, or does
    not run.
    """
    from mbproj.studies.threshold import threshold_study

    asked = read(threshold, locals())
    asked.until = None if until is None else Positive("s").of(until, "--until")
    return threshold_study(
        asked.scene, **with_values(asked, "thresholds", "at", "until"), repetitions=asked.repeat, **asked.effort
    )


EXAMPLES = (
    ("Find the largest threshold that costs no accuracy.", "mbproj threshold five_bar.yaml --duration 2"),
    ("Try three thresholds only.", "mbproj threshold five_bar.yaml --duration 2 --thresholds 1e-8,1e-6,1e-4"),
)


def _told(asked: Asked[Any], result: ThresholdStudy) -> Told:
    numbers = {
        "recommended": result.recommended,
        "until": float(result.reference.times[-1]),
        "trials": result.table.records,
    }
    return Told(result.table, _report(result), numbers, lambda: _page(result), result.notes)


command = study_command(
    threshold, EXAMPLES, _told, first=("threshold", "projection"), stem="threshold", files=(answer, in_folder)
)


def _report(threshold: ThresholdStudy) -> str:
    from mbproj.commands.report.text import columns, milliseconds, number

    lines = []
    for index, row in enumerate(threshold.table.records):
        name = "none" if index == len(threshold.trials) - 1 else f"{row['threshold']:.0e}" if index else "every step"
        lines.append(
            [
                name + " *" * row["recommended"],
                "failed" if row["failure"] else number(row["error"]),
                *("-" if row["failure"] else number(row[f"{level}_violation"]) for level in ("position", "velocity")),
                number(row["projections"], ".0f"),
                number(100.0 * row["projections_saved"], ".0f"),
                milliseconds(row["cpu_seconds"]),
            ]
        )
    table = columns(["threshold", "error, m", "|C|", "|C'|", "projections", "saved, %", "CPU, ms"], lines)
    return f"{threshold.title}, {threshold.trials[0].setting.label}\n\n{table}\n\n{_verdict(threshold)}"


def _verdict(threshold: ThresholdStudy) -> str:
    from mbproj.studies.measure.setting import shortest

    index = threshold.recommended
    if index is None:
        return "no threshold saves projections without changing the error: project after every step"
    trial, timing, always = threshold.trials[index], threshold.timings[index], threshold.timings[0]
    assert trial.setting.threshold is not None and timing is not None and always is not None  # neither has failed
    part = 1.0 - timing.median / always.median
    clear = timing.median < always.spread[0]
    cost = f"{100 * part:.0f} % of the CPU time" if clear else "no CPU time that could be told from the spread"
    return (
        f"* recommended: --threshold {shortest(trial.setting.threshold)} saves "
        f"{100 * threshold.saved(index):.0f} % of the projections and {cost}, "
        f"with joints open by up to {trial.position_violation:.1e}{_uneven_errors(threshold)}"
    )


def _uneven_errors(threshold: ThresholdStudy) -> str:
    """A note on smaller thresholds with a larger error; "" where there are none."""
    if not threshold.exceeded:
        return ""
    from mbproj.studies.measure.setting import shortest

    smaller = [shortest(threshold.trials[index].setting.threshold or 0.0) for index in threshold.exceeded]
    which = smaller[0] if len(smaller) == 1 else f"{smaller[0]} to {smaller[-1]}"
    return f"; errors do not grow evenly: at {which} they are larger, so the next motion may differ"


def _page(threshold: ThresholdStudy) -> Figure:
    import numpy as np

    from mbproj.show.figures.studies import ThresholdSeries, threshold_page

    table = threshold.table

    def column(name: str) -> Any:
        return np.where(np.isfinite(table[name]), table[name], np.nan)[1:-1]

    always, never = zip(*(table[name][[0, -1]] for name in COSTS), strict=True)
    shown = ThresholdSeries(
        threshold=column("threshold"),
        error=column("error"),
        position_violation=column("position_violation"),
        velocity_violation=column("velocity_violation"),
        projections=column("projections"),
        seconds=column("cpu_seconds"),
        spread=np.column_stack([column("cpu_seconds_lowest"), column("cpu_seconds_highest")]),
        always=always,
        never=never,
        recommended=None
        if threshold.recommended is None
        else threshold.trials[threshold.recommended].setting.threshold,
        floor=float(threshold.reference.uncertainty[-1].max()),
    )
    return threshold_page(shown, f"{threshold.title}; {threshold.trials[0].setting.label}")
