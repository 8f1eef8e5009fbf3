"""`mbproj compare` and `mbproj.compare`: chosen methods on one mechanism, in one table and one page of figures."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from mbproj.base.registry import FORMULATIONS
from mbproj.commands.declared import Asked, Told, declared, read, study_command, with_values
from mbproj.commands.kinds import Names, Pair, Positive, Several, TruthValues
from mbproj.commands.options import Option, Part, some_of
from mbproj.commands.study_options import Effort, Repeat, Until, answer, in_folder, integrators, projections

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure
    from typing_extensions import Unpack

    from mbproj.commands.arguments import Quantity, SceneLike
    from mbproj.studies.compare import Comparison

Projections = Annotated["str | Sequence[str] | None", projections("none,baumgarte,gopm,gpopm")]
Integrators = Annotated["str | Sequence[str] | None", integrators("the scene's")]
Steps = Annotated[
    "Sequence[Quantity] | Quantity | None",
    Option(Part.INTEGRATION, "Fixed steps [default: the scene's].", Several(Positive("s")), "TIME,.."),
]
Tolerances = Annotated[
    "Sequence[Quantity] | Quantity | None",
    Option(
        Part.INTEGRATION,
        "Error tolerances, for integrators with an error estimate.",
        Several(Positive("")),
        "NUMBER,..",
    ),
]
Formulations = Annotated[
    "str | Sequence[str] | None",
    Option(
        Part.INTEGRATION,
        "Formulations to compare; with several, cost is counted in factorisations, not in time.",
        Names(),
        "A,B",
        complete=some_of(lambda: FORMULATIONS),
    ),
]
EnergyRows = Annotated[
    "Sequence[bool] | None",
    Option(
        Part.PROJECTION,
        "Whether velocities also keep the energy balance: false, true or both [default: the scene's].",
        TruthValues(),
        "A,B",
        complete=some_of(lambda: TruthValues.WORDS),
    ),
]
Alphas = Annotated[
    "Sequence[Quantity] | Quantity | None",
    Option(
        Part.PROJECTION,
        "Penalties for the methods that take one [default: the usual one].",
        Several(Positive("")),
        "NUMBER,..",
    ),
]
Gains = Annotated[
    "Sequence[Sequence[Quantity] | Quantity] | str | None",
    Option(
        Part.PROJECTION,
        "Gains α and β of Baumgarte's method [default: the usual ones].",
        Several(Pair("1/s"), ";"),
        "A[,B];..",
    ),
]


@declared
def compare(
    scene: SceneLike,
    *,
    projections: Projections = None,
    integrators: Integrators = None,
    steps: Steps = None,
    tolerances: Tolerances = None,
    formulations: Formulations = None,
    energy_rows: EnergyRows = None,
    alphas: Alphas = None,
    gains: Gains = None,
    until: Until = None,
    repeat: Repeat = 5,
    **effort: Unpack[Effort],
) -> Comparison:
    """Compares projection methods, integrators and steps on a scene.

    Prints a table: violations, the error against a reference by another method, the energy drift of integrator and
    projection, CPU time with its spread, counters. Writes CSV and a page of figures.

    In Python the scene's own settings complete the arguments. Stored results are reused, unless `fresh`. Raises
    InputError for what cannot be run at all; a setting that fails is a row.
    """
    from mbproj.studies.compare import compare as compare_settings

    asked = read(compare, locals())
    names = ("projections", "integrators", "steps", "tolerances", "formulations", "energy_rows", "alphas", "gains")
    return compare_settings(
        asked.scene, **with_values(asked, *names, "until"), repetitions=asked.repeat, **asked.effort
    )


EXAMPLES = (
    (
        "Compare two projection methods at the settings of the scene.",
        "mbproj compare five_bar.yaml --projections gopm,gpopm --until 2",
    ),
    (
        "Compare integrators, each at two steps.",
        "mbproj compare five_bar.yaml --integrators rk4,dopri5 --steps 1e-3,2e-3",
    ),
    (
        "See what the row of the energy gives and takes.",
        "mbproj compare five_bar.yaml --projections gpopm --energy-rows false,true",
    ),
)


def _told(asked: Asked[Any], comparison: Comparison) -> Told:
    numbers = {"until": float(comparison.reference.times[-1]), "entries": comparison.table.records}

    def page() -> Figure:
        return _page(comparison, asked.scene.title)

    return Told(comparison.table, _table(comparison), numbers, page, comparison.notes)


command = study_command(compare, EXAMPLES, _told, first=("label", "setting"), stem="compare", files=(answer, in_folder))


def _table(comparison: Comparison) -> str:
    from mbproj.commands.report.text import columns, milliseconds, number

    headings = ["", "|C|", "|C'|", "|C''|", "error, m", "drift, J", "integrator", "projection"]
    cost = ["CPU, ms", "spread"] if comparison.cost_in_time else []
    lines, rows = [], comparison.table.records
    for row in rows:
        ends = [milliseconds(row[f"cpu_seconds_{end}"]) for end in ("lowest", "highest")]
        spread = "-" if "-" in ends else " to ".join(ends)
        lines.append(
            [
                row["label"],
                *(number(row[f"{level}_violation"]) for level in ("position", "velocity", "acceleration")),
                "failed" if row["failure"] else number(row["error"]),
                *(number(row[f"energy_drift{part}"], "+.1e") for part in ("", "_integrator", "_projection")),
                *([milliseconds(row["cpu_seconds"]), spread] if cost else []),
                *(number(row[name], ".0f") for name in ("evaluations", "projection_iterations", "velocity_iterations")),
                number(row["factorisations"], ".0f"),
            ]
        )
    if "energy_row_given" in rows[0]:
        headings.insert(6, "row gave, J")
        for line, row in zip(lines, rows, strict=True):
            line.insert(6, number(row["energy_row_given"], "+.1e"))
    counts = ["evaluations", "position it.", "velocity it.", "factorisations"]
    return columns([*headings, *cost, *counts], lines)


def _page(comparison: Comparison, title: str) -> Figure:
    from mbproj.show.figures.studies import Compared, comparison_page

    methods = []
    for entry in comparison.entries:
        solution, report, timing = entry.solution, entry.solution.report, entry.timing
        counters = report.counters if report else {}
        methods.append(
            Compared(
                label=entry.label,
                time=solution.times,
                position_violation=solution.position_violation,
                velocity_violation=solution.velocity_violation,
                acceleration_violation=solution.acceleration_violation,
                error=entry.error.max(axis=1),
                integrator=entry.split.integrator if entry.split else None,
                projection=entry.split.projection if entry.split else None,
                seconds=(timing.median, *timing.spread) if timing else None,
                factorisations=counters.get("factorisations", 0),
                iterations=counters.get("projection_iterations", 0) + counters.get("velocity_iterations", 0),
            )
        )
    return comparison_page(methods, comparison.reference.uncertainty.max(axis=1), title)
