"""The common part of `run`, `rerun` and `continue`: record a run, show its notes, and print its summary."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import click

from mbproj.base.errors import Place, SimulationError, placed_at
from mbproj.commands.report.text import json_text
from mbproj.studies.record import Earlier, Interrupted, Run, record_run

if TYPE_CHECKING:
    from mbproj.results.notes import Note
    from mbproj.scene.scene import Scene


def execute(
    scene: Scene,
    output: str,
    *,
    limits: Sequence[float] | None = None,
    attributes: Mapping[str, Any] = MappingProxyType({}),
    earlier: Earlier | None = None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run `scene` into `output` and print the summary. `limits` are the errors (m) for which trust horizons are
    computed. `attributes` are added to the file and to --json. `earlier` is the run that this one continues."""
    from mbproj.commands.report.progress import progress_bar, telling
    from mbproj.commands.report.summary import print_summary
    from mbproj.scene.settings import settings_to_run

    shown = 0

    def show(note: Note) -> None:
        nonlocal shown
        shown += 1
        if not quiet:
            click.echo(note, err=True)

    with (
        _results_kept(scene, certified=limits is not None, as_json=as_json, quiet=quiet),
        placed_at(Place("--output")),
        progress_bar(settings_to_run(scene).duration, hidden=quiet) as progress,
        telling(hidden=progress is None or limits is None) as tell,
    ):
        certified = None
        if limits is not None:
            from mbproj.studies.certify import Certified

            certified = Certified(tuple(limits), tell)
        run = record_run(
            scene,
            output,
            certified=certified,
            earlier=earlier,
            progress=progress,
            attributes=attributes,
            tell=show,
        )
    if as_json:
        click.echo(json_text(numbers(run)))
    elif not quiet:
        print_summary(run)
    for note in run.notes[shown:]:
        show(note)


def numbers(run: Run) -> dict[str, Any]:
    """The run as a dictionary for JSON."""
    from mbproj.commands.report import summary as expectations
    from mbproj.results.report_schema.facts import report_of
    from mbproj.results.report_schema.runs import NOTES

    has: dict[str, Any] = {**run.attributes, **report_of((NOTES,), run)}
    if run.trust is not None:
        from mbproj.commands.report.summary import as_numbers

        has["trust"] = as_numbers(run.trust)
    rubbed = {"frictions": run.frictions, "creep": run.creep, "ropes_that_push": run.ropes or None}
    has |= {name: each for name, each in rubbed.items() if each is not None}
    return {**has, "expectations": [expectations.record(outcome) for outcome in run.outcomes]}


@contextmanager
def _results_kept(scene: Scene, *, certified: bool, as_json: bool, quiet: bool) -> Iterator[None]:
    """Tell where the results of a failed or interrupted run are, and how far they can be trusted if they were to be
    certified. With --json, print the object in this case too."""
    try:
        yield
    except (SimulationError, Interrupted) as error:
        if error.output is None:
            raise
        from mbproj.commands.report.summary import as_numbers, lines_on
        from mbproj.results.reader import open_own_results

        output, interrupted, trust, how = str(error.output), isinstance(error, Interrupted), None, ""
        if interrupted or certified:
            with open_own_results(output) as results:
                trust, goes_on = results.trust, interrupted and results.checkpoint is not None
            how = f"; go on with: mbproj continue {shlex.quote(output)}" if goes_on else ""
        click.echo(f"note: what was computed until then is in {output}{how}", err=True)
        if as_json:
            status = "interrupted" if interrupted else f"failed: {error}"
            known = {"scene": str(scene.path or "scene"), "output": output, "status": status}
            click.echo(json_text(known if trust is None else {**known, "trust": as_numbers(trust)}))
        elif trust is not None and not quiet:
            click.echo("\n".join(lines_on(trust)))
        raise
