"""`mbproj run`: scene -> system -> consistent start -> simulation -> results file, and a summary."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.commands.options import (
    Part,
    Positive,
    explained,
    option,
    overrides,
    parameters,
    results_file,
    scene_options,
)

if TYPE_CHECKING:
    from mbproj.scene.scene import Scene

EXAMPLES = (
    ("Simulate with the settings of the scene, and write results.h5.", "mbproj run five_bar.yaml"),
    (
        "Take another step and another projection method.",
        'mbproj run five_bar.yaml --step "1 ms" --projection gopm -o gopm.h5',
    ),
    ("Say for how long the motion of each marker can be trusted.", "mbproj run five_bar.yaml --duration 2 --certify"),
)


@explained("run", EXAMPLES)
@scene_options
@option(
    Part.OUTPUT, "-o", "--output", default="results.h5", show_default=True, type=results_file(), help="Results file."
)
@option(
    Part.ACCURACY,
    "--accuracy",
    type=Positive("m"),
    metavar="E",
    help="Choose the cheapest integrator and step that keep the error of every marker below E.",
)
@option(
    Part.ACCURACY,
    "--certify",
    is_flag=True,
    help="Compute a better solution too, and say how long each marker can be trusted.",
)
@option(
    Part.ACCURACY,
    "--limit",
    "limits",
    multiple=True,
    type=Positive("m"),
    metavar="E",
    help="With --certify: say when the error exceeds E; repeatable [default: 1e-9, 1e-8, .. 1 m].",
)
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object instead of the summary.")
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def command(
    scene: str,
    settings: tuple[str, ...],
    output: str,
    accuracy: float | None,
    certify: bool,
    limits: tuple[float, ...],
    as_json: bool,
    quiet: bool,
    **options: Any,
) -> None:
    """Simulates SCENE and writes a results file."""
    from mbproj.base.errors import Place, placed_at
    from mbproj.commands.execute import execute
    from mbproj.results.crash_safety import check_output
    from mbproj.scene.scene import read_scene

    asked, changed = _limits(certify, limits), overrides(options)
    what, facts = read_scene(scene, parameters(settings), changed), dict[str, Any]()
    if accuracy is not None:
        with placed_at(Place("--output")):
            check_output(Path(output))  # before the work of choosing
        what, facts = _accurate(what, accuracy, changed, hidden=quiet)
    execute(what, output, limits=asked, attributes=facts, as_json=as_json, quiet=quiet)


def _accurate(scene: Scene, accuracy: float, changed: dict[str, str], hidden: bool) -> tuple[Scene, dict[str, Any]]:
    """The scene with the cheapest settings for an error, and facts on these for --json and the results file."""
    from dataclasses import replace

    from mbproj.base.errors import InputError, Place, Problem
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
    from mbproj.base.errors import InputError, Place, Problem

    if limits and not certify:
        raise InputError(Problem("needs --certify", Place("--limit"), "add --certify, or leave out --limit"))
    if not certify:
        return None
    from mbproj.studies.certify import limits_of

    return limits_of(limits)
