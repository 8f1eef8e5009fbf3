"""`mbproj sweep`: runs a family of mechanisms and tabulates the measured values."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.cli import study_options
from mbproj.cli.completion import FolderPath, scene_file
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.figure_options import check_picture, drawn
from mbproj.cli.quantity import Positive
from mbproj.cli.report.text import json_text

if TYPE_CHECKING:
    from mbproj.studies.sweep.run import Progress
    from mbproj.studies.sweep.spec import SweepSpec

#: The cases that --dry-run prints, and the number of cases that needs a confirmation.
SHOWN, MANY = 8, 1_000_000
OTHER_REPORT = "choose another file with --junit"
EXAMPLES = (
    ("See what would run.", "mbproj sweep lengths.yaml --dry-run"),
    ("Run it, or go on with it where it was interrupted.", "mbproj sweep lengths.yaml"),
    ("Give up when more than ten cases fail or hang.", "mbproj sweep lengths.yaml --max-failures 10 --timeout 30"),
)


@explained("sweep", EXAMPLES)
@click.argument("spec", type=scene_file(path_type=Path))
@study_options.workplace
@option(Part.EFFORT, "--timeout", type=Positive("s"), metavar="TIME", help="Stop a case that runs longer.")
@option(
    Part.EFFORT,
    "--max-failures",
    "most_failures",
    type=click.IntRange(0),
    metavar="K",
    help="Stop when more than K cases have failed.",
)
@option(Part.EFFORT, "--retry-failed", is_flag=True, help="Run cases again that have failed before.")
@option(Part.EFFORT, "--fresh", is_flag=True, help="Begin anew: forget what an earlier sweep has done in DIR.")
@option(Part.EFFORT, "--dry-run", "dry", is_flag=True, help="Count the cases and print the first ones; run nothing.")
@option(Part.EFFORT, "--yes", is_flag=True, help=f"Run more than {MANY} cases.")
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    type=FolderPath(path_type=Path),
    metavar="DIR",
    help="Directory of the sweep [default: <spec>-sweep].",
)
@option(Part.OUTPUT, "--junit", "xml", type=click.Path(path_type=Path), metavar="FILE", help="Write JUnit XML.")
@drawn
@study_options.force
@study_options.write_table
@study_options.as_json
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def command(
    spec: Path,
    timeout: float | None,
    most_failures: int | None,
    retry_failed: bool,
    fresh: bool,
    dry: bool,
    yes: bool,
    output: Path | None,
    xml: Path | None,
    picture_path: Path | None,
    force: bool,
    table_file: Path | None,
    as_json: bool,
    quiet: bool,
    **options: Any,
) -> int:
    """Runs a family of mechanisms and tabulates what it measures.

    SPEC is a YAML file: a scene, what varies in it, what is measured. Writes summary.csv and summary.h5 into DIR.
    Finished cases are kept there: the same command goes on where it was interrupted, and after a change of SPEC only
    new cases are computed.

    Exit code 0: all cases ran; 3: some failed, and the table says why; 2: wrong input; 130: interrupted, and the table
    has what was computed.
    """
    from mbproj.cli.report import sweep as report
    from mbproj.cli.studies.sweep_pictures import draw_usual
    from mbproj.errors import ExitCode
    from mbproj.outputs import JUNIT, write_text
    from mbproj.outputs.written_table import check_table
    from mbproj.outputs.written_table import write_table as write_for_paper
    from mbproj.studies.sweep import summary
    from mbproj.studies.sweep.folder import Folder as SweepFolder
    from mbproj.studies.sweep.run import run_sweep
    from mbproj.studies.sweep.spec import read_spec

    what = read_spec(spec)
    if dry:
        click.echo(report.preview(what, SHOWN))
        return int(ExitCode.DONE)
    _confirm_number(what, yes)
    where = study_options.where_of(options)
    folder = SweepFolder(output or spec.with_name(f"{spec.stem}-sweep"), what, fresh)
    interrupted = False
    with folder.store:
        summary.check_summary(folder, force)  # before the work begins
        check_table(table_file, ("case",), force=force)
        check_picture(picture_path, force=force)
        if xml is not None:
            write_text(xml, report.junit(what, []), JUNIT, force=force, hint=OTHER_REPORT)
        with report.showing(hidden=as_json or quiet) as tell:
            try:
                run_sweep(
                    what,
                    folder,
                    where,
                    timeout=timeout,
                    most_failures=most_failures,
                    retry_failed=retry_failed,
                    tell=tell,
                )
            except KeyboardInterrupt:
                interrupted = True
        reached = tell.reached
        if reached is None:  # the sweep has not begun
            raise KeyboardInterrupt
        written = summary.write_summary(what, folder, force)
        if table_file is not None:
            rows = summary.cells(what, folder)
            written.append(write_for_paper(table_file, summary.headings(what), rows, force=force))
        if xml is not None:
            write_text(xml, report.junit(what, summary.entries(what, folder)), JUNIT, force=force, hint=OTHER_REPORT)
        failures = report.failures(summary.entries(what, folder))
    if picture_path is not None:
        picture = draw_usual(folder.arrays, picture_path, force=force)
        if not quiet:
            click.echo(picture, err=True)
    numbers = _numbers(reached, written)
    if as_json:
        click.echo(json_text({**numbers, "failures": failures}))
    elif not quiet:
        click.echo(report.said(reached, failures))
        for path in written:
            click.echo(path)
    if interrupted:
        click.echo(f"interrupted; go on with: {_command_to_continue(spec, output, timeout, retry_failed)}", err=True)
        return int(ExitCode.INTERRUPTED)
    return int(ExitCode.FAILED if reached.failed else ExitCode.DONE)


def _command_to_continue(spec: Path, output: Path | None, timeout: float | None, retry_failed: bool) -> str:
    """The command line that computes the cases that are left."""
    words = ["mbproj", "sweep", str(spec)]
    words += [] if output is None else ["-o", str(output)]
    words += [] if timeout is None else ["--timeout", f"{timeout:g}"]
    return shlex.join(words + ["--retry-failed"] * retry_failed)


def _confirm_number(spec: SweepSpec, yes: bool) -> None:
    """Raises InputError where there are so many cases that it may be a mistake, unless `yes`."""
    from mbproj.errors import InputError, Problem

    count = spec.design.count
    if count > MANY and not yes:
        place = spec.place("samples") or spec.place("vary")
        raise InputError(Problem(f"this makes {count} cases", place, "add --yes if you mean it, or vary less"))


def _numbers(reached: Progress, written: list[Path]) -> dict[str, Any]:
    return {
        "cases": reached.whole,
        "computed": reached.computed,
        "by_arrays": reached.by_arrays,
        "reused": reached.reused,
        "failed": reached.failed,
        "left": reached.left,
        "files": [str(path) for path in written],
    }
