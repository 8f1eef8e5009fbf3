"""Energies, and the balance E(t) - E(0) - W + D, which is zero but for errors of integration."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures import panels, rows
from mbproj.figures.differences import SIGN
from mbproj.figures.rows import PanelGroup, PanelQuantity
from mbproj.figures.style import styled
from mbproj.figures.units import Unit, sizes
from mbproj.results import Results

ENERGIES = ("kinetic", "potential", "total")
BALANCE = "energy balance"
JOULE = Unit("J", "J")


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """One result: the energies in one panel, below it the balance. Several: a panel an energy and one of the balance, a
    line a result, below them how far the kinetic and the total energy are apart."""
    if len(results) > 1:
        return rows.draw(results, labels, [_overlaid()])
    (result,) = results
    figure, axes = panels.panels(2, height=2.1)
    for index, energy in enumerate(ENERGIES):
        panels.plot(axes[0, 0], result.abscissa, result[f"diagnostics/{energy}_energy"], energy, index)
    # The balance is named by its axis: the legend is that of the energies.
    panels.plot(axes[1, 0], result.abscissa, result["diagnostics/energy_balance"], "", 0)
    panels.hold_still([axes[0, 0]], sizes(results)["J"])
    panels.name(axes[0, 0], "energy", "J")
    panels.name(axes[1, 0], BALANCE, "J")
    return panels.finish(figure)


def _overlaid() -> PanelGroup:
    kinetic, potential, total = (
        PanelQuantity(f"{energy} energy", JOULE, _reader(f"diagnostics/{energy}_energy")) for energy in ENERGIES
    )
    # How large the balance is says how good a run is: it keeps a scale of its own.
    balance = PanelQuantity(BALANCE, JOULE, _reader("diagnostics/energy_balance"), held=False)
    apart = tuple(PanelQuantity(f"{SIGN} of {each.words}", JOULE, each.read) for each in (kinetic, total))
    return PanelGroup(((kinetic, potential), (total, balance)), apart)


def _reader(path: str) -> Callable[[Results], Array]:
    def read(result: Results) -> Array:
        return result[path]

    return read
