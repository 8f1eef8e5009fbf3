"""The progress report of a study."""

from __future__ import annotations

from collections.abc import Callable

#: A function that is called with a phase in words, the amount done, and the whole amount.
Tell = Callable[[str, int, int], None]

TIMING, PERTURBED_STARTS, CASES = "timing", "starts that differ by round-off", "cases"
#: Phases with parts of equal duration, so that the first parts predict the time left. In other phases a part may take a
#: hundred times as long as the one before, and nothing is predicted.
ALIKE = frozenset({TIMING, PERTURBED_STARTS, CASES})
#: The mark between a phase and the words on it that change.
BESIDE = "; "


def with_words(phase: str, words: str) -> str:
    """The phase followed by words on the results so far."""
    return f"{phase}{BESIDE}{words}" if words else phase


def silent(phase: str, done: int, whole: int) -> None:
    """Report nothing."""
