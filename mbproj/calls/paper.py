"""`mbproj.paper`: the figures of Zhang, Liu & Liu (2015), as pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbproj.calls.given import Quantity, amount, by_arguments
from mbproj.calls.pictures import Picture
from mbproj.figures.pages import paper_figures
from mbproj.studies.paper.examples import Example, run_example
from mbproj.studies.parallel.progress import Tell, silent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: For each mechanism, the components of the marker that the paper plots, and the numbers of its four figures.
FIGURES = {"five_bar": ("xz", (2, 3, 4, 5)), "spatial_slider_crank": ("x", (7, 8, 9, 10))}


def paper(*, duration: Quantity = 10.0, progress: Tell = silent) -> dict[int, Picture]:
    """Draws Figs. 2-5 and 7-10 of the paper with the paper's settings; returns them by their numbers. The motions take
    `duration` s.

    It takes about a minute.
    """
    with by_arguments():
        until, found = amount(duration, "duration", "s", above=0.0), dict[int, Picture]()
    for done, name in enumerate(FIGURES):
        progress("mechanisms", done, len(FIGURES))
        found |= {number: Picture(figure) for number, figure in figures_of(run_example(name, until)).items()}
    return found


def figures_of(example: Example) -> dict[int, Figure]:
    """The four figures of an example, by their numbers in the paper."""
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
