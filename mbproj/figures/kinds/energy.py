"""Energies, and the balance E(t) - E(0) - W + D, which is zero apart from errors of integration."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures import panels, rows
from mbproj.figures.differences import SIGN
from mbproj.figures.rows import PanelGroup, PanelQuantity
from mbproj.figures.style import styled
from mbproj.figures.units import AxisUnit, sizes
from mbproj.results import Results

ENERGIES = ("kinetic", "potential", "total")
BALANCE = "energy balance"
JOULE = AxisUnit("J", "J")


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw one result with its energies in one panel and the balance below. Draw several with a panel for each energy
    and the balance, and the differences in kinetic and total energy below."""
    if len(results) > 1:
        return rows.draw(results, labels, [_overlaid()])
    (result,) = results
    figure, axes = panels.panels(2, height=2.1)
    for index, energy in enumerate(ENERGIES):
        panels.plot(axes[0, 0], result.abscissa, result[f"diagnostics/{energy}_energy"], energy, index)
    # The axis names the balance; the legend is for the energies.
    panels.plot(axes[1, 0], result.abscissa, result["diagnostics/energy_balance"], "", 0)
    panels.hold_still([axes[0, 0]], sizes(results)["J"])
    panels.name(axes[0, 0], "energy", "J")
    panels.name(axes[1, 0], BALANCE, "J")
    return panels.finish(figure)


def _overlaid() -> PanelGroup:
    kinetic, potential, total = (
        PanelQuantity(f"{energy} energy", JOULE, _reader(f"diagnostics/{energy}_energy")) for energy in ENERGIES
    )
    # The balance keeps its own scale, because its size tells how good a run is.
    balance = PanelQuantity(BALANCE, JOULE, _reader("diagnostics/energy_balance"), held=False)
    apart = tuple(PanelQuantity(f"{SIGN} of {each.words}", JOULE, each.read) for each in (kinetic, total))
    return PanelGroup(((kinetic, potential), (total, balance)), apart)


def _reader(path: str) -> Callable[[Results], Array]:
    def read(result: Results) -> Array:
        return result[path]

    return read
