"""The common options of studies, each as a decorator of their commands."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from mbproj.base.registry import PROJECTIONS
from mbproj.base.registry import integrator_choices as known_integrators
from mbproj.commands.figure_options import look
from mbproj.commands.options import File, FolderPath, Part, Positive, QuantityNames, option, some_of

if TYPE_CHECKING:
    from mbproj.studies.parallel.hand_out import Where


Command = TypeVar("Command", bound=Callable[..., Any])

at = option(
    Part.ACCURACY,
    "--at",
    type=QuantityNames(),
    metavar="A,B,..",
    help="Markers whose error counts, or bodies of a scene without markers [default: all].",
)
until = option(
    Part.WHAT,
    "--until",
    "--duration",
    "until",
    type=Positive("s"),
    metavar="TIME",
    help="End of the study [default: the duration].",
)
changes = option(
    Part.WHAT,
    "--set",
    "changes",
    multiple=True,
    metavar="NAME=VALUE",
    help="Change a parameter, or any value by its path.",
)
repeat = option(
    Part.EFFORT,
    "--repeat",
    default=5,
    show_default=True,
    type=click.IntRange(1),
    help="How often each setting is timed.",
)
jobs = option(
    Part.EFFORT,
    "-j",
    "--jobs",
    type=click.IntRange(min=1),
    metavar="N",
    help="Processes at the same time [default: one per processor].",
)


def workplace(command: Command) -> Command:
    """Decorate a command with --jobs, --scheduler and --scheduler-file, which `where_of` combines."""
    command = option(
        Part.EFFORT,
        "--scheduler-file",
        type=click.Path(path_type=Path),
        metavar="FILE",
        help="Run on the Dask cluster whose scheduler has written FILE.",
    )(command)
    command = option(
        Part.EFFORT, "--scheduler", metavar="ADDRESS", help="Run on a Dask cluster, tcp://host:8786 for example."
    )(command)
    return jobs(command)


def where_of(options: dict[str, Any]) -> Where:
    """The place where the work is done; its options are removed from a command's options."""
    from mbproj.studies.parallel.cluster import workplace as where

    return where(*(options.pop(name, None) for name in ("jobs", "scheduler", "scheduler_file")))


fresh = option(Part.EFFORT, "--fresh", is_flag=True, help="Start over: use nothing of an earlier study.")


def projections(default: str) -> Callable[[Command], Command]:
    """Return a decorator for an option with several methods; `default` names those taken otherwise."""
    text = f"Of {', '.join(PROJECTIONS)} [default: {default}]."
    return option(
        Part.PROJECTION,
        "--projections",
        type=QuantityNames(),
        metavar="A,B,..",
        help=text,
        shell_complete=some_of(lambda: PROJECTIONS),
    )


def integrators(default: str) -> Callable[[Command], Command]:
    """Return a decorator for an option with several integrators; `default` names those taken otherwise."""
    text = f"Of {', '.join(known_integrators())} [default: {default}]."
    return option(
        Part.INTEGRATION,
        "--integrators",
        type=QuantityNames(),
        metavar="A,B,..",
        help=text,
        shell_complete=some_of(known_integrators),
    )


write_table_option = option(
    Part.OUTPUT,
    "--write-table",
    "table_file",
    type=File(".csv", ".tex", ".md", path_type=Path),
    metavar="FILE",
    help="Write the table for a paper: FILE.csv, .tex for LaTeX, .md.",
)
force = option(Part.OUTPUT, "--force", is_flag=True, help="Replace files that mbproj did not write, too.")
junit = option(Part.OUTPUT, "--junit", "xml", type=click.Path(path_type=Path), metavar="FILE", help="Write JUnit XML.")


NOTHING_ELSE = "Print nothing but errors and notes."


def answer(command: Command, *, quiet: str = NOTHING_ELSE) -> Command:
    """Decorate a command with the options of every report: --write-table, --json, --quiet with this help, --force."""
    text = "Print one JSON object instead of the report."
    as_json = option(Part.OUTPUT, "--json", "as_json", is_flag=True, help=text)
    is_quiet = option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help=quiet)
    return write_table_option(as_json(is_quiet(force(command))))


def study(command: Command, *, quiet: str = NOTHING_ELSE) -> Command:
    """Decorate a command with the options of every study: those of `workplace` and of `answer`, and --fresh."""
    return workplace(fresh(answer(command, quiet=quiet)))


def in_folder(command: Command) -> Command:
    """Decorate a command that writes its table and its figure into a folder: -o, --format and the figure's look."""
    formats = click.Choice(["png", "svg", "pdf"])
    form = option(Part.OUTPUT, "--format", "ending", default="png", type=formats, help="Format [default: png].")
    folder = FolderPath(path_type=Path)
    text = "Output directory [default: .]."
    return option(Part.OUTPUT, "-o", "--output", default=".", type=folder, metavar="DIR", help=text)(
        form(look(command))
    )
