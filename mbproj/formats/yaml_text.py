"""Writes mappings as YAML: short ones on one line, long ones in blocks, no line above 100 characters."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from mbproj.formats.mechanism import Bare, Quantity

WIDTH = 100
#: A number of an array is written as 0 where it is less than this part of the largest one.
ROUND_OFF = 1e-15
#: Text without quotes that every YAML reader takes for text.
_PLAIN = re.compile(r"[A-Za-z_./][A-Za-z0-9_./-]*")
#: Words that YAML 1.1 takes for something else.
_WORDS = {"y", "n", "yes", "no", "on", "off", "true", "false", "null"}


def number(value: float, scale: float = 0.0) -> str:
    """The number with 12 digits where these give the same number back, else with all; 0 for round-off beside
    `scale`."""
    value = float(value)
    if abs(value) <= ROUND_OFF * scale or value == 0.0:
        return "0"
    short = f"{value:.12g}"
    return short if abs(float(short) - value) <= 4 * ROUND_OFF * max(abs(value), scale) else repr(value)


def quoted(text: str) -> str:
    """Text as YAML, with quotes where it would be read as something else."""
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS:
        return text
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c) & 0xFFFF:04x}" for c in escaped) + '"'


def flow(value: Any) -> str:
    """The YAML text of a value on one line."""
    if isinstance(value, Bare):
        return str(value) if not set(value) & set(",[]{}#:") else f'"{value}"'
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "null"
    if isinstance(value, Quantity):
        return f"{number(value.value)} {value.unit}".strip()
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{quoted(str(key))}: {flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, (list, tuple, np.ndarray)):
        plain = [each for each in value if isinstance(each, (int, float)) and not isinstance(each, bool)]
        scale = max((abs(each) for each in plain), default=0.0) if len(plain) == len(value) else 0.0
        parts = [number(each, scale) if isinstance(each, (int, float)) else flow(each) for each in value]
        return "[" + ", ".join(parts) + "]"
    return number(value)


def lines(key: str, value: Any, indent: int, comment: str = "") -> Iterator[str]:
    """The lines of `key: value`: one where it fits, with the comment where that fits too."""
    head = f"{' ' * indent}{quoted(key)}:"
    whole = f"{head} {flow(value)}"
    if len(whole) <= WIDTH:
        yield f"{whole}  # {comment}" if comment and len(whole) + len(comment) + 4 <= WIDTH else whole
    elif isinstance(value, Mapping):
        yield f"{head}  # {comment}" if comment and len(head) + len(comment) + 4 <= WIDTH else head
        for name, item in value.items():
            yield from lines(str(name), item, indent + 2)
    elif isinstance(value, (list, tuple, np.ndarray)):
        yield from _items(head, value, indent)
    else:
        yield whole


def _items(head: str, values: Any, indent: int) -> Iterator[str]:
    """The lines of a list that does not fit on one: a line for each item, or numbers in brackets."""
    parts = [flow(each) for each in values] if not isinstance(values, np.ndarray) else flow(values)[1:-1].split(", ")
    if any(isinstance(each, Mapping) for each in values):
        yield head
        for each in values:
            text = f"{' ' * indent}  - {flow(each)}"
            if len(text) <= WIDTH:
                yield text
                continue
            sign = "- "
            for name, item in each.items():
                for line in lines(str(name), item, 0):
                    yield f"{' ' * indent}  {sign}{line}"
                    sign = "  "
        return
    line = f"{head} ["
    for at, part in enumerate(parts):
        text = part + ("]" if at == len(parts) - 1 else ",")
        if len(line) + len(text) + 1 > WIDTH:
            yield line.rstrip()
            line = " " * (indent + 4)
        line += text + " "
    yield line.rstrip()
