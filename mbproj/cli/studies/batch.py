"""`mbproj batch`: runs many scenes in parallel processes and checks their expectations."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.cli import study_options
from mbproj.cli.completion import FolderPath, scene_file
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.figure_options import drawn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.studies.batch import SceneResult

#: The largest timeout (s) of a scene: 30 years, which every clock can count.
LONGEST = 1e9
KEEP = "Keep the results files in DIR. What is complete there is only checked again."
EXAMPLES = (
    ("Run a scene and all scenes of a folder, and check what they expect.", "mbproj batch five_bar.yaml validation"),
    ("Run all scenes below this folder in a pipeline.", 'mbproj batch "**/*.yaml" --junit report.xml --keep results'),
)


@explained("batch", EXAMPLES)
@click.argument("paths", nargs=-1, required=True, type=scene_file(path_type=Path))
@study_options.study
@option(
    Part.EFFORT, "--timeout", default="5 min", show_default=True, metavar="TIME", help="Stop a scene that runs longer."
)
@study_options.junit
@option(Part.OUTPUT, "--keep", type=FolderPath(path_type=Path), metavar="DIR", help=KEEP)
@option(Part.EFFORT, "--resume", is_flag=True, hidden=True, help="What --keep does anyway, without --fresh.")
@drawn
def command(
    paths: tuple[Path, ...],
    timeout: str,
    keep: Path | None,
    resume: bool,
    **options: Any,
) -> int:
    """Runs many scenes and checks their `expect` blocks.

    PATHS are scene files, directories, or patterns ('**/*.yaml').

    Prints a table: scene, result, how many expectations hold, seconds, and the expectation nearest to its limit with
    its error and the error allowed. A scene that fails does not stop the others. With --keep, an interrupted batch
    resumes where it stopped: complete results of the same scene, by the same code, are only checked again.

    Exit code 0: all expectations hold; 3: a scene could not run (wrong input, a failure, the timeout); 4: all scenes
    ran, and an expectation does not hold; 2: wrong options, or no scenes.
    """
    from mbproj.calls.batch import Batch, handed_out
    from mbproj.cli.report import batch_table as table
    from mbproj.cli.report.junit import junit
    from mbproj.cli.study import Study
    from mbproj.errors import ExitCode
    from mbproj.scene.fields.given import given_number
    from mbproj.scene.fields.quantities import Number
    from mbproj.studies.batch import exit_code, run_batch, scene_paths

    seconds = given_number(timeout, "--timeout", Number("s", above=0.0, maximum=LONGEST))
    scenes = scene_paths(paths)
    study = Study(options, ("scene", "result"))
    study.write_junit(lambda: junit([]))
    results: dict[int, SceneResult] = {}
    rows = table.BatchRows([str(scene) for scene in scenes], shown=study.shows_table)

    def done(number: int, result: SceneResult) -> None:
        results[number] = result
        rows.show(results)
        tell("scenes", len(results), len(scenes))

    interrupted = False
    # the table shows the progress, too
    with (
        handed_out(scenes, keep, fresh=study.fresh, resume=resume) as tasks,
        study.telling(hidden=study.shows_table) as tell,
    ):
        tell("scenes", 0, len(scenes))
        try:
            run_batch(tasks, study.where, seconds, done)
        except KeyboardInterrupt:
            interrupted = True
    ended = [results[number] for number in sorted(results)]
    code = ExitCode.INTERRUPTED if interrupted else exit_code(ended)
    left = [scene for number, scene in enumerate(scenes) if number not in results]
    study.write_junit(lambda: junit(ended, left))
    rows.finish(results)
    study.hand_over(Batch(tuple(ended)).table, "", table.record(ended, left, code), lambda: _page(ended))
    for message in table.messages(ended):
        click.echo(message, err=True)
    if interrupted:
        click.echo("interrupted", err=True)
    return int(code)


def _page(ended: list[SceneResult]) -> Figure | str:
    """How much of its allowed error each expectation uses."""
    from mbproj.figures.pages.expectations import draw_expectations

    judged = [(each.scene, outcome) for each in ended for outcome in each.outcomes]
    shares = {f"{scene}: {outcome.expectation.name}": outcome.share for scene, outcome in judged}
    return draw_expectations(shares) if shares else "no expectation to draw"
