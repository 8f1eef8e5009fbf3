"""`mbproj compare`: chosen methods on one mechanism, in one table and one page of figures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.errors import InputError, Place, Problem
from mbproj.base.registry import FORMULATIONS
from mbproj.commands import study_options
from mbproj.commands.options import Part, PositiveList, QuantityNames, explained, option, scene_file, some_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.studies.compare import Comparison

ON_AND_OFF = ("false", "true")
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


@explained("compare", EXAMPLES)
@click.argument("scene", type=scene_file())
@study_options.projections("none,baumgarte,gopm,gpopm")
@study_options.integrators("the scene's")
@option(
    Part.INTEGRATION, "--steps", type=PositiveList("s"), metavar="TIME,..", help="Fixed steps [default: the scene's]."
)
@option(
    Part.INTEGRATION,
    "--tolerances",
    type=PositiveList(""),
    metavar="NUMBER,..",
    help="Error tolerances, for integrators with an error estimate.",
)
@option(
    Part.INTEGRATION,
    "--formulations",
    type=QuantityNames(),
    metavar="A,B",
    shell_complete=some_of(lambda: FORMULATIONS),
    help="Formulations to compare; with several, cost is counted in factorisations, not in time.",
)
@option(
    Part.PROJECTION,
    "--energy-rows",
    type=QuantityNames(),
    metavar="A,B",
    shell_complete=some_of(lambda: ON_AND_OFF),
    help="Whether velocities also keep the energy balance: false, true or both [default: the scene's].",
)
@study_options.until
@study_options.changes
@study_options.repeat
@study_options.study
@study_options.in_folder
def command(scene: str, changes: tuple[str, ...], **options: Any) -> None:
    """Compares projection methods, integrators and steps on SCENE.

    Prints a table: violations, the error against a reference by another method, the energy drift of integrator and
    projection, CPU time with its spread, counters. Writes CSV and a page of figures.
    """
    from mbproj.commands.options import parameters
    from mbproj.commands.study import Study
    from mbproj.scene.scene import read_scene
    from mbproj.studies.compare import compare

    what = read_scene(scene, parameters(changes))
    study = Study(options, ("label", "setting"), f"{Path(scene).stem}-compare")
    comparison = study.result(compare, what, energy_rows=_truth_values(options.pop("energy_rows")), **options)
    table = comparison.table
    numbers = {"until": float(comparison.reference.times[-1]), "entries": table.records}
    study.hand_over(table, _table(comparison), numbers, lambda: _page(comparison, what.title), comparison.notes)


def _truth_values(names: Sequence[str] | None) -> tuple[bool, ...] | None:
    """The truth values of words. Raises InputError for a word that is neither false nor true."""
    for name in names or ():
        if name not in ON_AND_OFF:
            hint = "give false, true or false,true"
            raise InputError(Problem(f"'{name}' is neither false nor true", Place("--energy-rows"), hint))
    return None if names is None else tuple(name == "true" for name in names)


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
