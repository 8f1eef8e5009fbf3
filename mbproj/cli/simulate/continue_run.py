"""`mbproj continue`: goes on with a run from its results file, to the bits of one long run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.cli.completion import results_file
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.quantity import Positive

if TYPE_CHECKING:
    from mbproj.results import Results
    from mbproj.results.crash_safety.checkpoint import Checkpoint
    from mbproj.scene import Scene

EXAMPLES = (
    ("Go on with a run until 20 s; the new file has what follows.", "mbproj continue results.h5 --until 20"),
    ("Put all samples, old and new, into one file.", "mbproj continue results.h5 --until 20 --append"),
)


@explained("continue", EXAMPLES)
@click.argument("results", type=results_file(path_type=Path))
@option(
    Part.WHAT,
    "--until",
    "--duration",
    "until",
    type=Positive("s"),
    metavar="TIME",
    help="Where the run then ends, from its original start [default: its own end].",
)
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    default="continued.h5",
    show_default=True,
    type=results_file(),
    help="New results file, with the samples that follow.",
)
@option(Part.OUTPUT, "--append", is_flag=True, help="Put all samples, old and new, in place of RESULTS.")
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object instead of the summary.")
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def command(results: Path, until: float | None, output: str, append: bool, as_json: bool, quiet: bool) -> None:
    """Goes on with the run that wrote RESULTS, or that a kill has ended.

    On the same build and machine the numbers are those of one long run, to the last bit.
    """
    from mbproj.cli.simulate.execute import Earlier, execute
    from mbproj.cli.simulate.stored_scene import require_another, stored_scene
    from mbproj.results import open_results

    with open_results(results) as before:
        checkpoint = _checkpoint(before, hidden=quiet)
        scene, name = stored_scene(before)
        if not append:
            require_another(output, before.path, "to go on with")
        execute(
            _longer(scene, checkpoint, until, before),
            name,
            str(results) if append else output,
            earlier=Earlier(checkpoint, before if append else None),
            as_json=as_json,
            quiet=quiet,
        )


def _checkpoint(before: Results, *, hidden: bool) -> Checkpoint:
    """The state to go on from. Raises InputError where there is none, or the run still goes on, or has failed."""
    from mbproj.errors import InputError, Problem
    from mbproj.kernel import fingerprint
    from mbproj.results.file.lock import is_locked

    if is_locked(before.path):
        raise InputError(Problem(f"the run that writes '{before.path}' still goes on", hint="wait for it, or stop it"))
    if before.status.startswith("failed"):
        message = f"'{before.path}': the run {before.status}; gone on with, it would fail at the same place"
        raise InputError(Problem(message, hint="mend the cause, and start with: mbproj run"))
    checkpoint = before.checkpoint
    if checkpoint is None:
        if before.status == "complete" and "integration_seconds" not in before.attributes:
            message = f"'{before.path}' holds no run: there is nothing to go on with"
            raise InputError(Problem(message, hint="run the scene; --from-equilibrium begins where it rests"))
        message = f"'{before.path}' has no state to go on from: an older mbproj wrote it, or a kill came too early"
        raise InputError(Problem(message, hint="start over with: mbproj rerun"))
    if checkpoint.build != fingerprint() and not hidden:
        what = f"'{before.path}' is by {checkpoint.build}, and this is {fingerprint()}"
        click.echo(f"note: {what}: the last bits may differ from those of one long run", err=True)
    return checkpoint


def _longer(scene: Scene, checkpoint: Checkpoint, until: float | None, before: Results) -> Scene:
    """The scene with the settings of the long run: samples come at the same times as before. Raises InputError where it
    would end before the state to go on from."""
    from dataclasses import replace

    from mbproj.errors import InputError, Place, Problem
    from mbproj.scene.sampling import output_interval

    settings = scene.settings
    assert settings.duration is not None
    reached = float(before.time[-1]) if len(before.time) else 0.0
    end = settings.duration if until is None else until
    if end <= reached:
        message = f"the run has already reached t = {reached:.9g} s"
        raise InputError(
            Problem(message, Place("--until"), f"say until when it is to go on, e.g. --until {2 * reached:g}")
        )
    interval = output_interval(settings) if settings.step is None else settings.output_step
    longer = replace(settings, duration=end, output_step=interval, formulation=checkpoint.formulation)
    return replace(scene, settings=longer)
