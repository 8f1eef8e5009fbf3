"""`mbproj export`, `mbproj.export` and `export_model`: results as CSV or LaTeX tables, and scenes as models of other
formats, for programs that read those."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode, InputError, Place, Problem, choose_from
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.kinds import Corners, Names, OneOf
from mbproj.commands.options import (
    NOTHING,
    Argument,
    FolderPath,
    Option,
    Part,
    changes,
    force_option,
    option,
    output_option,
    results_file,
)
from mbproj.results.views import Table, Tabled

if TYPE_CHECKING:
    from mbproj.commands.arguments import SceneLike
    from mbproj.formats.export.exported import Written
    from mbproj.formats.mechanism import Said
    from mbproj.results.analysis.tables import QuantityTable
    from mbproj.results.record import Results
    from mbproj.scene.scene import Scene

EXAMPLES = (
    ("Write every table.", "mbproj export results.h5 -o tables"),
    ("Write the largest loads for a report in LaTeX.", "mbproj export results.h5 --table loads --format latex"),
    ("Write a scene as a model of MuJoCo.", "mbproj export five_bar.yaml --mjcf five_bar.xml"),
)
ANOTHER_FILE = "choose another file"
OTHER_DIRECTORY = "choose another directory"
CSV, LATEX = "csv", "latex"
File = Annotated["Results | str | Path", Argument(results_file(path_type=Path), "FILE")]
Chosen = Annotated[
    "str | Sequence[str]",
    Option(Part.WHAT, "Only this table, e.g. body-crank; repeatable.", Names(), "NAME", many=True),
]
Format = Annotated[str, Option(Part.OUTPUT, "A CSV table, or a tabular for LaTeX.", OneOf((CSV, LATEX)))]
Over = Annotated[
    "str | None",
    Option(Part.WHAT, "Begin each table with this coordinate, and add its ratios.", None, "JOINT.COORDINATE"),
]
PerTurn = Annotated[bool, Option(Part.WHAT, "With --over: an angle modulo a turn.")]
Transmission = Annotated[
    "Sequence[tuple[str, str, str]]",
    Option(
        Part.WHAT,
        "Add the transmission angle at marker B, between the lines to A and C; repeatable.",
        Corners(),
        "A,B,C",
        many=True,
    ),
]


@declared
def export(
    results: File,
    *,
    output: str | Path = ".",
    table: Chosen = (),
    format: Format = CSV,
    over: Over = None,
    per_turn: PerTurn = False,
    transmission: Transmission = (),
    force: bool = False,
) -> dict[str, Path]:
    """Writes results as CSV or LaTeX tables, or a scene as MJCF or URDF.

    There is a table for each body, marker, joint, force and motion, one of the largest loads, and one of diagnostics.
    Files are DIR/<file>-<table>.csv or .tex. The first line names the columns and their units; numbers keep all their
    digits in CSV, and six in LaTeX.

    A model of a scene starts at the assembled start. A table tells what the format lacks, and whether the motion of the
    model is still that of the scene.

    In Python it returns the file of each table of results, by its name. Raises InputError for an unknown name, and for
    an existing file of another kind unless `force`.
    """
    from mbproj.commands.stored_run import opened

    asked = read(export, locals())
    with opened(asked.results) as opened_results:
        return _write(_shown(opened_results, asked), Path(output), asked, force=force)


def _shown(results: Results, asked: Any) -> Results:
    """The results over the coordinate that is asked for."""
    if asked.per_turn and asked.over is None:
        raise InputError(Problem("it is for a coordinate", Place("--per-turn"), "add --over, or leave it out"))
    return results if asked.over is None else results.over(asked.over, modulo=asked.per_turn)


def _write(results: Results, folder: Path, asked: Any, *, force: bool) -> dict[str, Path]:
    """Write the tables of open results as `export` does; all tables where none is chosen."""
    from mbproj.results.analysis.tables import tables
    from mbproj.results.output_files import check_replaceable, csv, latex, make_folder
    from mbproj.results.table_files import write_csv, write_latex
    from mbproj.show.figures.rows import stem

    by_name, first = {each.name: each for each in tables(results, asked.transmission)}, stem(results)
    names = [_checked_name(by_name, name) for name in asked.table] or list(by_name)
    make_folder(folder, OTHER_DIRECTORY)
    ending, is_csv = ("csv", True) if asked.format == CSV else ("tex", False)
    files = {name: folder / _file_name(f"{first}-{name}.{ending}") for name in names}
    for name, path in files.items():  # check all files before the first is written
        kind = csv(by_name[name].headings) if is_csv else latex()
        check_replaceable(path, kind, force=force, hint=OTHER_DIRECTORY)
    write, digits = (write_csv, ".17g") if is_csv else (write_latex, ".6g")
    for name, path in files.items():
        each = by_name[name]
        write(path, each.headings, each.rows(), form=digits, force=force, hint=OTHER_DIRECTORY)
    return files


def _checked_name(tables_by_name: Mapping[str, QuantityTable], name: str) -> str:
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


@dataclass(frozen=True, eq=False)
class Exported(Tabled):
    """The `text` of a model made from a scene. `loops` is a YAML file beside a URDF, or ""; `said` are notes."""

    format: str
    text: str
    loops: str
    said: Sequence[Said]

    @property
    def table(self) -> Table:
        """A table with a row for each thing that the format lacks: what became of it, and whether the motion is still
        the scene's."""
        from mbproj.commands.import_model import said_table

        return said_table(self.said)

    @property
    def line(self) -> str:
        """A line that describes the model."""
        return f"{self.format.upper()} of {len(self.text.splitlines())} lines"

    __repr__ = Tabled.__repr__


MODELS = {"mjcf": "mbproj.formats.export.mjcf:as_mjcf", "urdf": "mbproj.formats.export.urdf:as_urdf"}


@declared
def export_model(scene: SceneLike, format: str = "mjcf", *, parameters: Mapping[str, object] = NOTHING) -> Exported:
    """Writes a scene as a model in MJCF or URDF, as `mbproj export SCENE --mjcf FILE` does.

    The model starts at the assembled start. Raises InputError where the scene is wrong or cannot be assembled.
    """
    name = OneOf(MODELS).of(format, "format")
    return _as_model(name, read(export_model, locals()).scene)


def _as_model(name: str, scene: Scene) -> Exported:
    from mbproj.base.registry import load
    from mbproj.base.version import __version__

    exported: Written = load(MODELS[name])(scene, __version__)
    return Exported(name, exported.text, exported.loops, exported.said)


LIST = option(Part.OUTPUT, "--list", "only_list", is_flag=True, help="List the tables, write nothing.")
MJCF = option(
    Part.WHAT, "--mjcf", type=click.Path(path_type=Path), metavar="MODEL", help="For a scene: write it as MJCF."
)
URDF = option(
    Part.WHAT,
    "--urdf",
    type=click.Path(path_type=Path),
    metavar="MODEL",
    help="For a scene: write it as URDF, with its loops in a YAML file beside it.",
)
STRICT = option(
    Part.OUTPUT, "--strict", is_flag=True, help="For a scene: end with 4 where the model's motion is another one."
)
JSON = option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="For a scene: print the table as one JSON object.")
OUTPUT = output_option(".", FolderPath(path_type=Path), "Output directory.")


@command_of(export, EXAMPLES, OUTPUT, LIST, MJCF, URDF, changes, STRICT, JSON, force_option)
def command(
    asked: Asked[dict[str, Path]],
    output: Path,
    only_list: bool,
    mjcf: Path | None,
    urdf: Path | None,
    strict: bool,
    as_json: bool,
    force: bool,
) -> int:
    models = {kind: path for kind, path in (("mjcf", mjcf), ("urdf", urdf)) if path is not None}
    if models:
        scene: Path = asked.given["results"]
        return export_models(scene, asked.changes, models, strict=strict, as_json=as_json, force=force)
    if asked.changes or strict or as_json:
        problem = Problem("--set, --strict and --json are of a scene", hint="add --mjcf FILE or --urdf FILE")
        raise InputError(problem)
    from mbproj.results.analysis.tables import tables
    from mbproj.results.reader import open_results

    wanted = asked.read()
    with open_results(wanted.results) as results:
        shown = _shown(results, wanted)
        if only_list:
            by_name = {table.name: table for table in tables(shown, wanted.transmission)}
            click.echo("\n".join([_checked_name(by_name, name) for name in wanted.table] or by_name))
            return ExitCode.DONE
        for path in _write(shown, output, wanted, force=force).values():
            click.echo(path)
    return ExitCode.DONE


def export_models(
    scene: Path, typed: tuple[str, ...], models: dict[str, Path], *, strict: bool, as_json: bool, force: bool
) -> ExitCode:
    """Write the scene as these models, by format, all or none, and print their tables.

    Raises InputError where a file may not be replaced, or the scene cannot be assembled."""
    from mbproj.commands.import_model import table_json, table_lines
    from mbproj.commands.options import parameters
    from mbproj.formats.mechanism import Same
    from mbproj.results.output_files import LOOPS, MODEL, check_replaceable, write_text
    from mbproj.scene.scene import read_scene

    for path in models.values():
        check_replaceable(path, MODEL, force=force, hint=ANOTHER_FILE)
    what = read_scene(str(scene), parameters(typed))
    written = {kind: _as_model(kind, what) for kind in models}
    files: list[tuple[str, Path, str]] = []
    for kind, path in models.items():
        files.append((kind, path, written[kind].text))
        if written[kind].loops:
            beside = path.with_suffix(".yaml")
            if beside.resolve() == scene.resolve():
                problem = f"the loops of '{path}' belong in '{beside}', which is the scene"
                raise InputError(Problem(problem, hint="give the model another name"))
            files.append(("loops", beside, written[kind].loops))
    for kind, path, _ in files:
        if kind == "loops":
            check_replaceable(path, LOOPS, force=force, hint=ANOTHER_FILE)
    for kind, path, text in files:
        write_text(path, text, LOOPS if kind == "loops" else MODEL, force=force)
    said = [row for each in written.values() for row in each.said]
    if as_json:
        click.echo(table_json(said, files=[str(path) for _, path, _ in files]))
    else:
        for kind, each in written.items():
            everything = f"everything in the scene has its counterpart in the {kind.upper()}"
            for line in table_lines(each.said, everything):
                click.echo(line)
        for _, path, _ in files:
            click.echo(str(path))
    if strict and any(row.same is Same.NO for row in said):
        return ExitCode.CHECK_FAILED
    return ExitCode.DONE
