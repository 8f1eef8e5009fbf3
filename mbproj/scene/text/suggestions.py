"""Did you mean ...?"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice

#: Among more names than this none is suggested: a generated scene may have thousands of wrong names.
MAX_NAMES = 300


def did_you_mean(word: str, names: Iterable[str]) -> str | None:
    """A hint that names what is closest to `word`, upper and lower case alike; None where nothing is close."""
    import difflib

    few = list(islice(names, MAX_NAMES + 1))
    if len(few) > MAX_NAMES or len(word) > 200:
        return None
    by_folded = {name.casefold(): name for name in few}
    close = difflib.get_close_matches(word.casefold(), by_folded, n=1, cutoff=0.7)
    return f"did you mean '{by_folded[close[0]]}'?" if close else None


def choose_from(word: str, names: Iterable[str], what: str = "choose from") -> str:
    """The closest of `names`, or else a list of them (of the first twenty)."""
    few = list(islice(names, MAX_NAMES + 1))  # thousands of wrong words may each have thousands to choose from
    shown = ", ".join(few[:20]) + (", ..." if len(few) > 20 else "")
    return did_you_mean(word, few) or (f"{what}: {shown}" if few else "there is none")
