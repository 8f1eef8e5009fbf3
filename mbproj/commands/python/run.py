"""`mbproj.run`: simulate a scene and record the results in one call, as `mbproj run` does."""

from __future__ import annotations

import os
import weakref
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.errors import InputError, Place, Problem, placed_at, warn_caller, warn_once
from mbproj.commands.declared import declared, read
from mbproj.commands.options import RunSettings
from mbproj.commands.python.arguments import Quantity, SceneLike, amount, by_arguments
from mbproj.commands.python.results import Results
from mbproj.equations.assembly.compiled import compile_system
from mbproj.kernel import fingerprint
from mbproj.motion.simulate import Progress
from mbproj.motion.stepwise import Stepwise
from mbproj.results import record
from mbproj.results.crash_safety import Checkpoint
from mbproj.results.file.opening import is_locked
from mbproj.results.reader import open_results, opened_own
from mbproj.scene.sampling import output_interval
from mbproj.scene.scene import Scene, read_scene_text
from mbproj.scene.settings import placed_in, settings_to_run
from mbproj.studies.record import Acting, Earlier, record_run, start_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbproj.motion.stepwise import Function
    from mbproj.studies.certify import Certified


_NOTHING: Mapping[str, object] = {}


@declared
def run(
    scene: SceneLike,
    *,
    parameters: Mapping[str, object] = _NOTHING,
    certify: bool = False,
    limits: Sequence[float] = (),
    controller: Function | None = None,
    period: float | None = None,
    output: str | Path | None = None,
    progress: Progress | None = None,
    **settings: Unpack[RunSettings],
) -> Results:
    """Simulates a scene, and returns its results.

    `scene` is a `Scene`, the path of a file, a text of several lines, or a mapping. Settings are those of `mbproj run`:
    numbers in SI units, or text with a unit ("1 ms"). `parameters` changes parameters, or values by their paths, such
    as {"bodies.bar1.mass": 2}. `certify` computes a better solution too: `results.trust` tells how long the error
    of each marker stays below each of `limits` in m.

    At the start and each `period` in s after it, `controller(t, signals)` returns states of the scene, by name, that
    are then set. Such a run cannot be continued from its file. `progress` is called with the time reached in s.

    Results go to the file `output`, or to a temporary file that is removed with the object. Raises InputError where the
    scene is wrong, SimulationError where the run cannot go on; `output` then keeps the samples so far.
    """
    asked = read(run, locals())
    if limits and not certify:
        raise InputError(Problem("it needs a certificate", Place("limits"), "add certify=True, or leave it out"))
    if controller is None and period is not None:
        raise InputError(Problem("it is that of a controller", Place("period"), "add controller=f, or leave it out"))
    if controller is not None and certify:
        raise InputError(Problem("a controller from Python is not certified", Place("certify"), "leave it out"))
    outside = None if controller is None else (controller, period)
    if not certify:
        return run_to_file(asked.scene, output, None, progress, outside=outside)
    from mbproj.studies.certify import limits_of

    return run_to_file(asked.scene, output, limits_of(limits), progress)


@declared
def start(
    scene: SceneLike, *, period: float, parameters: Mapping[str, object] = _NOTHING, **settings: Unpack[RunSettings]
) -> Stepwise:
    """Starts a run that waits at its start and each `period` (s) later. `run.advance(inputs={"u": 2.0})` sets states of
    the scene and goes on for a period; `run.signals`, `run.t` and `run.state` describe where it is.

    `scene`, `parameters` and `settings` are as in `run`. An input is a state that does not change by itself: `states:
    {u: {derivative: 0}}`. Raises InputError where the scene is wrong or cannot be run in this way.
    """
    if not (isinstance(period, int | float) and 0.0 < period < np.inf):
        raise InputError(Problem(f"it must be a time in s, found {period!r}", Place("period")))
    what = read(start, locals()).scene
    system = compile_system(what)
    with placed_in(what):
        return Stepwise(system, start_of(what, system), settings_to_run(what), float(period))


def run_to_file(
    scene: Scene,
    output: str | Path | None,
    limits: Sequence[float] | None,
    progress: Progress | None,
    earlier: Earlier | None = None,
    outside: Acting | None = None,
) -> Results:
    """Run a scene into the file `output`, or a temporary file that is removed with the results."""
    certified: Certified | None = None
    if limits is not None:
        from mbproj.studies.certify import Certified

        certified = Certified(limits)
    if output is not None:
        return _recorded(scene, output, certified, progress, earlier, outside)
    import shutil
    import tempfile

    folder = Path(tempfile.mkdtemp(prefix="mbproj-"))
    try:
        results = _recorded(scene, folder / "results.h5", certified, progress, earlier, outside)
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    weakref.finalize(results.contents, shutil.rmtree, folder, ignore_errors=True)
    return results


def _recorded(
    scene: Scene,
    path: str | Path,
    certified: Certified | None,
    progress: Progress | None,
    earlier: Earlier | None,
    outside: Acting | None,
) -> Results:
    """Run a scene into a file at `path`, warn of notes that put its motion in doubt, and open it."""
    with placed_at(Place("--output")):
        run = record_run(scene, path, certified=certified, earlier=earlier, outside=outside, progress=progress)
    doubts = [note.text for note in run.notes if note.doubts_motion]
    if doubts:
        warn_caller("\n".join(doubts))
    return opened_own(path, Results)


# --- `mbproj.rerun` and `mbproj.continue_run` -------------------------------------------------------------------------
# Repeat or continue a run from its results.


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
    known = compile_system(scene).names
    for kind, names in {"joints": known.joints, "forces": known.forces, "states": known.states}.items():
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
