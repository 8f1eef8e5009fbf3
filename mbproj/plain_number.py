"""Numbers in files and options, as other programs read them too: in ASCII digits, with a point and an exponent.

Python's `float` takes more: 8_9 is 89 there, and digits of other scripts are digits.
"""

from __future__ import annotations

import re

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[+-]?(?:inf(?:inity)?|nan)", re.I | re.A)


def plain_number(text: str) -> float:
    """Return the number of a text, which may be infinite or NaN. Raises ValueError where it is none."""
    if _NUMBER.fullmatch(text.strip()) is None:
        raise ValueError(f"could not convert string to float: {text.strip()!r}")
    return float(text)
