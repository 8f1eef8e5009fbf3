"""The common options of studies: as annotations of the parameters of their functions, and as decorators."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypedDict, TypeVar

import click

from mbproj.base.registry import PROJECTIONS
from mbproj.base.registry import integrator_choices as known_integrators
from mbproj.commands.figure_options import look
from mbproj.commands.options import (
    File,
    FolderPath,
    Option,
    Part,
    Positive,
    QuantityNames,
    RunSettings,
    option,
    some_of,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from mbproj.commands.python.arguments import Quantity
    from mbproj.studies.parallel.cluster import Cluster
    from mbproj.studies.parallel.hand_out import Where
    from mbproj.studies.parallel.progress import Tell


Command = TypeVar("Command", bound=Callable[..., Any])

AT = Option(
    Part.ACCURACY,
    "Markers whose error counts, or bodies of a scene without markers [default: all].",
    QuantityNames(),
    "A,B,..",
)
At = Annotated["str | Sequence[str]", AT]
Until = Annotated[
    "Quantity | None",
    Option(
        Part.WHAT, "End of the study [default: the duration].", Positive("s"), "TIME", names=("--until", "--duration")
    ),
]
Repeat = Annotated[int, Option(Part.EFFORT, "How often each setting is timed.", click.IntRange(1))]
JOBS = Option(
    Part.EFFORT,
    "Processes at the same time [default: one per processor].",
    click.IntRange(min=1),
    "N",
    names=("-j", "--jobs"),
)
Jobs = Annotated["int | Cluster | None", JOBS]
SCHEDULER = Option(Part.EFFORT, "Run on a Dask cluster, tcp://host:8786 for example.", None, "ADDRESS")
Scheduler = Annotated["str | None", SCHEDULER]
SCHEDULER_FILE = Option(
    Part.EFFORT, "Run on the Dask cluster whose scheduler has written FILE.", click.Path(path_type=Path), "FILE"
)
SchedulerFile = Annotated["Path | None", SCHEDULER_FILE]
FRESH = Option(Part.EFFORT, "Start over: use nothing of an earlier study.")
Fresh = Annotated[bool, FRESH]


class Effort(TypedDict, total=False):
    """How much work a study does, and where: in `jobs` processes, or on the Dask cluster whose `scheduler` is named.
    Stored results are reused, unless `fresh`. `parameters` change the scene; `progress` is called with the phase, the
    number of items done, and the number of all."""

    jobs: Jobs
    scheduler: Scheduler
    scheduler_file: SchedulerFile
    fresh: Fresh
    parameters: Mapping[str, object]
    progress: Tell


class EffortOnSetting(Effort, RunSettings, total=False):
    """The effort of a study of one setting, and this setting."""


def projections(usual: str) -> Option:
    """The option for several methods; `usual` names those taken otherwise."""
    words = f"Of {', '.join(PROJECTIONS)} [default: {usual}]."
    return Option(Part.PROJECTION, words, QuantityNames(), "A,B,..", complete=some_of(lambda: PROJECTIONS))


def integrators(usual: str) -> Option:
    """The option for several integrators; `usual` names those taken otherwise."""
    words = f"Of {', '.join(known_integrators())} [default: {usual}]."
    return Option(Part.INTEGRATION, words, QuantityNames(), "A,B,..", complete=some_of(known_integrators))


changes = option(
    Part.WHAT,
    "--set",
    "changes",
    multiple=True,
    metavar="NAME=VALUE",
    help="Change a parameter, or any value by its path.",
)


def _adds(**entries: Option) -> Callable[[Command], Command]:
    """The decorator that adds options to a command, each with its name and without a default."""

    def add(command: Command) -> Command:
        for name, entry in reversed(entries.items()):
            parameter = inspect.Parameter(
                name, inspect.Parameter.KEYWORD_ONLY, default=False if entry is FRESH else None
            )
            command = entry.on_command_line(parameter)(command)
        return command

    return add


#: Decorates a command with --jobs, --scheduler and --scheduler-file, which `where_of` combines.
workplace = _adds(jobs=JOBS, scheduler=SCHEDULER, scheduler_file=SCHEDULER_FILE)
fresh = _adds(fresh=FRESH)


def where_of(options: dict[str, Any]) -> Where:
    """The place where the work is done; its options are removed from a command's options."""
    from mbproj.studies.parallel.cluster import workplace as where

    return where(*(options.pop(name, None) for name in ("jobs", "scheduler", "scheduler_file")))


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
