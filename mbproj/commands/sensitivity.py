"""`mbproj sensitivity` and `mbproj.sensitivity`: how much numbers of a scene change its expectations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

from mbproj.commands.declared import Asked, Told, declared, read, study_command
from mbproj.commands.figure_options import plot_option
from mbproj.commands.kinds import Names
from mbproj.commands.options import NOTHING, Option, Part
from mbproj.commands.study_options import Workplace, answer

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbproj.commands.arguments import SceneLike
    from mbproj.results.views import Table
    from mbproj.studies.design.sensitivity import Sensitivities

EXAMPLES = (
    (
        "See which parameters matter for what the scene expects.",
        "mbproj sensitivity planar_four_bar.yaml --to crank,coupler",
    ),
    ("The same as bars.", "mbproj sensitivity planar_four_bar.yaml --to crank,coupler --plot bars.png"),
)
Of = Annotated[
    "str | Sequence[str]",
    Option(Part.WHAT, "Expectations by name [default: all but diagnostics].", Names(), "A,B,.."),
]
To = Annotated[
    "str | Sequence[str]",
    Option(Part.WHAT, "Parameters, or numbers by their paths [default: parameters].", Names(), "A,B,.."),
]


@declared
def sensitivity(
    scene: SceneLike,
    *,
    of: Of = (),
    to: To = (),
    parameters: Mapping[str, object] = NOTHING,
    **effort: Unpack[Workplace],
) -> Sensitivities:
    """Measures how much numbers of a scene change what it expects.

    Prints a table with the value of each measure, its derivative by each number with the error of that, and the
    elasticity: by how many percent the measure changes where the number changes by one. Dual numbers that follow one
    run give the slopes; where they cannot, differences of runs do, and the output says why.

    In Python it returns this table. Raises InputError for unknown names, and where a run with a changed number fails.
    """
    from mbproj.studies.design.sensitivity import sensitivities

    asked = read(sensitivity, locals())
    return sensitivities(asked.scene, asked.of, asked.to, asked.where)


def _told(asked: Asked[Any], slopes: Sensitivities) -> Told:
    from mbproj.commands.report.text import columns
    from mbproj.show.figures.designs import draw_sensitivities
    from mbproj.studies.design.sensitivity import LEFT_OUT

    table = slopes.table
    headings = ["measure", "number", "value", "slope", "±", "elasticity", "unit of the slope"]
    rows = columns(headings, [_cells(row) for row in table.rows if row[7] != LEFT_OUT])
    return Told(table, "\n".join([rows, *_how(table)]), {"slopes": table.records}, lambda: draw_sensitivities(table))


command = study_command(sensitivity, EXAMPLES, _told, first=("measure", "number"), files=(answer, plot_option))


def _how(table: Table) -> Iterator[str]:
    """Yield lines on the method of the slopes, the reasons against dual numbers, and the numbers left out with their
    reasons."""
    from mbproj.studies.design.sensitivity import LEFT_OUT

    reasons: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for measure, number, *_, by, because in table.rows:
        reasons.setdefault((by, because), []).append((measure, number))
    numbers = {number: None for _, number, *_ in table.rows}
    for (by, because), pairs in reasons.items():
        varied = dict.fromkeys(number for _, number in pairs)
        of = dict.fromkeys(measure for measure, _ in pairs) if len(varied) == len(numbers) else {}
        what = f" of {', '.join(of)}" if of else f" by {', '.join(varied)}"
        reason = f", because {because}" if because else " along one run"
        if by == LEFT_OUT:
            yield f"{by}: {', '.join(varied)}{reason}"
        else:
            yield f"slopes{what if len(reasons) > 1 else ''}: {by}{reason}"


def _cells(row: tuple[Any, ...]) -> list[str]:
    measure, number, value, slope, uncertainty, elasticity, unit = row[:7]
    shown = "-" if elasticity != elasticity else f"{elasticity:+.4f}"
    return [measure, number, f"{value:.6g}", f"{slope:+.6g}", f"{uncertainty:.1e}", shown, unit]
