"""`mbproj continue` and `mbproj.continue_run`: continues a run from its results file, to the last bit as one long
run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from mbproj.base.errors import InputError, Place, Problem, warn_once
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.kinds import Positive
from mbproj.commands.options import Option, Part, SomeResults, json_option, output_option, quiet_option, results_file

if TYPE_CHECKING:
    from mbproj.commands.arguments import Quantity
    from mbproj.commands.results import Results
    from mbproj.motion.simulate import Progress
    from mbproj.results import record
    from mbproj.results.crash_safety import Checkpoint
    from mbproj.scene.scene import Scene
    from mbproj.studies.record import Earlier

EXAMPLES = (
    ("Go on with a run until 20 s; the new file has what follows.", "mbproj continue results.h5 --until 20"),
    ("Put all samples, old and new, into one file.", "mbproj continue results.h5 --until 20 --append -o all.h5"),
)
Until = Annotated[
    "Quantity | None",
    Option(
        Part.WHAT,
        "Where the run then ends, from its original start [default: its own end].",
        Positive("s"),
        "TIME",
        names=("--until", "--duration"),
    ),
]
Append = Annotated[bool, Option(Part.OUTPUT, "Put all samples, old and new, into -o [default: RESULTS itself].")]


@declared
def continue_run(
    results: SomeResults,
    *,
    until: Until = None,
    output: str | Path | None = None,
    append: Append = False,
    progress: Progress | None = None,
) -> Results:
    """Continues the run that wrote results, also a killed one.

    On the same build and machine the numbers are those of one long run, to the last bit.

    In Python it returns the samples that follow, in the file `output` or a temporary one. With `append`, they are all
    samples, old and new, and replace `results` where there is no `output`. Raises InputError where the run cannot be
    continued.
    """
    from mbproj.commands.run import run_to_file
    from mbproj.commands.stored_run import opened

    asked = read(continue_run, locals())
    with opened(results) as before:
        scene, earlier = _continued(before, asked.until, append)
        return run_to_file(scene, _file(before, output, append), None, progress, earlier)


OUTPUT = output_option(None, results_file(), "New results file, with the samples that follow [default: continued.h5].")


@command_of(continue_run, EXAMPLES, OUTPUT, json_option, quiet_option, name="continue")
def command(asked: Asked[Results], output: str | None, as_json: bool, quiet: bool) -> None:
    from mbproj.commands.execute import execute
    from mbproj.results.reader import open_results

    append = asked.given["append"]
    with open_results(asked.given["results"]) as before:
        scene, earlier = _continued(before, asked.given.get("until"), append)
        where = _file(before, output or (None if append else "continued.h5"), append)
        execute(scene, str(where), earlier=earlier, as_json=as_json, quiet=quiet)


def _continued(before: record.Results, until: float | None, append: bool) -> tuple[Scene, Earlier]:
    """The scene of the longer run, and the run that it goes on with. Raises InputError where it cannot go on."""
    from mbproj.commands.stored_run import stored_scene
    from mbproj.studies.record import Earlier

    checkpoint = _checkpoint_of(before)
    return _longer(stored_scene(before), checkpoint, until, before), Earlier(checkpoint, before if append else None)


def _file(before: record.Results, output: str | Path | None, append: bool) -> str | Path | None:
    """The file of a continued run; None where it is open. Raises InputError where new samples alone would replace the
    old ones."""
    from mbproj.commands.stored_run import require_another

    if append and output is None:
        return str(before.path).removesuffix(".part") if before.partial else before.path
    if output is not None and not append:
        require_another(str(output), before.path, "to go on with")
    return output


def _checkpoint_of(before: record.Results) -> Checkpoint:
    """The state from which a run can be continued. Raises InputError where there is none, and where the run is still
    going on or has failed."""
    from mbproj.commands.stored_run import require_whole
    from mbproj.kernel import fingerprint
    from mbproj.results.file.opening import is_locked

    require_whole(before)
    if is_locked(before.path):
        raise InputError(Problem(f"the run that writes '{before.path}' still goes on", hint="wait for it, or stop it"))
    if before.status.startswith("failed"):
        message = f"'{before.path}': the run {before.status}; continued, it would fail at the same place"
        raise InputError(Problem(message, hint="mend the cause, and start with: mbproj run"))
    checkpoint = before.checkpoint
    if checkpoint is None:
        if before.status == "complete" and "integration_seconds" not in before.attributes:
            message = f"'{before.path}' holds no run that could be continued"
            raise InputError(Problem(message, hint="run the scene; --start equilibrium begins where it rests"))
        message = f"'{before.path}' has no state to continue from: an older mbproj wrote it, or it was killed too early"
        raise InputError(Problem(message, hint="start over with: mbproj rerun"))
    if checkpoint.build != fingerprint():
        what = f"'{before.path}' is by {checkpoint.build}, and this is {fingerprint()}"
        warn_once(f"{what}: the last bits may differ from those of one long run")
    return checkpoint


def _longer(scene: Scene, checkpoint: Checkpoint, until: float | None, before: record.Results) -> Scene:
    """The scene with the settings of the longer run; samples come at the same times as before. Raises InputError where
    the run has already reached its end."""
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
