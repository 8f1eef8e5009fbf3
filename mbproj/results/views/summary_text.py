"""The summary of results that a prompt or a notebook shows: the scene, the times, the recorded items."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from mbproj.arrays import Array
from mbproj.errors import shortened
from mbproj.report_schema.run import RECORDED

KINDS = ("bodies", "joints", "markers", "forces", "motions", "stops", "frictions", "states", "signals")
#: The attributes whose numbers the summary shows.
NUMBERS = ("position_violation_max", "velocity_violation_max", "energy_drift")
#: The most names of a kind that are shown.
SHOWN = 6


def rows(
    status: str, time: Array, names: Callable[[str], tuple[str, ...]], attributes: Mapping[str, Any]
) -> list[tuple[str, str]]:
    """The lines of the summary, as (word, text)."""
    span = f"{len(time)} from {time[0]:g} to {time[-1]:g} s" if len(time) else "none"
    lines = [("status", status), ("samples", span)]
    lines += [(kind, shortened(names(kind), SHOWN)) for kind in KINDS if names(kind)]
    for fact in RECORDED:
        if fact.key in NUMBERS and fact.key in attributes:
            word = fact.key.removesuffix("_max").replace("_", " ")
            lines.append((word, f"{float(attributes[fact.key]):.2g} {fact.unit}"))
    return lines


def as_text(title: str, lines: Sequence[tuple[str, str]]) -> str:
    """The summary as lines of text."""
    return "\n".join([f"Results: {title or 'untitled'}", *(f"  {word:18} {what}" for word, what in lines)])


def as_html(title: str, lines: Sequence[tuple[str, str]]) -> str:
    """The summary as an HTML table; titles and names are escaped, since a file may come from anybody."""
    cells = (f"<tr><th>{escaped(word)}</th><td>{escaped(what)}</td></tr>" for word, what in lines)
    return f"<table><caption>{escaped(title)}</caption>{''.join(cells)}</table>"


def escaped(text: str) -> str:
    """The text with the special characters of HTML escaped."""
    from html import escape  # its table of entities takes 2 ms, which only a notebook needs

    return escape(text)
