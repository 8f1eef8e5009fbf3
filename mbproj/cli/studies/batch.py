"""`mbproj batch`: runs many scenes in parallel processes and checks their expectations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbproj.cli import study_options
from mbproj.cli.completion import FolderPath, scene_file
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.figure_options import check_picture, drawn
from mbproj.cli.report.text import json_text

if TYPE_CHECKING:
    from mbproj.studies.batch import SceneResult

#: The largest timeout (s) of a scene: 30 years, which every clock can count.
LONGEST = 1e9
OTHER_REPORT = "choose another file with --junit"
EXAMPLES = (
    ("Run a scene and all scenes of a folder, and check what they expect.", "mbproj batch five_bar.yaml validation"),
    ("Run all scenes below this folder in a pipeline.", 'mbproj batch "**/*.yaml" --junit report.xml --keep results'),
)


@explained("batch", EXAMPLES)
@click.argument("paths", nargs=-1, required=True, type=scene_file(path_type=Path))
@study_options.workplace
@option(
    Part.EFFORT, "--timeout", default="5 min", show_default=True, metavar="TIME", help="Stop a scene that runs longer."
)
@option(Part.OUTPUT, "--junit", "xml", type=click.Path(path_type=Path), metavar="FILE", help="Write JUnit XML.")
@option(Part.OUTPUT, "--keep", type=FolderPath(path_type=Path), metavar="DIR", help="Keep the results files in DIR.")
@option(Part.EFFORT, "--resume", is_flag=True, help="Do not run again what is complete in DIR, for the same scene.")
@drawn
@study_options.force
@study_options.write_table
@study_options.as_json
def command(
    paths: tuple[Path, ...],
    timeout: str,
    xml: Path | None,
    keep: Path | None,
    resume: bool,
    picture_path: Path | None,
    force: bool,
    table_file: Path | None,
    as_json: bool,
    **options: Any,
) -> int:
    """Runs many scenes and checks their `expect` blocks.

    PATHS are scene files, directories, or patterns ('**/*.yaml').

    Prints a table: scene, result, how many expectations hold, seconds, and the expectation nearest to its limit with
    its error and the error allowed. A scene that fails does not stop the others.

    Exit code 0: all expectations hold; 3: a scene could not run (wrong input, a failure, the timeout); 4: all scenes
    ran, and an expectation does not hold; 2: wrong options, or no scenes.
    """
    from mbproj.calls.batch import Batch, handed_out
    from mbproj.cli.report import batch_table as table
    from mbproj.cli.report.junit import junit
    from mbproj.cli.report.progress import telling
    from mbproj.errors import ExitCode
    from mbproj.outputs import JUNIT, write_text
    from mbproj.outputs.written_table import check_table, write_table
    from mbproj.scene.fields.given import given_number
    from mbproj.scene.fields.quantities import Number
    from mbproj.studies.batch import exit_code, run_batch, scene_paths

    seconds = given_number(timeout, "--timeout", Number("s", above=0.0, maximum=LONGEST))
    scenes = scene_paths(paths)
    where = study_options.where_of(options)
    check_table(table_file, ("scene", "result"), force=force)
    check_picture(picture_path, force=force)
    if xml is not None:
        # before the work, to see whether it can be written
        write_text(xml, junit([]), JUNIT, force=force, hint=OTHER_REPORT)
    results: dict[int, SceneResult] = {}
    rows = table.BatchRows([str(scene) for scene in scenes], shown=not as_json)

    def done(number: int, result: SceneResult) -> None:
        results[number] = result
        rows.show(results)
        tell("scenes", len(results), len(scenes))

    interrupted = False
    # otherwise the table shows the progress
    with handed_out(scenes, keep, resume) as batch, telling(hidden=not as_json) as tell:
        tell("scenes", 0, len(scenes))
        try:
            run_batch(batch, where, seconds, done)
        except KeyboardInterrupt:
            interrupted = True
    ended = [results[number] for number in sorted(results)]
    code = ExitCode.INTERRUPTED if interrupted else exit_code(ended)
    if xml is not None:
        left = [scene for number, scene in enumerate(scenes) if number not in results]
        write_text(xml, junit(ended, left), JUNIT, force=force, hint=OTHER_REPORT)
    if table_file is not None:
        found = Batch(tuple(ended)).table
        click.echo(write_table(table_file, found.headings, found.rows, force=force), err=True)
    if picture_path is not None:
        click.echo(_picture(ended, picture_path, force=force), err=True)
    if as_json:
        click.echo(json_text(table.record(ended, [str(scene) for scene in scenes], code)))
    else:
        rows.finish(results)
    for message in table.messages(ended):
        click.echo(message, err=True)
    if interrupted:
        click.echo("interrupted", err=True)
    return int(code)


def _picture(ended: Sequence[SceneResult], path: Path, *, force: bool) -> str:
    """Draw how much of its allowed error each expectation uses; the path, or that there is nothing to draw."""
    from mbproj.figures.pages.expectations import draw_expectations
    from mbproj.figures.save import save

    judged = [(each.scene, outcome) for each in ended for outcome in each.outcomes]
    shares = {f"{scene}: {outcome.expectation.name}": outcome.share for scene, outcome in judged}
    return str(save(draw_expectations(shares), path, force=force)) if shares else "note: no expectation to draw"
