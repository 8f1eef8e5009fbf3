"""What a person sees of results in a prompt or a notebook: what was run, how far it got, what is recorded."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any, Protocol

from mbproj.arrays import Array

KINDS = ("bodies", "joints", "markers", "forces", "motions", "stops", "frictions", "states")
#: So many names of a kind are shown.
SHOWN = 6


class Shown(Protocol):
    """What is asked of results."""

    attributes: Mapping[str, Any]

    @property
    def title(self) -> str: ...

    @property
    def status(self) -> str: ...

    @property
    def time(self) -> Array: ...

    def names(self, kind: str) -> tuple[str, ...]: ...


def rows(results: Shown) -> list[tuple[str, str]]:
    """Lines of a table: a word, and what it is."""
    time, attributes = results.time, results.attributes
    span = f"{len(time)} from {time[0]:g} to {time[-1]:g} s" if len(time) else "none"
    found = [("status", results.status), ("samples", span)]
    found += [(kind, _listed(names)) for kind in KINDS if (names := results.names(kind))]
    for key, word, unit in (
        ("position_violation_max", "position violation", ""),
        ("velocity_violation_max", "velocity violation", ""),
        ("energy_drift", "energy drift", " J"),
    ):
        if isinstance(attributes.get(key), float):
            found.append((word, f"{attributes[key]:.2g}{unit}"))
    return found


def as_text(results: Shown) -> str:
    """Some lines of text."""
    return "\n".join([f"Results: {results.title}", *(f"  {word:18} {what}" for word, what in rows(results))])


def as_html(results: Shown) -> str:
    """A table; titles and names are escaped, because they may be from anybody."""
    cells = (f"<tr><th>{escape(word)}</th><td>{escape(what)}</td></tr>" for word, what in rows(results))
    return f"<table><caption>{escape(results.title)}</caption>{''.join(cells)}</table>"


def _listed(names: tuple[str, ...]) -> str:
    more = f", and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more
