"""Explains the errors of PyYAML on a text that is no YAML in plain words, at one place for both of its parsers."""

from __future__ import annotations

import re
from typing import NamedTuple

import yaml

from mbproj.errors import Place, Problem


class Explanation(NamedTuple):
    """An explanation of errors whose text "context: problem" matches `pattern`. With `opening` the place is where the
    construct begins."""

    pattern: re.Pattern[str]
    message: str
    hint: str | None = None
    opening: bool = False


EXPLANATIONS = (
    Explanation(re.compile("quoted scalar: .*end of stream"), "this quote is not closed", None, True),
    Explanation(
        re.compile("quoted scalar: .*escape"),
        "this text has an unknown escape",
        "in single quotes a backslash is a backslash",
        True,
    ),
    Explanation(re.compile("quoted scalar: "), "this quoted text is not valid YAML", None, True),
    Explanation(re.compile("flow sequence: "), "this list is not closed, or a comma is missing in it", None, True),
    Explanation(re.compile("flow mapping: "), "this mapping is not closed, or a comma is missing in it", None, True),
    Explanation(
        re.compile("mapping values are not allowed"),
        "unexpected ':'",
        "indent the keys of one mapping alike, and quote a text that contains ': '",
    ),
    Explanation(re.compile("plain scalar: found unexpected ':'"), "unexpected ':'", "put a space after the ':'"),
    Explanation(re.compile("simple key: "), "':' is missing after this key", None, True),
    Explanation(
        re.compile("block (mapping|collection): "), "unexpected here", "indent the entries of one mapping or list alike"
    ),
    Explanation(re.compile("document start"), "unexpected text after the scene"),
    Explanation(re.compile("incompatible YAML"), "unknown YAML version", "leave the %YAML line out"),
    Explanation(re.compile("tag"), "tags ('!...') are not allowed", "leave the tag out"),
)
_TAB = Explanation(re.compile(""), "a tab cannot indent", "use spaces")


def syntax_problem(error: yaml.YAMLError, file: str, lines: list[str]) -> Problem:
    """The error as a Problem of `file`, whose lines are `lines`."""
    if not isinstance(error, yaml.MarkedYAMLError) or error.problem_mark is None:
        return Problem(f"not valid YAML: {error}", Place(file))
    place = _place(error.problem_mark, file, lines)
    said = f"{error.context}: {error.problem}"
    if "cannot start any token" in said:
        return _wrong_start(place)
    for explanation in EXPLANATIONS:
        if explanation.pattern.search(said):
            if explanation.opening and error.context_mark is not None:
                place = _place(error.context_mark, file, lines)
            return Problem(explanation.message, place, explanation.hint)
    return Problem(f"not valid YAML: {error.problem}", place)


def _wrong_start(place: Place) -> Problem:
    character = (place.text or "")[(place.column or 1) - 1 :][:1]
    if character == "\t":
        return Problem(_TAB.message, place, _TAB.hint)
    return Problem(f"a value cannot begin with '{character}'", place, "put it in quotes")


def _place(mark: yaml.Mark, file: str, lines: list[str]) -> Place:
    """The place of a mark; a mark behind the last line is placed at the end of that line."""
    if mark.line < len(lines):
        return Place(file, mark.line + 1, mark.column + 1, lines[mark.line])
    return Place(file, len(lines), len(lines[-1]) + 1, lines[-1])
