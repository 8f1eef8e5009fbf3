"""Characters that command a terminal, or hide what a text says, written so that they can be read instead."""

from __future__ import annotations

import re

#: Control characters, the direction of writing and the ends of lines that only Unicode knows.
_COMMANDS = "\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069"
_ANY = re.compile(f"[{_COMMANDS}\ud800-\udfff]")  # bytes of a file name that are no text, too
_IN_TEXT = re.compile(f"(?![\n\t])[{_COMMANDS}]")


def escaped(text: str) -> str:
    r"""The text on one line: what commands a terminal becomes \u001b, say, as in JSON."""
    return _ANY.sub(_readable, text)


def escaped_text(text: str) -> str:
    """The same for text of several lines: ends of lines and tabs stay."""
    return _IN_TEXT.sub(_readable, text)


def _readable(found: re.Match[str]) -> str:
    return f"\\u{ord(found[0]):04x}"
