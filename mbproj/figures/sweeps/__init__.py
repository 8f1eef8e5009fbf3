"""The kinds of pictures of sweeps, each with `why_not(chosen)` and `draw(chosen) -> Figure`. Importing it is cheap."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from mbproj.dataclass import dataclass
from mbproj.registry import load
from mbproj.results.sweep.layout import SAMPLED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.figures.sweeps.chosen import Chosen

#: The designs whose values are samples of distributions, and those whose values are listed.
LISTED = frozenset({"grid", "zip"})


@dataclass(frozen=True)
class SweepPicture:
    """A kind of picture: the functions that draw it and that tell why it does not apply, as "module:name", a summary,
    and the designs for which it is drawn by default."""

    draws: str
    refuses: str
    summary: str
    designs: frozenset[str]


PICTURES: Mapping[str, SweepPicture] = MappingProxyType(
    {
        "lines": SweepPicture(
            "mbproj.figures.sweeps.lines:draw",
            "mbproj.figures.sweeps.lines:why_not",
            "measures over one quantity, a line for each value of a second",
            LISTED,
        ),
        "map": SweepPicture(
            "mbproj.figures.sweeps.heat_map:draw",
            "mbproj.figures.sweeps.heat_map:why_not",
            "measures over two quantities as heat maps with contours",
            LISTED,
        ),
        "distribution": SweepPicture(
            "mbproj.figures.sweeps.distribution:draw",
            "mbproj.figures.sweeps.distribution:why_not",
            "how each measure is distributed, with its quantiles",
            SAMPLED,
        ),
        "scatter": SweepPicture(
            "mbproj.figures.sweeps.scatter:draw",
            "mbproj.figures.sweeps.scatter:why_not",
            "scatter plots of all varied quantities and measures",
            SAMPLED,
        ),
        "ranks": SweepPicture(
            "mbproj.figures.sweeps.ranks:draw",
            "mbproj.figures.sweeps.ranks:why_not",
            "rank correlations as a tornado chart",
            SAMPLED,
        ),
        "sobol": SweepPicture(
            "mbproj.figures.sweeps.sobol:draw",
            "mbproj.figures.sweeps.sobol:why_not",
            "Sobol' indices with their confidence",
            SAMPLED,
        ),
    }
)


def why_not(kind: str, chosen: Chosen) -> str | None:
    """The reason why the picture does not apply; None where it does."""
    reason: str | None = load(PICTURES[kind].refuses)(chosen)
    return reason


def draw(kind: str, chosen: Chosen) -> Figure:
    """Draw the picture of a sweep to which it applies."""
    figure: Figure = load(PICTURES[kind].draws)(chosen)
    return figure
