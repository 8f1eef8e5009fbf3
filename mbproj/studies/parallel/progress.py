"""How a study says how far it is."""

from __future__ import annotations

from collections.abc import Callable

#: Called with a phase in words, how much of it is done, and how much there is.
Tell = Callable[[str, int, int], None]

TIMING, PERTURBED_STARTS = "timing", "starts that differ by round-off"
#: Phases whose parts take equally long, so that the first ones say how long the others will take. Elsewhere a part may
#: take a hundred times as long as the one before: nobody knows the time left.
ALIKE = frozenset({TIMING, PERTURBED_STARTS})
#: Between a phase and words on it that change as it goes on.
BESIDE = "; "


def with_words(phase: str, words: str) -> str:
    """A phase, and what is known by now."""
    return f"{phase}{BESIDE}{words}" if words else phase


def silent(phase: str, done: int, whole: int) -> None:
    """Tells nobody."""
