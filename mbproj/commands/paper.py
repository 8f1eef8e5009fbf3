"""`mbproj paper`: the figures of Zhang, Liu & Liu (2015), with notes that the paper lacks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mbproj.commands.figure_options import look
from mbproj.commands.options import FolderPath, Part, Positive, explained, option
from mbproj.commands.study_options import force as force_option
from mbproj.results.output_files import check_replaceable, make_folder, picture

if TYPE_CHECKING:
    from mbproj.studies.paper import Example

EXAMPLES = (
    ("Draw all eight figures.", "mbproj paper -o figures"),
    ("Draw their first two seconds as PDF.", "mbproj paper -o figures --duration 2 --format pdf"),
)


@explained("paper", EXAMPLES, short_help="Draws the figures of Zhang, Liu & Liu (2015).")
@option(Part.OUTPUT, "--output", "-o", required=True, type=FolderPath(), metavar="DIR", help="Where the figures go.")
@option(
    Part.WHAT,
    "--duration",
    "--until",
    "duration",
    default="10 s",
    show_default=True,
    type=Positive("s"),
    metavar="TIME",
    help="How long to simulate.",
)
@option(
    Part.OUTPUT,
    "--format",
    "ending",
    default="png",
    show_default=True,
    type=click.Choice(["png", "svg", "pdf"]),
    help="Format of the pictures.",
)
@force_option
@look
def command(output: str, duration: float, ending: str, force: bool) -> None:
    """Draws eight figures of the paper, with the paper's settings.

    The figures are Figs. 2-5 and 7-10. The settings are RK4 with a step of 0.01 s, a tolerance of 1e-12, and the full
    formulation. It takes about a minute. For each mechanism it tells from which time on the paper's step has not
    converged.
    """
    from mbproj.commands.python.pictures import FIGURES, figures_of
    from mbproj.show.figures.style import save
    from mbproj.studies.paper import run_example

    folder = make_folder(Path(output))
    numbers = [number for _, figures in FIGURES.values() for number in figures]
    paths = {number: folder / f"paper-fig{number:02d}.{ending}" for number in numbers}
    for path in paths.values():
        check_replaceable(path, picture(ending), force=force)

    for name in FIGURES:
        example = run_example(name, duration, lambda message: click.echo(message, err=True))
        for number, figure in figures_of(example).items():
            click.echo(save(figure, paths[number], force=force))
        for line in convergence(example):
            click.echo(line)


def convergence(example: Example) -> list[str]:
    """Notes that the figures need: the error of the motion at the paper's step, and the runs that ended early."""
    from mbproj.studies.paper import LIMIT

    time, error = example.histories["GPOPM"].time, example.error
    lines = [f"{example.title}, marker {example.marker}, RK4 + GPOPM at 0.01 s against DOP853 at 1e-11:"]
    if example.unconverged_from is None:
        lines.append(f"  converged to {1e3 * LIMIT:g} mm: the largest error is {error.max():.1e} m")
    else:
        since = f"t = {example.unconverged_from:.4g} s"
        lines.append(f"  not converged from {since} on: the error exceeds {1e3 * LIMIT:g} mm")
        for at in (1.0, 3.0, 5.0, 8.0, 10.0):
            if at <= time[-1]:
                lines.append(f"  error at {at:4g} s  {error[abs(time - at).argmin()]:.1e} m")
    lines += [f"  {legend}: {run.failure}" for legend, run in example.histories.items() if run.failure]
    return lines
