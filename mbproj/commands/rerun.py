"""`mbproj rerun`: repeats a run, from its results file alone."""

from __future__ import annotations

from pathlib import Path

import click

from mbproj.commands.options import Part, explained, option, results_file

EXAMPLES = (("Repeat a run whose scene is no longer at hand.", "mbproj rerun results.h5 -o again.h5"),)


@explained("rerun", EXAMPLES)
@click.argument("results", type=results_file(path_type=Path))
@option(
    Part.OUTPUT, "-o", "--output", default="rerun.h5", show_default=True, type=results_file(), help="New results file."
)
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object instead of the summary.")
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def command(results: Path, output: str, as_json: bool, quiet: bool) -> None:
    """Repeats the run that wrote RESULTS, with the same scene and settings.

    On the same build and machine the numbers are the same to the last bit.
    """
    from mbproj.commands.execute import execute
    from mbproj.commands.python.run import require_another, require_whole, stored_scene
    from mbproj.results.reader import open_results

    with open_results(results) as before:
        require_whole(before)
        scene = stored_scene(before)
        require_another(output, before.path, "to repeat")
        limits = before.certified
    execute(scene, output, limits=limits, as_json=as_json, quiet=quiet)
