"""Did you mean ...?"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice

#: The most names among which one is suggested: a generated scene may have thousands of wrong names.
MAX_NAMES = 300


def did_you_mean(word: str, names: Iterable[str]) -> str | None:
    """A hint with the name that is closest to `word`, whatever its case; None where none is close."""
    import difflib

    few = list(islice(names, MAX_NAMES + 1))
    if len(few) > MAX_NAMES or len(word) > 200:
        return None
    by_folded = {name.casefold(): name for name in few}
    close = difflib.get_close_matches(word.casefold(), by_folded, n=1, cutoff=0.7)
    return f"did you mean '{by_folded[close[0]]}'?" if close else None


def choose_from(word: str, names: Iterable[str], what: str = "choose from") -> str:
    """A hint with the closest of `names`, or else a list of the first twenty."""
    few = list(islice(names, MAX_NAMES + 1))  # a scene may have thousands of wrong words, and of names for each
    shown = ", ".join(few[:20]) + (", ..." if len(few) > 20 else "")
    return did_you_mean(word, few) or (f"{what}: {shown}" if few else "there is none")
