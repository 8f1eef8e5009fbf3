"""`mbproj sweep` and `mbproj.sweep`: runs a family of mechanisms and tabulates the measured values."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, final

import click

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.figure_options import plot_option
from mbproj.commands.kinds import Count, Positive
from mbproj.commands.options import Argument, FolderPath, Option, Part, option, output_option, scene_file
from mbproj.commands.study_options import Fresh, Workplace, answer, junit
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import SWEEP
from mbproj.results.views import Table

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbproj.commands.arguments import Quantity
    from mbproj.scene.ranges import Item
    from mbproj.studies.sweep.folder import Folder
    from mbproj.studies.sweep.run import Progress
    from mbproj.studies.sweep.spec import SweepSpec
    from mbproj.studies.sweep.summary import CaseEntry

#: The cases that --dry-run prints, the kinds of failure that are shown, and the number of cases to confirm.
SHOWN, KINDS, MANY = 8, 10, 1_000_000
EXAMPLES = (
    ("See what would run.", "mbproj sweep lengths.yaml --dry-run"),
    ("Run it, or go on with it where it was interrupted.", "mbproj sweep lengths.yaml"),
    ("Give up when more than ten cases fail or hang.", "mbproj sweep lengths.yaml --max-failures 10 --timeout 30"),
)
Spec = Annotated["str | Path", Argument(scene_file(path_type=Path))]
Timeout = Annotated["Quantity | None", Option(Part.EFFORT, "Stop a case that runs longer.", Positive("s"), "TIME")]
MostFailures = Annotated[
    "int | None",
    Option(Part.EFFORT, "Stop when more than K cases have failed.", Count(), "K", names=("--max-failures",)),
]
RetryFailed = Annotated[bool, Option(Part.EFFORT, "Run cases again that have failed before.")]


@final
@dataclass(frozen=True)
class SweepTable(Table):
    """A table with a row for each case, with the headings of summary.csv. `progress` counts the cases that were
    computed, known from before, and failed; `folder` is where they are stored."""

    progress: Progress
    folder: Path

    __repr__ = Table.__repr__


@declared
def sweep(
    spec: Spec,
    *,
    output: str | Path | None = None,
    timeout: Timeout = None,
    most_failures: MostFailures = None,
    retry_failed: RetryFailed = False,
    fresh: Fresh = False,
    force: bool = False,
    progress: Callable[[Progress], None] = lambda progress: None,
    **effort: Unpack[Workplace],
) -> SweepTable:
    """Runs a family of mechanisms and tabulates what it measures.

    SPEC is a YAML file: a scene, what varies in it, what is measured. Writes summary.csv and summary.h5 into DIR.
    Finished cases are kept there: the same command goes on where it was interrupted, and after a change of SPEC only
    new cases are computed.

    Exit code 0: all cases ran; 3: some failed, and the table says why; 2: wrong input; 130: interrupted, and the table
    has what was computed.

    In Python `output` is the folder. `force` replaces a table that was changed by hand. Raises InputError where the
    file is wrong. A case that fails is a row.
    """
    from mbproj.studies.sweep import summary
    from mbproj.studies.sweep.spec import read_spec

    asked = read(sweep, locals())
    what = read_spec(asked.spec)
    folder = _folder(asked, what, output)
    with folder.store:
        summary.check_summary(folder, force)  # before the work begins
        reached = _run(asked, what, folder, progress)
        summary.write_summary(what, folder, force)
        rows = tuple(map(tuple, summary.cells(what, summary.entries(what, folder))))
    return SweepTable(tuple(summary.headings(what)), rows, reached, folder.path)


def _folder(asked: Any, what: SweepSpec, output: str | Path | None) -> Folder:
    from mbproj.studies.sweep.folder import Folder

    usual = asked.spec.with_name(f"{asked.spec.stem}-sweep")
    return Folder(usual if output is None else Path(output), what, asked.fresh)


def _run(asked: Any, what: SweepSpec, folder: Folder, tell: Callable[[Progress], None]) -> Progress:
    from mbproj.studies.sweep.run import run_sweep

    limits = {name: getattr(asked, name) for name in ("timeout", "most_failures", "retry_failed")}
    return run_sweep(what, folder, asked.where, **limits, tell=tell)


DRY = option(
    Part.EFFORT, "--dry-run", "dry", is_flag=True, help="Count the cases and print the first ones; run nothing."
)
YES = option(Part.EFFORT, "--yes", is_flag=True, help=f"Run more than {MANY} cases.")
OUTPUT = output_option(None, FolderPath(path_type=Path), "Directory of the sweep [default: <spec>-sweep].", "DIR")


@command_of(sweep, EXAMPLES, answer, DRY, YES, OUTPUT, junit, plot_option)
def command(asked: Asked[SweepTable], dry: bool, yes: bool, output: Path | None, **options: Any) -> int:
    from mbproj.commands.plot import usual_of_sweep
    from mbproj.commands.study_report import StudyReport
    from mbproj.studies.parallel.progress import CASES, with_words
    from mbproj.studies.sweep import summary
    from mbproj.studies.sweep.spec import read_spec

    wanted = asked.read()
    what = read_spec(wanted.spec)
    if dry:
        click.echo(_preview(what, SHOWN))
        return int(ExitCode.DONE)
    _confirm_number(what, yes)
    study = StudyReport(options, ("case",))
    folder = _folder(wanted, what, output)
    reached: list[Progress] = []
    interrupted = False
    with folder.store:
        summary.check_summary(folder, study.force)  # before the work begins
        study.write_junit(lambda: _junit(what, []))
        with study.telling() as tell:

            def reach(now: Progress) -> None:
                reached[:] = [now]
                tell(with_words(CASES, f"{now.failed} failed" if now.failed else ""), now.whole - now.left, now.whole)

            try:
                _run(wanted, what, folder, reach)
            except KeyboardInterrupt:
                interrupted = True
        if not reached:  # the sweep has not begun
            raise KeyboardInterrupt
        (progress,) = reached
        written = summary.write_summary(what, folder, study.force)
        rows = tuple(map(tuple, summary.cells(what, summary.entries(what, folder)))) if study.writes_table else ()
        study.write_junit(lambda: _junit(what, summary.entries(what, folder)))
        kinds = _failures(summary.entries(what, folder)) if progress.failed else []
    study.hand_over(
        Table(tuple(summary.headings(what)), rows),
        _counts_in_words(progress, kinds),
        report_of(SWEEP, progress, failures=kinds),
        lambda: usual_of_sweep(folder.arrays),
        beside=written,
    )
    if interrupted:
        more = _command_to_continue(wanted.spec, output, wanted.timeout, wanted.retry_failed)
        click.echo(f"interrupted; go on with: {more}", err=True)
        return int(ExitCode.INTERRUPTED)
    return int(ExitCode.FAILED if progress.failed else ExitCode.DONE)


def _command_to_continue(spec: Path, output: Path | None, timeout: float | None, retry_failed: bool) -> str:
    """The command line that computes the cases that are left."""
    words = ["mbproj", "sweep", str(spec)]
    words += [] if output is None else ["-o", str(output)]
    words += [] if timeout is None else ["--timeout", f"{timeout:g}"]
    return shlex.join(words + ["--retry-failed"] * retry_failed)


def _confirm_number(spec: SweepSpec, yes: bool) -> None:
    """Raises InputError where there are so many cases that it may be a mistake, unless `yes`."""
    from mbproj.base.errors import InputError, Problem

    count = spec.design.count
    if count > MANY and not yes:
        place = spec.place("samples") or spec.place("vary")
        raise InputError(Problem(f"this makes {count} cases", place, "add --yes if you mean it, or vary less"))


def _preview(spec: SweepSpec, shown: int) -> str:
    """The number of cases, and the first of them."""
    from mbproj.commands.report.text import columns
    from mbproj.scene.ranges import column_of, with_unit

    design = spec.design
    count = f"{design.count} {'case' if design.count == 1 else 'cases'} ({design.name})"
    names = [with_unit(column_of(path), spec.units[path]) for path in design.paths]
    rows = [[str(number), *map(_item, design.case(number))] for number in range(min(design.count, shown))]
    more = [] if design.count <= shown else ["..."]
    measures = f"measured: {', '.join(with_unit(each.name, each.unit) for each in spec.measures)}"
    return "\n".join([count, "", columns(["case", *names], rows), *more, "", measures])


def _item(value: Item) -> str:
    return f"{value:.10g}" if isinstance(value, float) else value


def _failures(entries: Iterable[CaseEntry]) -> list[dict[str, Any]]:
    """The failed cases by their message, most frequent first: each message with its number of cases and the first of
    them."""
    causes: dict[str, dict[str, Any]] = {}
    for number, entry in enumerate(entries):
        if entry.row is None or entry.status == "done":
            continue
        known = causes.setdefault(
            entry.row.message, {"message": entry.row.message, "status": entry.status, "count": 0, "first_case": number}
        )
        known["count"] += 1
    return sorted(causes.values(), key=lambda kind: -int(kind["count"]))


def _counts_in_words(reached: Progress, kinds: list[dict[str, Any]]) -> str:
    """The numbers of cases, and the kinds of failure."""
    left = f", {reached.left} left" if reached.left else ""
    arrays = f" ({reached.by_arrays} by arrays)" if reached.by_arrays else ""
    counts = f"{reached.computed} computed{arrays}, {reached.reused} reused, {reached.failed} failed{left}"
    lines = [f"{reached.whole} {'case' if reached.whole == 1 else 'cases'}: {counts}"]
    for kind in islice(kinds, KINDS):
        lines.append(f"  {kind['count']} {kind['status']}, the first is case {kind['first_case']}: {kind['message']}")
    if len(kinds) > KINDS:
        lines.append(f"  and {len(kinds) - KINDS} other messages, in summary.csv")
    return "\n".join(lines)


def _junit(spec: SweepSpec, entries: Iterable[CaseEntry]) -> str:
    """A testsuite with a testcase for each case."""
    from mbproj.commands.report.junit import TestCase, cases_as_xml

    testcases = []
    for number, entry in enumerate(entries):
        values = ", ".join(
            f"{path}={_item(value)}" for path, value in zip(spec.design.paths, entry.values, strict=True)
        )
        if entry.row is None:
            testcases.append(TestCase(f"{number}: {values}", 0.0, "skipped", entry.status))
        else:
            ended = () if entry.status == "done" else ("error", entry.row.message, entry.status)
            testcases.append(TestCase(f"{number}: {values}", entry.row.seconds, *ended))
    return cases_as_xml(spec.path, testcases)
