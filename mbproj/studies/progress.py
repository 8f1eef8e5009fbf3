"""How a study says how far it is."""

from __future__ import annotations

from collections.abc import Callable

#: Called with a phase in words, how much of it is done, and how much there is.
Tell = Callable[[str, int, int], None]


def silent(phase: str, done: int, whole: int) -> None:
    """Tells nobody."""
