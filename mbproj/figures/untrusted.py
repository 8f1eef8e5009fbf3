"""Marks for the untrusted part of a certified run: from the time on at which its error may exceed a limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.figures.margins import small_print
from mbproj.figures.style import SHADE
from mbproj.results import Results


def since(result: Results, limit: float, name: str | None = None) -> float | None:
    """The time (s) from which on the error of a marker, or of any marker, may exceed the limit. None where it never
    does, or the run was not certified."""
    trust = result.trust
    return None if trust is None else trust.untrusted_from(limit, name)


def mark(figure: Figure, results: Sequence[Results], limit: float) -> str:
    """Shade all panels from the first time on at which a marker of a run is not trusted. Return a text on it."""
    return shade({"": figure.axes}, results, limit)


def shade(axes: Mapping[str, Sequence[Axes]], results: Sequence[Results], limit: float) -> str:
    """Shade the axes of each marker ("": of all) from its first untrusted time in any run. Return a text on it, or
    ""."""
    shaded = False
    end = max(float(result.time[-1]) for result in results)
    for name, own in axes.items():
        times = [time for result in results if (time := since(result, limit, name)) is not None]
        for axis in own if times and min(times) < end else ():
            left, right = axis.get_xlim()
            axis.axvspan(max(min(times), left), end, color=SHADE, linewidth=0, zorder=0)
            axis.set_xlim(left, right)
            shaded = True
    return f"shaded: {exceeds(limit)}" if shaded else ""


def exceeds(limit: float) -> str:
    """The text for untrusted parts."""
    return f"the error may exceed {limit:g} m"


def explain(figure: Figure, text: str) -> None:
    """Put the text on marks below the panels."""
    if text:
        small_print(figure, text)
