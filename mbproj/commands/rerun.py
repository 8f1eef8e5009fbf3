"""`mbproj rerun` and `mbproj.rerun`: repeats a run, from its results file alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mbproj.commands.declared import Asked, command_of, declared
from mbproj.commands.options import SomeResults, json_option, output_option, quiet_option, results_file

if TYPE_CHECKING:
    from mbproj.commands.results import Results
    from mbproj.motion.simulate import Progress
    from mbproj.results import record
    from mbproj.scene.scene import Scene

EXAMPLES = (("Repeat a run whose scene is no longer at hand.", "mbproj rerun results.h5 -o again.h5"),)


@declared
def rerun(results: SomeResults, *, output: str | Path | None = None, progress: Progress | None = None) -> Results:
    """Repeats the run that wrote results, with the same scene and settings.

    On the same build and machine the numbers are the same to the last bit.

    In Python `output` and the errors raised are as in `run`.
    """
    from mbproj.commands.run import run_to_file
    from mbproj.commands.stored_run import opened

    with opened(results) as before:
        scene, limits = _repeated(before, output)
    return run_to_file(scene, output, limits, progress)


def _repeated(before: record.Results, output: str | Path | None) -> tuple[Scene, tuple[float, ...] | None]:
    """The scene of a run, and the limits of its certificate."""
    from mbproj.commands.stored_run import require_another, require_whole, stored_scene

    require_whole(before)
    scene = stored_scene(before)
    if output is not None:
        require_another(str(output), before.path, "to repeat")
    return scene, before.certified


@command_of(rerun, EXAMPLES, output_option("rerun.h5", results_file(), "New results file."), json_option, quiet_option)
def command(asked: Asked[Results], output: str, as_json: bool, quiet: bool) -> None:
    from mbproj.commands.execute import execute
    from mbproj.results.reader import open_results

    with open_results(asked.given["results"]) as before:
        scene, limits = _repeated(before, output)
    execute(scene, output, limits=limits, as_json=as_json, quiet=quiet)
