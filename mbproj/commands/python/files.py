"""Functions of results files: `mbproj.export`, `compare_results`, `largest_loads`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.commands.python.arguments import Quantity, amount, by_arguments, names_of
from mbproj.commands.python.run import opened
from mbproj.results.analysis.comparison import COMPARED, MotionComparison, compare_motions
from mbproj.results.analysis.loads import loads_of
from mbproj.results.analysis.tables import QuantityTable, tables
from mbproj.results.largest_loads import Load
from mbproj.results.output_files import check_replaceable, csv, latex, make_folder
from mbproj.results.record import Results
from mbproj.results.table_files import write_csv, write_latex
from mbproj.results.views import Table
from mbproj.scene.fields.quantities import Number, given_number
from mbproj.show.figures.rows import stem

OTHER_DIRECTORY = "choose another directory"
CSV, LATEX = "csv", "latex"
_NOTHING: Mapping[str, Quantity] = {}


def export(
    results: Results | str | Path,
    *,
    output: str | Path = ".",
    table: str | Sequence[str] = (),
    format: str = CSV,
    over: str | None = None,
    per_turn: bool = False,
    transmission: Sequence[tuple[str, str, str]] = (),
    force: bool = False,
) -> dict[str, Path]:
    """Writes results as tables into the folder `output`, and returns the file of each table.

    There is a table for each body, marker, joint, force and motion ("body-crank"), "loads" and "diagnostics"; `table`
    selects some of them. `format` is "csv" or "latex". `over` is a joint coordinate that becomes the first column, with
    `per_turn` modulo a turn. It adds the table "ratios". `transmission` adds the angle at the second of three markers.
    Raises InputError for an unknown name, and for an existing file of another kind unless `force`.
    """
    with by_arguments(), opened(results) as opened_results:
        if format not in (CSV, LATEX):
            hint = choose_from(format, (CSV, LATEX))
            raise InputError(Problem(f"unknown format '{format}'", Place("format"), hint))
        if per_turn and over is None:
            raise InputError(Problem("it is for a coordinate", Place("per_turn"), "add over, or leave it out"))
        shown = opened_results if over is None else opened_results.over(over, modulo=per_turn)
        return write_tables(shown, Path(output), names_of(table), format, transmission, force=force)


def write_tables(
    results: Results,
    folder: Path,
    chosen: Sequence[str],
    form: str,
    corners: Sequence[tuple[str, str, str]],
    *,
    force: bool,
) -> dict[str, Path]:
    """Write the tables of open results as `export` does; all tables where none is `chosen`."""
    by_name, first = {each.name: each for each in tables(results, corners)}, stem(results)
    names = [checked_name(by_name, name) for name in chosen] or list(by_name)
    make_folder(folder, OTHER_DIRECTORY)
    ending, is_csv = ("csv", True) if form == CSV else ("tex", False)
    files = {name: folder / _file_name(f"{first}-{name}.{ending}") for name in names}
    for name, path in files.items():  # check all files before the first is written
        kind = csv(by_name[name].headings) if is_csv else latex()
        check_replaceable(path, kind, force=force, hint=OTHER_DIRECTORY)
    write, digits = (write_csv, ".17g") if is_csv else (write_latex, ".6g")
    for name, path in files.items():
        each = by_name[name]
        write(path, each.headings, each.rows(), form=digits, force=force, hint=OTHER_DIRECTORY)
    return files


def checked_name(tables_by_name: Mapping[str, QuantityTable], name: str) -> str:
    """Return the name of a table. Raises InputError with the most similar name where there is none."""
    if name not in tables_by_name:
        raise InputError(Problem(f"there is no table '{name}'", hint=choose_from(name, tables_by_name)))
    return name


def _file_name(name: str) -> str:
    """Return the name if it names a file in a folder, not a path. It comes from a results file that anybody may have
    written."""
    if set(name) & {"/", "\\", "\0"}:
        problem = Problem(f"'{name}' cannot name a file", hint="the results were changed after mbproj wrote them")
        raise InputError(problem)
    return name


def compare_results(
    first: Results | str | Path,
    second: Results | str | Path,
    *,
    tolerance: Quantity = 1e-6,
    absolute: Mapping[str, Quantity] = _NOTHING,
) -> MotionComparison:
    """Compares two results at the sample times that both have; `found.same` tells whether they are the same motion.

    A quantity may differ by `tolerance` times its largest magnitude, or by what `absolute` allows by its path, such as
    {"bodies/position": "1 mm"}. Raises InputError where the results cannot be compared.
    """
    with by_arguments(), opened(first) as one, opened(second) as other:
        part = amount(tolerance, "tolerance", None, above=0.0)
        return compare_motions(one, other, part, {name: allowed(name, value) for name, value in absolute.items()})


def allowed(name: str, value: Quantity) -> float:
    """The difference that a quantity is allowed, in its unit. Raises InputError for an unknown quantity, or a value
    that is not a positive number in its unit."""
    units = {dataset.path: dataset.unit for dataset in COMPARED}
    if name not in units:
        hint = choose_from(name, units, "quantities")
        raise InputError(Problem(f"there is no quantity '{name}'", Place("--absolute"), hint))
    unit_text = "rad" if name == "bodies/orientation" else units[name]
    unit = None if " or " in unit_text else unit_text.replace(" ", "*")
    return given_number(value, "--absolute", Number(unit, above=0.0))


def largest_loads(results: Results | str | Path, *, over: str | None = None) -> Table:
    """The largest loads of a run, as `mbproj info --loads` lists them: a table with a row for each load and the fields
    of `Load`.

    `over` names the coordinate that tells the place in the cycle. Raises InputError for an unknown name.
    """
    with by_arguments(), opened(results) as opened_results:
        return Table.of((load._asdict() for load in loads_of(opened_results, over)), *Load._fields)
