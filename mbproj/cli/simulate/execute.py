"""The common part of `run`, `rerun` and `continue`: simulate a scene, write its results file, print a summary."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from time import perf_counter
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import click

from mbproj.cli.report.text import json_text
from mbproj.errors import Place, SimulationError, placed_at

if TYPE_CHECKING:
    from mbproj.analysis import Outcome
    from mbproj.calls.recorded import Earlier
    from mbproj.scene import Scene


def execute(
    scene: Scene,
    name: str,
    output: str,
    *,
    certified: Sequence[float] | None = None,
    facts: Mapping[str, Any] = MappingProxyType({}),
    earlier: Earlier | None = None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Simulate `scene`, write `output` and print the summary, which calls the scene `name`. `certified` are the errors
    (m) for which trust horizons are computed. `facts` are added to the results file and --json. `earlier` is the run
    that this one continues."""
    from mbproj.calls.recorded import record, start_of
    from mbproj.cli.report import expectations
    from mbproj.cli.report.progress import progress_bar, telling
    from mbproj.cli.report.summary import print_summary
    from mbproj.cli.report.text import show_notes
    from mbproj.dynamics.rank.uniqueness import unique_components
    from mbproj.integrate.reporting.report import summary
    from mbproj.model import compile_system
    from mbproj.results import ResultsWriter
    from mbproj.scene import settings_to_run
    from mbproj.scene.settings import placed_in

    started = perf_counter()
    settings = settings_to_run(scene)
    system = compile_system(scene)
    if system.adjustments and not quiet:
        from mbproj.dynamics.assembly.adjust import adjustment_notes

        show_notes(adjustment_notes(scene, system))
    with placed_in(scene):
        state = start_of(scene, system)
    with placed_at(Place("--output")):
        constants = unique_components(system, state)
        writer = ResultsWriter(output, scene, system.names.as_mapping(), constants, certified=certified)
    with (
        _results_kept(name, output, as_json=as_json, quiet=quiet),
        placed_at(Place("--output")),
        writer as recorder,
        placed_in(scene),
        progress_bar(settings.duration, hidden=quiet) as progress,
    ):
        if recorder.set_aside is not None and not quiet:
            was, now = recorder.part, recorder.set_aside
            click.echo(f"note: '{was}', which a killed run had left, is kept as '{now}'", err=True)
        with telling(hidden=progress is None or certified is None) as tell:
            report, trust = record(scene, system, state, recorder, progress, certified, tell=tell, earlier=earlier)
        numbers = {**summary(name, output, report, total_seconds=perf_counter() - started), **facts}
        recorder.attributes(numbers)
    outcomes = [] if earlier is not None and earlier.results is None else _expected(scene, output)
    rubbed, frictions = _friction_history(scene, output)
    rubbed |= _pushes(scene, output)
    if as_json:
        certificate: dict[str, Any] = {}
        if trust is not None:
            from mbproj.cli.report.trust import as_numbers

            certificate["trust"] = as_numbers(trust)
        judged = [expectations.record(outcome) for outcome in outcomes]
        click.echo(json_text({**numbers, **certificate, **rubbed, "expectations": judged}))
    elif not quiet:
        print_summary(scene.title or name, system, report, numbers, trust, outcomes, frictions)


def _expected(scene: Scene, output: str) -> list[Outcome]:
    """The outcomes of the scene's expectations. The results are read only where there are expectations."""
    if not scene.expectations:
        return []
    from mbproj.analysis import outcomes
    from mbproj.results import open_own_results

    with open_own_results(output) as results:
        return outcomes(scene.expectations, results)


def _friction_history(scene: Scene, output: str) -> tuple[dict[str, Any], list[str]]:
    """The history of the run's dry frictions, for --json and as lines. The results are read only where there are
    frictions."""
    on_ropes = any(joint.parameters["path"].rubbing for joint in scene.joints if "path" in joint.parameters)
    if not (scene.forces or on_ropes):
        return {}, []
    from mbproj.scene.records import JointForce
    from mbproj.scene.stops import PlaneStop

    on_joints = any(isinstance(force, JointForce) and force.coulomb for force in scene.forces)
    if not (on_joints or on_ropes) and not any(
        isinstance(force, PlaneStop) and force.friction for force in scene.forces
    ):
        return {}, []
    from mbproj.analysis.contacts import creep, friction
    from mbproj.results import open_own_results

    with open_own_results(output) as results:
        rubbed, crept = friction.friction_records(results), creep.creep_by_friction(results, scene)
    lines = [f"friction '{name}': {friction.in_words(each)}" for name, each in rubbed.items()]
    lines += [f"friction '{name}': {creep.in_words(each)}" for name, each in crept.items()]
    return {"frictions": rubbed, "creep": crept}, lines


def _pushes(scene: Scene, output: str) -> dict[str, Any]:
    """The ropes that pushed, for --json. A note on each goes to stderr."""
    if not any("path" in joint.parameters for joint in scene.joints):
        return {}
    from mbproj.analysis.contacts.ropes import in_words, pushed_by_ropes
    from mbproj.results import open_own_results

    with open_own_results(output) as results:
        pushed = pushed_by_ropes(results, scene)
    for name, each in pushed.items():
        click.echo(f"note: {in_words(name, each)}", err=True)
    return {"ropes_that_push": pushed} if pushed else {}


@contextmanager
def _results_kept(name: str, output: str, *, as_json: bool, quiet: bool) -> Iterator[None]:
    """Tell where the results of a failed or interrupted run are, and how far they can be trusted if they were to be
    certified. With --json, print the object in this case too."""
    try:
        yield
    except (SimulationError, KeyboardInterrupt) as error:
        from mbproj.cli.report.trust import as_numbers, lines_on
        from mbproj.results import open_results

        with open_results(output) as results:
            trust, goes_on = results.trust, isinstance(error, KeyboardInterrupt) and results.checkpoint is not None
        how = f"; go on with: mbproj continue {shlex.quote(output)}" if goes_on else ""
        click.echo(f"note: what was computed until then is in {output}{how}", err=True)
        if as_json:
            status = f"failed: {error}" if isinstance(error, SimulationError) else "interrupted"
            numbers = {"scene": name, "output": output, "status": status}
            click.echo(json_text(numbers if trust is None else {**numbers, "trust": as_numbers(trust)}))
        elif trust is not None and not quiet:
            click.echo("\n".join(lines_on(trust)))
        raise
