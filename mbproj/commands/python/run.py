"""`mbproj.rerun` and `mbproj.continue_run`: repeat or continue a run from its results."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from mbproj.api.arguments import Quantity, amount, by_arguments
from mbproj.api.results import Results
from mbproj.api.run import run_to_file
from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.errors import InputError, Place, Problem, warn_once
from mbproj.integrate.simulate import Progress
from mbproj.kernel import fingerprint
from mbproj.results import open_results, record
from mbproj.results.crash_safety.checkpoint import Checkpoint
from mbproj.results.file.lock import is_locked
from mbproj.runs.record import Earlier
from mbproj.scene import read_scene_text
from mbproj.scene.read import Scene
from mbproj.scene.sampling import output_interval


def rerun(
    results: record.Results | str | Path, *, output: str | Path | None = None, progress: Progress | None = None
) -> Results:
    """Repeats the run that wrote `results`, with the same scene and settings.

    `output` and the errors raised are as in `run`. On the same build and machine the numbers are the same to the last
    bit.
    """
    with by_arguments(), opened(results) as before:
        require_whole(before)
        scene = stored_scene(before)
        if output is not None:
            require_another(str(output), before.path, "to repeat")
        limits = before.certified
    with by_arguments():
        return run_to_file(scene, output, limits, progress)


def continue_run(
    results: record.Results | str | Path,
    *,
    until: Quantity | None = None,
    output: str | Path | None = None,
    append: bool = False,
    progress: Progress | None = None,
) -> Results:
    """Continues the run that wrote `results`, also a killed one, to the time `until` in s from its start.

    Returns the samples that follow, in the file `output` or a temporary one. With `append`, they are all samples, old
    and new, and replace `results` where there is no `output`. Raises InputError where the run cannot be continued. On
    the same build and machine the numbers are those of one long run, to the last bit.
    """
    with by_arguments(), opened(results) as before:
        checkpoint = checkpoint_of(before)
        end = None if until is None else amount(until, "until", "s", above=0.0)
        scene = longer(stored_scene(before), checkpoint, end, before)
        where = continued_in(before, output, append=append)
        return run_to_file(scene, where, None, progress, Earlier(checkpoint, before if append else None))


def continued_in(before: record.Results, output: str | Path | None, *, append: bool) -> str | Path | None:
    """The file of a continued run; None where it is open. Raises InputError where new samples alone would replace the
    old ones."""
    if append and output is None:
        return str(before.path).removesuffix(".part") if before.partial else before.path
    if output is not None and not append:
        require_another(str(output), before.path, "to go on with")
    return output


@contextmanager
def opened(results: record.Results | str | Path) -> Iterator[record.Results]:
    """Yield results; open their file where a path is given."""
    if isinstance(results, record.Results):
        yield results
        return
    with open_results(results) as opened_results:
        yield opened_results


def stored_scene(results: record.Results) -> Scene:
    """The scene of a run. Messages name its file, or else the results. Raises InputError where it is damaged."""
    name = str(results.scene_path or results.path)
    scene = read_scene_text(results.scene_text, name, results.overrides)
    _require_all(scene, results)
    return replace(scene, path=results.scene_path, settings=results.settings)


def require_whole(results: record.Results) -> None:
    """Raises InputError where a Python function acted on the run, because the file does not contain the function."""
    if "controller_period" in results.attributes:
        message = f"'{results.path}': a function in Python acted on the run, and is not in the file"
        raise InputError(Problem(message, hint="run it again in Python, with controller=f"))


def _require_all(scene: Scene, results: record.Results) -> None:
    """Raises InputError where the run had joints, forces or states that its scene does not have."""
    own = compile_system(scene).names
    for kind, names in {"joints": own.joints, "forces": own.forces, "states": own.states}.items():
        others = [name for name in results.names(kind) if name not in names]
        if others:
            said = f"'{results.path}' has {kind} that its scene does not have: {', '.join(others)}"
            raise InputError(Problem(said, hint="elements from Python are not in the scene: go on in Python"))


def require_another(output: str, source: Path, what: str) -> None:
    """Raises InputError where new results would replace the results that they come from."""
    if os.path.realpath(output) == os.path.realpath(source):
        problem = Problem(f"'{output}' is the results file {what}", Place("--output"), "choose another name")
        raise InputError(problem)


def checkpoint_of(before: record.Results) -> Checkpoint:
    """The state from which a run can be continued. Raises InputError where there is none, and where the run is still
    going on or has failed."""
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


def longer(scene: Scene, checkpoint: Checkpoint, until: float | None, before: record.Results) -> Scene:
    """The scene with the settings of the longer run; samples come at the same times as before. Raises InputError where
    the run has already reached its end."""
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
