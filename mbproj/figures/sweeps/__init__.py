"""Pictures of sweeps, one module each with `why_not(chosen)` and `draw(chosen) -> Figure`. Importing this package is
cheap."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING

from mbproj.dataclass import dataclass

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.figures.sweeps.chosen import Chosen

#: The designs whose values are samples of distributions, and those whose values are listed.
SAMPLED, LISTED = frozenset({"montecarlo", "lhs", "sobol", "saltelli"}), frozenset({"grid", "zip"})


@dataclass(frozen=True)
class SweepPicture:
    """A kind of picture: its module in this folder, a summary, and the designs for which it is drawn by default."""

    module: str
    summary: str
    designs: frozenset[str]


PICTURES: Mapping[str, SweepPicture] = MappingProxyType(
    {
        "lines": SweepPicture("lines", "measures over one quantity, a line for each value of a second", LISTED),
        "map": SweepPicture("heat_map", "measures over two quantities as heat maps with contours", LISTED),
        "distribution": SweepPicture("distribution", "how each measure is distributed, with its quantiles", SAMPLED),
        "scatter": SweepPicture("scatter", "scatter plots of all varied quantities and measures", SAMPLED),
        "ranks": SweepPicture("ranks", "rank correlations as a tornado chart", SAMPLED),
        "sobol": SweepPicture("sobol", "Sobol' indices with their confidence", SAMPLED),
    }
)


def why_not(kind: str, chosen: Chosen) -> str | None:
    """The reason why the picture does not apply; None where it does."""
    reason: str | None = import_module(f"{__name__}.{PICTURES[kind].module}").why_not(chosen)
    return reason


def draw(kind: str, chosen: Chosen) -> Figure:
    """Draw the picture of a sweep to which it applies."""
    figure: Figure = import_module(f"{__name__}.{PICTURES[kind].module}").draw(chosen)
    return figure
