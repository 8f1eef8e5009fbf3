"""`mbproj continue`: continues a run from its results file, to the last bit as one long run."""

from __future__ import annotations

from pathlib import Path

import click

from mbproj.cli.completion import results_file
from mbproj.cli.explained import Part, explained, option
from mbproj.cli.quantity import Positive

EXAMPLES = (
    ("Go on with a run until 20 s; the new file has what follows.", "mbproj continue results.h5 --until 20"),
    ("Put all samples, old and new, into one file.", "mbproj continue results.h5 --until 20 --append"),
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
    default="continued.h5",
    show_default=True,
    type=results_file(),
    help="New results file, with the samples that follow.",
)
@option(Part.OUTPUT, "--append", is_flag=True, help="Put all samples, old and new, in place of RESULTS.")
@option(Part.OUTPUT, "--json", "as_json", is_flag=True, help="Print one JSON object instead of the summary.")
@option(Part.OUTPUT, "-q", "--quiet", is_flag=True, help="Print nothing but errors.")
def command(results: Path, until: float | None, output: str, append: bool, as_json: bool, quiet: bool) -> None:
    """Continues the run that wrote RESULTS, also a killed one.

    On the same build and machine the numbers are those of one long run, to the last bit.
    """
    from mbproj.calls.again import checkpoint_of, longer, require_another, stored_scene
    from mbproj.calls.recorded import Earlier
    from mbproj.cli.simulate.execute import execute
    from mbproj.results import open_results

    with open_results(results) as before:
        checkpoint = checkpoint_of(before)
        scene, name = stored_scene(before)
        if not append:
            require_another(output, before.path, "to go on with")
        execute(
            longer(scene, checkpoint, until, before),
            name,
            str(results) if append else output,
            earlier=Earlier(checkpoint, before if append else None),
            as_json=as_json,
            quiet=quiet,
        )
