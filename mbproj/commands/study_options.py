"""The common options of studies: as annotations of the parameters of their functions, and as decorators."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypedDict, TypeVar

import click

from mbproj.base.registry import PROJECTIONS
from mbproj.base.registry import integrator_choices as known_integrators
from mbproj.commands.figure_options import look
from mbproj.commands.kinds import Count, Names, OneOf, Positive
from mbproj.commands.options import (
    File,
    FolderPath,
    Option,
    Part,
    RunSettings,
    force_option,
    json_option,
    option,
    some_of,
)

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from mbproj.commands.arguments import Quantity
    from mbproj.studies.parallel.cluster import Cluster
    from mbproj.studies.parallel.progress import Tell


Command = TypeVar("Command", bound=Callable[..., Any])

AT = Option(
    Part.ACCURACY,
    "Markers whose error counts, or bodies of a scene without markers [default: all].",
    Names(),
    "A,B,..",
)
At = Annotated["str | Sequence[str]", AT]
Until = Annotated[
    "Quantity | None",
    Option(
        Part.WHAT, "End of the study [default: the duration].", Positive("s"), "TIME", names=("--until", "--duration")
    ),
]
Repeat = Annotated[int, Option(Part.EFFORT, "How often each setting is timed.", Count(1))]
JOBS = Option(
    Part.EFFORT,
    "Processes at the same time [default: one per processor].",
    Count(1),
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


class Workplace(TypedDict, total=False):
    """Where a study does its work: in `jobs` processes, or on the Dask cluster whose `scheduler` is named."""

    jobs: Jobs
    scheduler: Scheduler
    scheduler_file: SchedulerFile


class FreshWork(Workplace, total=False):
    """Where a study does its work. Stored results are reused, unless `fresh`. `progress` is called with the phase, the
    number of items done, and the number of all."""

    fresh: Fresh
    progress: Tell


class Effort(FreshWork, total=False):
    """The effort of a study of a scene, which `parameters` change."""

    parameters: Mapping[str, object]


class EffortOnSetting(Effort, RunSettings, total=False):
    """The effort of a study of one setting, and this setting."""


def projections(usual: str) -> Option:
    """The option for several methods; `usual` names those taken otherwise."""
    words = f"Of {', '.join(PROJECTIONS)} [default: {usual}]."
    return Option(Part.PROJECTION, words, Names(), "A,B,..", complete=some_of(lambda: PROJECTIONS))


def integrators(usual: str) -> Option:
    """The option for several integrators; `usual` names those taken otherwise."""
    words = f"Of {', '.join(known_integrators())} [default: {usual}]."
    return Option(Part.INTEGRATION, words, Names(), "A,B,..", complete=some_of(known_integrators))


write_table_option = option(
    Part.OUTPUT,
    "--write-table",
    "table_file",
    type=File(".csv", ".tex", ".md", path_type=Path),
    metavar="FILE",
    help="Write the table for a paper: FILE.csv, .tex for LaTeX, .md.",
)
junit = option(Part.OUTPUT, "--junit", "xml", type=click.Path(path_type=Path), metavar="FILE", help="Write JUnit XML.")


NOTHING_ELSE = "Print nothing but errors and notes."


def answer(command: Command, *, quiet: str = NOTHING_ELSE) -> Command:
    """Decorate a command with the options of every report: --write-table, --json, --quiet with this help, --force."""
    is_quiet = option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help=quiet)
    return write_table_option(json_option(is_quiet(force_option(command))))


def in_folder(command: Command) -> Command:
    """Decorate a command that writes its table and its figure into a folder: -o, --format and the figure's look."""
    formats = OneOf(["png", "svg", "pdf"])
    form = option(Part.OUTPUT, "--format", "ending", default="png", type=formats, help="Format [default: png].")
    folder = FolderPath(path_type=Path)
    text = "Output directory [default: .]."
    return option(Part.OUTPUT, "-o", "--output", default=".", type=folder, metavar="DIR", help=text)(
        form(look(command))
    )
