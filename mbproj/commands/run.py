"""`mbproj run` and `mbproj.run`: scene -> system -> consistent start -> simulation -> results file, and a summary.

`mbproj.start` is a run that waits at its start and after each period.
"""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import click

from mbproj.base.errors import InputError, Place, Problem, placed_at, warn_caller
from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.kinds import Positive
from mbproj.commands.options import (
    NOTHING,
    Option,
    Part,
    RunSettings,
    json_option,
    option,
    output_option,
    quiet_option,
    results_file,
)

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbproj.commands.arguments import Quantity, SceneLike
    from mbproj.commands.results import Results
    from mbproj.motion.simulate import Progress
    from mbproj.motion.stepwise import Function, Stepwise
    from mbproj.scene.scene import Scene
    from mbproj.studies.certify import Certified
    from mbproj.studies.record import Acting, Earlier

EXAMPLES = (
    ("Simulate with the settings of the scene, and write results.h5.", "mbproj run five_bar.yaml"),
    (
        "Take another step and another projection method.",
        'mbproj run five_bar.yaml --step "1 ms" --projection gopm -o gopm.h5',
    ),
    ("Say for how long the motion of each marker can be trusted.", "mbproj run five_bar.yaml --duration 2 --certify"),
)
Certify = Annotated[
    bool, Option(Part.ACCURACY, "Compute a better solution too, and say how long each marker can be trusted.")
]
Limits = Annotated[
    "Sequence[Quantity] | Quantity",
    Option(
        Part.ACCURACY,
        "With --certify: say when the error exceeds E; repeatable [default: 1e-9, 1e-8, .. 1 m].",
        Positive("m"),
        "E",
        names=("--limit",),
        many=True,
    ),
]


@declared
def run(
    scene: SceneLike,
    *,
    parameters: Mapping[str, object] = NOTHING,
    certify: Certify = False,
    limits: Limits = (),
    controller: Function | None = None,
    period: float | None = None,
    output: str | Path | None = None,
    progress: Progress | None = None,
    **settings: Unpack[RunSettings],
) -> Results:
    """Simulates a scene and writes a results file.

    In Python it returns the results. `scene` is a `Scene`, the path of a file, a text of several lines, or a mapping.
    Settings are those of `mbproj run`: numbers in SI units, or text with a unit ("1 ms"). `parameters` changes
    parameters, or values by their paths, such as {"bodies.bar1.mass": 2}. `certify` computes a better solution too:
    `results.trust` tells how long the error of each marker stays below each of `limits` in m.

    At the start and each `period` in s after it, `controller(t, signals)` returns states of the scene, by name, that
    are then set. Such a run cannot be continued from its file. `progress` is called with the time reached in s.

    Results go to the file `output`, or to a temporary file that is removed with the object. Raises InputError where the
    scene is wrong, SimulationError where the run cannot go on; `output` then keeps the samples so far.
    """
    asked = read(run, locals())
    asked_limits = _limits(asked.certify, asked.limits)
    if controller is None and period is not None:
        raise InputError(Problem("it is that of a controller", Place("period"), "add controller=f, or leave it out"))
    if controller is not None and certify:
        raise InputError(Problem("a controller from Python is not certified", Place("certify"), "leave it out"))
    outside = None if controller is None else (controller, period)
    return run_to_file(asked.scene, output, asked_limits, progress, outside=outside)


ACCURACY = option(
    Part.ACCURACY,
    "--accuracy",
    type=Positive("m"),
    metavar="E",
    help="Choose the cheapest integrator and step that keep the error of every marker below E.",
)
OUTPUT = output_option("results.h5", results_file(), "Results file.")


@command_of(run, EXAMPLES, OUTPUT, ACCURACY, json_option, quiet_option)
def command(asked: Asked[Results], output: str, accuracy: float | None, as_json: bool, quiet: bool) -> None:
    from mbproj.commands.execute import execute
    from mbproj.results.crash_safety import check_output

    limits = _limits(asked.given["certify"], asked.given["limits"])
    scene, facts = asked.scene, dict[str, Any]()
    if accuracy is not None:
        with placed_at(Place("--output")):
            check_output(Path(output))  # before the work of choosing
        scene, facts = _accurate(scene, accuracy, asked.settings, hidden=quiet)
    execute(scene, output, limits=limits, attributes=facts, as_json=as_json, quiet=quiet)


def _accurate(scene: Scene, accuracy: float, changed: dict[str, str], hidden: bool) -> tuple[Scene, dict[str, Any]]:
    """The scene with the cheapest settings for an error, and facts on these for --json and the results file."""
    from mbproj.commands.report.progress import telling
    from mbproj.studies.recommend import Unreachable, recommend

    for name in ("integrator", "step", "tolerance"):
        if name in changed:
            hint = "leave out one of the two"
            raise InputError(Problem(f"--accuracy chooses the {name} itself", Place(f"--{name}"), hint))
    with telling(hidden) as tell:
        recommendation = recommend(scene, accuracy, timed=False, processes=1, tell=tell)
    if not recommendation.reached:
        raise Unreachable(
            f"no setting keeps the error below {accuracy:g} m beyond t = {recommendation.until:.6g} s: "
            f"{recommendation.why}; try --duration {recommendation.until:.6g}, or a larger error"
        )
    if not hidden:
        label, best = recommendation.setting.label, recommendation.best
        click.echo(f"{label}: off by {best.at():.1e} m at most, {best.evaluations:.0f} evaluations", err=True)
    facts = {
        "accuracy": accuracy,
        "accuracy_error": recommendation.best.at(),
        "accuracy_uncertainty": recommendation.uncertain,
    }
    return replace(scene, settings=recommendation.settings), facts


def _limits(certify: bool, limits: tuple[float, ...]) -> tuple[float, ...] | None:
    """The limits of a certificate, increasing; None where none is asked for."""
    if limits and not certify:
        raise InputError(Problem("needs --certify", Place("--limit"), "add --certify, or leave out --limit"))
    if not certify:
        return None
    from mbproj.studies.certify import limits_of

    return limits_of(limits)


@declared
def start(
    scene: SceneLike, *, period: float, parameters: Mapping[str, object] = NOTHING, **settings: Unpack[RunSettings]
) -> Stepwise:
    """Starts a run that waits at its start and each `period` (s) later. `run.advance(inputs={"u": 2.0})` sets states of
    the scene and goes on for a period; `run.signals`, `run.t` and `run.state` describe where it is.

    `scene`, `parameters` and `settings` are as in `run`. An input is a state that does not change by itself: `states:
    {u: {derivative: 0}}`. Raises InputError where the scene is wrong or cannot be run in this way.
    """
    if not (isinstance(period, int | float) and 0.0 < period < inf):
        raise InputError(Problem(f"it must be a time in s, found {period!r}", Place("period")))
    from mbproj.equations.assembly.compiled import compile_system
    from mbproj.motion.stepwise import Stepwise
    from mbproj.scene.settings import placed_in, settings_to_run
    from mbproj.studies.record import start_of

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
    from mbproj.commands.results import Results
    from mbproj.results.reader import opened_own
    from mbproj.studies.record import record_run

    with placed_at(Place("--output")):
        run = record_run(scene, path, certified=certified, earlier=earlier, outside=outside, progress=progress)
    doubts = [note.text for note in run.notes if note.doubts_motion]
    if doubts:
        warn_caller("\n".join(doubts))
    return opened_own(path, Results)
