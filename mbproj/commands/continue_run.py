"""`mbproj continue`: continues a run from its results file, to the last bit as one long run."""

from __future__ import annotations

from pathlib import Path

import click

from mbproj.commands.options import Part, Positive, explained, option, results_file

EXAMPLES = (
    ("Go on with a run until 20 s; the new file has what follows.", "mbproj continue results.h5 --until 20"),
    ("Put all samples, old and new, into one file.", "mbproj continue results.h5 --until 20 --append -o all.h5"),
)


@explained("continue", EXAMPLES)
@click.argument("results", type=results_file(path_type=Path))
@option(
    Part.WHAT,
    "--until",
    "--duration",
    "until",
    type=Positive("s"),
    metavar="TIME",
    help="Where the run then ends, from its original start [default: its own end].",
)
@option(
    Part.OUTPUT,
    "-o",
    "--output",
    type=results_file(),
    help="New results file, with the samples that follow [default: continued.h5].",
)
@option(Part.OUTPUT, "--append", is_flag=True, help="Put all samples, old and new, into -o [default: RESULTS itself].")
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object instead of the summary.")
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def command(results: Path, until: float | None, output: str | None, append: bool, as_json: bool, quiet: bool) -> None:
    """Continues the run that wrote RESULTS, also a killed one.

    On the same build and machine the numbers are those of one long run, to the last bit.
    """
    from mbproj.commands.execute import execute
    from mbproj.commands.python.run import checkpoint_of, continued_in, longer, stored_scene
    from mbproj.results.reader import open_results
    from mbproj.studies.record import Earlier

    with open_results(results) as before:
        checkpoint = checkpoint_of(before)
        scene = longer(stored_scene(before), checkpoint, until, before)
        where = continued_in(before, output or (None if append else "continued.h5"), append=append)
        earlier = Earlier(checkpoint, before if append else None)
        execute(scene, str(where), earlier=earlier, as_json=as_json, quiet=quiet)
