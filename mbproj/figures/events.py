"""Events as thin lines across all panels over time, where there are not too many."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mbproj.figures.panels import TIME
from mbproj.results import Results

#: The most event times that are drawn. More would cover the curves.
MOST = 30


def mark(figure: Figure, results: Sequence[Results]) -> None:
    """Draw a line at each event time in the panels over time. Their limits stay."""
    shown = [result.time for result in results if len(result.time)]
    times = {event.time for result in results for event in result.events}
    if not shown or not 0 < len(times) <= MOST:
        return
    first, last = min(time[0] for time in shown), max(time[-1] for time in shown)
    over_time = {id(axis) for axis in figure.axes if axis.get_xlabel() == TIME}
    columns = {axis.get_position().x0 for axis in figure.axes if id(axis) in over_time}
    for axis in figure.axes:
        if id(axis) in over_time or (axis.get_position().x0 in columns and not axis.get_xlabel()):
            limits = axis.get_xlim()
            for time in sorted(times):
                if first <= time <= last:
                    axis.axvline(time, color="#000000", linewidth=0.4, alpha=0.35, zorder=0.5)
            axis.set_xlim(limits)
