"""Energies, and the balance E(t) - E(0) - W + D, which is zero but for errors of integration."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mbproj.plot import panels
from mbproj.plot.style import PANEL_HEIGHT, styled
from mbproj.results import Results

ENERGIES = ("kinetic", "potential", "total")
BALANCE = "energy balance (J)"


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """One result: the energies in one panel. Several: a panel an energy, a line a result. Below it the balance."""
    single = len(results) == 1
    figure, axes = panels.panels(2 if single else 4, height=2.1 if single else PANEL_HEIGHT)
    for index, (result, label) in enumerate(zip(results, labels, strict=True)):
        for row, energy in enumerate(ENERGIES):
            values = result[f"diagnostics/{energy}_energy"]
            axis, text, look = (axes[0, 0], energy, row) if single else (axes[row, 0], label, index)
            panels.plot(axis, result.time, values, text, look)
        # In a single picture the balance is named by its axis: the legend is that of the energies.
        panels.plot(axes[-1, 0], result.time, result["diagnostics/energy_balance"], "" if single else label, index)
    for row, axis in enumerate(axes[:-1, 0]):
        axis.set_ylabel("energy (J)" if single else f"{ENERGIES[row]} energy (J)")
    axes[-1, 0].set_ylabel(BALANCE)
    return panels.finish(figure)
