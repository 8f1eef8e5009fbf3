"""Texts from and for others: characters that command a terminal are escaped, and numbers are read as other programs
read them.
"""

from __future__ import annotations

import re

# --- Characters that command a terminal, or hide what a text says -----------------------------------------------------

#: Control characters, Unicode's marks for the direction of writing, and its line and paragraph separators.
_COMMANDS = "\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069"
_ANY = re.compile(f"[{_COMMANDS}\ud800-\udfff]")  # surrogates stand for bytes of a file name that are no text
_IN_TEXT = re.compile(f"(?![\n\t])[{_COMMANDS}]")


def escaped(text: str) -> str:
    r"""Return the text on one line, with characters that command a terminal written as in JSON, such as \u001b."""
    return _ANY.sub(_readable, text)


def escaped_text(text: str) -> str:
    """Escape a text of several lines as `escaped` does, but keep line ends and tabs."""
    return _IN_TEXT.sub(_readable, text)


def _readable(character: re.Match[str]) -> str:
    return f"\\u{ord(character[0]):04x}"


def text_of(value: object, what: str) -> str:
    """The value, which has to be a text. Raises TypeError that says so, with the name of its type."""
    if not isinstance(value, str):
        raise TypeError(f"{what} is a text, found {type(value).__name__}")
    return value


# --- Numbers in files and options, as other programs read them too ----------------------------------------------------
# In ASCII digits, with a point and an exponent.
# Python's `float` takes more: 8_9 is 89 there, and digits of other scripts are digits.


_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[+-]?(?:inf(?:inity)?|nan)", re.I | re.A)


def plain_number(text: str) -> float:
    """Return the number of a text, which may be infinite or NaN. Raises ValueError where it is none."""
    if _NUMBER.fullmatch(text.strip()) is None:
        raise ValueError(f"could not convert string to float: {text.strip()!r}")
    return float(text)
