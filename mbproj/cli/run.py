"""`mbproj run`: scene -> system -> consistent start -> simulation -> results file, and a summary."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from mbproj.cli.scene_options import overrides, parameters, scene_options
from mbproj.errors import SimulationError, placed_at


@contextmanager
def _what_is_kept(output: str) -> Iterator[None]:
    """Says where the results of a run are that did not end well."""
    try:
        yield
    except (SimulationError, KeyboardInterrupt):
        click.echo(f"note: what was computed until then is in {output}", err=True)
        raise


@click.command("run")
@scene_options
@click.option("-o", "--output", default="results.h5", show_default=True, type=click.Path(), help="Results file.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of the summary.")
@click.option("-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def command(scene: str, settings: tuple[str, ...], output: str, as_json: bool, quiet: bool, **options: Any) -> None:
    """Simulates SCENE and writes a results file."""
    from time import perf_counter

    from mbproj.cli.progress import progress_bar
    from mbproj.cli.summary import print_summary, summary
    from mbproj.dynamics import assemble
    from mbproj.integrate import simulate
    from mbproj.model import compile_system, initial_guess
    from mbproj.results import ResultsWriter
    from mbproj.scene import read_scene, settings_to_run

    started = perf_counter()
    what = read_scene(scene, parameters(settings), overrides(options))
    how = settings_to_run(what)
    system = compile_system(what)
    state = assemble(system, initial_guess(what, system))
    with (
        _what_is_kept(output),
        placed_at(what.place("simulation", "projection", "method")),
        ResultsWriter(output, what, system.names.as_mapping()) as recorder,
        progress_bar(how.duration, hidden=quiet or as_json) as progress,
    ):
        report = simulate(system, state, how, recorder, progress)
        numbers = summary(scene, output, report, total_seconds=perf_counter() - started)
        recorder.attributes(numbers)
    if as_json:
        import json

        click.echo(json.dumps(numbers))
    elif not quiet:
        print_summary(what.title or Path(scene).stem, system, report, numbers)
