"""`mbproj paper` and `mbproj.paper`: the figures of Zhang, Liu & Liu (2015), with notes that the paper lacks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import click

from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.figure_options import look
from mbproj.commands.kinds import OneOf, Positive
from mbproj.commands.options import FolderPath, Option, Part, force_option, option
from mbproj.results.output_files import check_replaceable, make_folder, picture
from mbproj.studies.parallel.progress import Tell, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.commands.arguments import Quantity
    from mbproj.commands.pictures import Picture
    from mbproj.studies.paper import Example

#: For each mechanism, the components of the marker that the paper plots, and the numbers of its four figures.
FIGURES = {"five_bar": ("xz", (2, 3, 4, 5)), "spatial_slider_crank": ("x", (7, 8, 9, 10))}
EXAMPLES = (
    ("Draw all eight figures.", "mbproj paper -o figures"),
    ("Draw their first two seconds as PDF.", "mbproj paper -o figures --duration 2 --format pdf"),
)
Duration = Annotated[
    "Quantity",
    Option(Part.WHAT, "How long to simulate.", Positive("s"), "TIME", names=("--duration", "--until")),
]


@declared
def paper(*, duration: Duration = "10 s", progress: Tell = silent) -> dict[int, Picture]:
    """Draws eight figures of the paper, with the paper's settings.

    The figures are Figs. 2-5 and 7-10. The settings are RK4 with a step of 0.01 s, a tolerance of 1e-12, and the full
    formulation. It takes about a minute. For each mechanism it tells from which time on the paper's step has not
    converged.

    In Python it returns the figures by their numbers.
    """
    from mbproj.commands.pictures import Picture
    from mbproj.studies.paper import run_example

    until, pictures = read(paper, locals()).duration, dict[int, Picture]()
    for done, name in enumerate(FIGURES):
        progress("mechanisms", done, len(FIGURES))
        pictures |= {number: Picture(figure) for number, figure in figures_of(run_example(name, until)).items()}
    return pictures


OUTPUT = option(
    Part.OUTPUT, "--output", "-o", required=True, type=FolderPath(), metavar="DIR", help="Where the figures go."
)
FORMAT = option(
    Part.OUTPUT,
    "--format",
    "ending",
    default="png",
    show_default=True,
    type=OneOf(["png", "svg", "pdf"]),
    help="Format of the pictures.",
)


@command_of(paper, EXAMPLES, OUTPUT, FORMAT, force_option, look)
def command(asked: Asked[dict[int, Picture]], output: str, ending: str, force: bool) -> None:
    from mbproj.show.figures.style import save
    from mbproj.studies.paper import run_example

    folder = make_folder(Path(output))
    numbers = [number for _, figures in FIGURES.values() for number in figures]
    paths = {number: folder / f"paper-fig{number:02d}.{ending}" for number in numbers}
    for path in paths.values():
        check_replaceable(path, picture(ending), force=force)

    for name in FIGURES:
        example = run_example(name, asked.given["duration"], lambda message: click.echo(message, err=True))
        for number, figure in figures_of(example).items():
            click.echo(save(figure, paths[number], force=force))
        for line in convergence(example):
            click.echo(line)


def figures_of(example: Example) -> dict[int, Figure]:
    """The four figures of an example, by their numbers in the paper."""
    from mbproj.show.figures import studies as paper_figures

    components, numbers = FIGURES[example.name]
    shown, since = example.histories["GPOPM"], example.unconverged_from
    series = example.histories.items()
    drawn = (
        paper_figures.position_history(shown.time, shown.position, components=components, unconverged_from=since),
        paper_figures.velocity_history(shown.time, shown.velocity, components=components, unconverged_from=since),
        paper_figures.position_errors(
            {legend: (run.time, run.position_violation) for legend, run in series}, unconverged_from=since
        ),
        paper_figures.velocity_errors(
            {legend: (run.time, run.velocity_violation) for legend, run in series}, unconverged_from=since
        ),
    )
    return dict(zip(numbers, drawn, strict=True))


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
