"""What `run` and `rerun` share: from a scene that was read to a results file and a summary."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import TYPE_CHECKING

import click

from mbproj.errors import Place, SimulationError, placed_at

if TYPE_CHECKING:
    from mbproj.scene import Scene


def execute(scene: Scene, name: str, output: str, *, as_json: bool, quiet: bool) -> None:
    """Simulates `scene`, which the summary calls `name`, writes `output`, and prints what is asked for."""
    from mbproj.cli.progress import progress_bar
    from mbproj.cli.summary import print_summary, summary
    from mbproj.dynamics import assemble, unique_components
    from mbproj.integrate import simulate
    from mbproj.model import compile_system, initial_guess
    from mbproj.results import ResultsWriter
    from mbproj.scene import settings_to_run

    started = perf_counter()
    settings = settings_to_run(scene)
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    with placed_at(Place("--output")):
        writer = ResultsWriter(output, scene, system.names.as_mapping(), unique_components(system, state))
    with (
        _what_is_kept(name, output, as_json),
        placed_at(scene.place("simulation", "projection", "method")),
        writer as recorder,
        progress_bar(settings.duration, hidden=quiet or as_json) as progress,
    ):
        report = simulate(system, state, settings, recorder, progress)
        numbers = summary(name, output, report, total_seconds=perf_counter() - started)
        recorder.attributes(numbers)
    if as_json:
        click.echo(json.dumps(numbers))
    elif not quiet:
        print_summary(scene.title or name, system, report, numbers)


@contextmanager
def _what_is_kept(name: str, output: str, as_json: bool) -> Iterator[None]:
    """Says where the results of a run are that did not end well; a program gets its object all the same."""
    try:
        yield
    except (SimulationError, KeyboardInterrupt) as error:
        click.echo(f"note: what was computed until then is in {output}", err=True)
        if as_json:
            status = f"failed: {error}" if isinstance(error, SimulationError) else "interrupted"
            click.echo(json.dumps({"scene": name, "output": output, "status": status}))
        raise
