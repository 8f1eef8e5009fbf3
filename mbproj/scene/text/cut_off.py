"""Values that a comma cuts in two: inside { } and [ ] a comma ends a value, so that `{torque: max(0, t)}` has two keys.

The pieces are joined again, so that the comma is the one problem reported.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from mbproj.errors import Problem
from mbproj.scene.text.nodes import Node, ScalarNode, WrittenKey

#: The most pieces that are joined; a longer search would take time in lists of thousands.
MOST = 50
_WHOLE_NUMBER = re.compile(r"[-+]?[0-9]+")


def whole_items(items: Sequence[Node]) -> tuple[list[Node], list[Problem]]:
    """The items of a list in [ ], with values joined that commas have cut, and a problem for each of these."""
    items_read: list[Node] = []
    problems = []
    at = 0
    while at < len(items):
        pieces = items[at : at + MOST] if _opens(items[at]) else []
        count = _in_parentheses(pieces)
        if count:
            node = _as_one_text(pieces[:count])
            items_read.append(node)
            problems.append(_problem("[ ]", node, f'put it in quotes: "{node.text}"'))
        else:
            items_read.append(items[at])
        at += count or 1
    return items_read, problems


def whole_entries(entries: Sequence[WrittenKey]) -> tuple[list[WrittenKey], list[Problem]]:
    """The entries of a mapping in { }, with values joined that commas have cut, and a problem for each of these."""
    if not any(
        isinstance(each.value, ScalarNode) and ("(" in each.value.text or not each.value.text) for each in entries
    ):
        return list(entries), []
    kept: list[WrittenKey] = []
    problems = []
    at = 0
    while at < len(entries):
        key, place, value = entries[at]
        following = _keys_alone(entries[at + 1 : at + MOST])
        count = _in_parentheses([value, *following]) if _opens(value) else 0
        if count:
            node = _as_one_text([value, *following][:count])
            problems.append(_problem("{ }", node, f'put it in quotes: {_name(key)}: "{node.text}"'))
        elif following and _decimal_comma(value, following[0]):
            count, node = 2, replace(_as_one_text([value, following[0]]), text=f"{_text(value)}.{_text(following[0])}")
            problems.append(_problem("{ }", node, f"decimals take a point: {_name(key)}: {node.text}"))
        kept.append(WrittenKey(key, place, node if count else value))
        at += count or 1
    return kept, problems


def _problem(inside: str, node: ScalarNode, hint: str) -> Problem:
    return Problem(f"this value is cut off: inside {inside} a comma ends it", node.place, hint)


def _keys_alone(entries: Sequence[WrittenKey]) -> list[Node]:
    """The keys of the entries up to the first that has a value."""
    alone: list[Node] = []
    for entry in entries:
        if _text(entry.value) != "":
            break
        alone.append(entry.key)
    return alone


def _text(node: Node) -> str | None:
    """The text of a node without quotes; None for other nodes."""
    if not isinstance(node, ScalarNode) or node.place.text is None or node.place.column is None:
        return None
    quoted = node.place.text[node.place.column - 1 :][:1] in ("'", '"')
    return None if quoted else node.text


def _name(key: Node) -> str:
    return key.text if isinstance(key, ScalarNode) else ""


def _unclosed(text: str) -> int:
    return text.count("(") - text.count(")")


def _opens(node: Node) -> bool:
    """Whether a parenthesis opens in this text and does not close."""
    return _unclosed(_text(node) or "") > 0


def _in_parentheses(pieces: Sequence[Node]) -> int:
    """The number of pieces up to the one that closes the parentheses of the first; 0 where they stay open."""
    still_open = 0
    for count, piece in enumerate(pieces, 1):
        text = _text(piece)
        if text is None:
            return 0
        still_open += _unclosed(text)
        if still_open <= 0:
            return count
    return 0


def _decimal_comma(value: Node, following: Node) -> bool:
    """Whether the two are a number with a decimal comma: no key begins with a digit."""
    before, after = _text(value) or "", _text(following) or ""
    return _WHOLE_NUMBER.fullmatch(before) is not None and after[:1].isdecimal()


def _as_one_text(pieces: Sequence[Node]) -> ScalarNode:
    """The pieces as one text, with the characters of the line where all stand in one line."""
    texts = [piece for piece in pieces if isinstance(piece, ScalarNode)]
    first, last = texts[0], texts[-1]
    line = first.place.text
    if line is None or first.column is None or last.column is None or first.place.line != last.place.line:
        return replace(first, text=", ".join(piece.text for piece in texts), column=None)
    return replace(first, text=line[first.column - 1 : last.column - 1 + len(last.text)])
