"""`mbproj.run`: simulate a scene and record the results in one call, as `mbproj run` does."""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mbproj.api.arguments import Given, by_arguments, refuse_earlier_names, scene_of
from mbproj.api.results import Results
from mbproj.api.settings import RunSettings, options_of, with_settings
from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.errors import InputError, Place, Problem, placed_at, warn_caller
from mbproj.integrate.simulate import Progress
from mbproj.integrate.stepwise import Stepwise
from mbproj.results.reader import opened_own
from mbproj.runs.record import Acting, Certificate, Earlier, record_run, start_of
from mbproj.scene.read import Scene
from mbproj.scene.settings import placed_in, settings_to_run

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbproj.integrate.outside import Function

_NOTHING: Mapping[str, object] = {}


@with_settings
@refuse_earlier_names
def run(
    scene: Given,
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
    with by_arguments():
        options = options_of(settings, "run", "output", "certify", "limits", "controller", "period")
        if limits and not certify:
            raise InputError(Problem("it needs a certificate", Place("limits"), "add certify=True, or leave it out"))
        if controller is None and period is not None:
            raise InputError(
                Problem("it is that of a controller", Place("period"), "add controller=f, or leave it out")
            )
        if controller is not None and certify:
            raise InputError(Problem("a controller from Python is not certified", Place("certify"), "leave it out"))
        outside = None if controller is None else (controller, period)
        what = scene_of(scene, parameters, options)
        if not certify:
            return run_to_file(what, output, None, progress, outside=outside)
        from mbproj.studies.certify.horizon import limits_of

        return run_to_file(what, output, limits_of(limits), progress)


@with_settings
def start(
    scene: Given, *, period: float, parameters: Mapping[str, object] = _NOTHING, **settings: Unpack[RunSettings]
) -> Stepwise:
    """Starts a run that waits at its start and each `period` (s) later. `run.advance(inputs={"u": 2.0})` sets states of
    the scene and goes on for a period; `run.signals`, `run.t` and `run.state` describe where it is.

    `scene`, `parameters` and `settings` are as in `run`. An input is a state that does not change by itself: `states:
    {u: {derivative: 0}}`. Raises InputError where the scene is wrong or cannot be run in this way.
    """
    with by_arguments():
        if not (isinstance(period, int | float) and 0.0 < period < np.inf):
            raise InputError(Problem(f"it must be a time in s, found {period!r}", Place("period")))
        what = scene_of(scene, parameters, options_of(settings, "start", "period"))
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
    certified: Certificate | None = None
    if limits is not None:
        from mbproj.studies.certify.certified import Certified

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
    certified: Certificate | None,
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
