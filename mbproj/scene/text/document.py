"""Scene text -> nodes with places, from PyYAML's events: no implicit types, no tags, no merge keys, bounded aliases."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import yaml

from mbproj.errors import InputError, Place, Problem
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode, WrittenKey
from mbproj.scene.text.source import lines_of


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


MAX_NODES = 500_000
MAX_DEPTH = 50
#: The number of characters that add one to the weight of a node: aliases that repeat a text cost time by its length.
_CHARACTERS = 16
#: libyaml's parser, where PyYAML has it: five times as fast, with the same events and marks except for two cases. It
#: refuses {a:}, which PyYAML's own parser reads as an empty value, and places the empty value of {a: } a column later.
_LOADER = getattr(yaml, "CBaseLoader", yaml.BaseLoader)


def compose(text: str, file: str, loader: type = _LOADER) -> tuple[Node, list[Problem]]:
    """The root node of the one document in `text`, and the problems that did not stop the reading.

    Raises InputError with one problem where the text is no YAML, has no document or several, or outgrows the bounds.
    """
    lines = lines_of(text, file)
    try:
        composer = _Composer(iter(loader(text).get_event, None), file, lines)
        return composer.document(), composer.problems
    except yaml.YAMLError as error:
        raise InputError(syntax_problem(error, file, lines)) from None


class _Composer:
    def __init__(self, events: Iterator[yaml.Event], file: str, lines: list[str]) -> None:
        self._events, self._file, self._lines, self._last = events, file, lines, len(lines) - 1
        self._anchors: dict[str, tuple[Node, int] | None] = {}
        self._weight = 0
        self.problems: list[Problem] = []

    def document(self) -> Node:
        next(self._events)  # the start of the stream
        if isinstance(next(self._events), yaml.StreamEndEvent):
            raise InputError(Problem("the file is empty", Place(self._file), "a scene begins with 'mbproj: 1'"))
        root = self._node(next(self._events), 1)
        next(self._events)  # the end of the document
        after = next(self._events)
        if not isinstance(after, yaml.StreamEndEvent):
            raise InputError(Problem("a second document begins here", self._place(after), "a file holds one scene"))
        return root

    def _node(self, event: yaml.Event, depth: int) -> Node:
        if depth > MAX_DEPTH:
            raise InputError(Problem(f"nested more than {MAX_DEPTH} levels deep", self._place(event)))
        if isinstance(event, yaml.ScalarEvent) and event.tag is None and not event.anchor:  # most nodes are such
            return self._scalar(event, 1)
        if isinstance(event, yaml.AliasEvent):
            return self._alias(event)
        assert isinstance(event, yaml.NodeEvent)
        if getattr(event, "tag", None) is not None:
            self._report("tags ('!...') are not allowed", self._place(event), "leave the tag out")
        before = self._weight
        if event.anchor:
            self._anchors[event.anchor] = None
        self._weigh(1, event)
        node = self._content(event, depth)
        if event.anchor:
            self._anchors[event.anchor] = (node, self._weight - before)
        return node

    def _content(self, event: yaml.NodeEvent, depth: int) -> Node:
        if isinstance(event, yaml.SequenceStartEvent):
            return self._sequence(event, depth)
        if isinstance(event, yaml.MappingStartEvent):
            return self._mapping(event, depth)
        assert isinstance(event, yaml.ScalarEvent)
        return self._scalar(event, 0)

    def _alias(self, event: yaml.AliasEvent) -> Node:
        if event.anchor not in self._anchors:
            raise InputError(Problem(f"there is no '&{event.anchor}' before this alias", self._place(event)))
        known = self._anchors[event.anchor]
        if known is None:
            raise InputError(Problem(f"'*{event.anchor}' repeats a value that it is a part of", self._place(event)))
        self._weigh(known[1], event)
        return known[0]

    def _scalar(self, event: yaml.ScalarEvent, weight: int) -> ScalarNode:
        place, value = self._place(event), event.value
        line, column = place.text, place.column
        assert line is not None and column is not None
        self._weigh(weight + len(value) // _CHARACTERS, event)
        if event.style in ("'", '"'):
            column += 1
        return ScalarNode(value, place, column if line.startswith(value, column - 1) else None)

    def _sequence(self, event: yaml.Event, depth: int) -> SequenceNode:
        items = []
        while not isinstance(inner := next(self._events), yaml.SequenceEndEvent):
            items.append(self._node(inner, depth + 1))
        if getattr(event, "flow_style", False) and any("(" in _text(item) for item in items):
            from mbproj.scene.text.cut_off import whole_items

            items, cuts = whole_items(items)
            self.problems += cuts
        return SequenceNode(tuple(items), self._place(event))

    def _mapping(self, event: yaml.Event, depth: int) -> MappingNode:
        values: dict[str, Node] = {}
        places: dict[str, Place] = {}
        for key, place, value in self._entries(event, depth):
            if self._usable(key, place, places):
                assert isinstance(key, ScalarNode)
                values[key.text] = replace(value, place=place) if isinstance(value, MappingNode) else value
                places[key.text] = place
        return MappingNode(values, places, self._place(event))

    def _entries(self, event: yaml.Event, depth: int) -> list[WrittenKey]:
        entries = []
        while not isinstance(inner := next(self._events), yaml.MappingEndEvent):
            key = self._node(inner, depth + 1)
            place = key.place if isinstance(inner, yaml.ScalarEvent) else self._place(inner)
            entries.append(WrittenKey(key, place, self._node(next(self._events), depth + 1)))
        if getattr(event, "flow_style", False) and any(_text(entry.value) == "" for entry in entries):
            from mbproj.scene.text.cut_off import whole_entries

            entries, cuts = whole_entries(entries)
            self.problems += cuts
        return entries

    def _usable(self, key: Node, place: Place, places: dict[str, Place]) -> bool:
        """Whether the node can be a key, and the mapping does not have it yet; if not, that is reported."""
        if not isinstance(key, ScalarNode):
            self._report("a key must be text", place)
        elif key.text == "<<":
            self._report("merge keys ('<<') are not supported", place, "write the keys out")
        elif key.text in places:
            self._report(f"duplicate key '{key.text}'", place, f"it is first given in line {places[key.text].line}")
        else:
            return True
        return False

    def _weigh(self, weight: int, event: yaml.Event) -> None:
        self._weight += weight
        if self._weight > MAX_NODES:
            raise InputError(
                Problem(
                    f"more than {MAX_NODES} values, with aliases counted where they are repeated", self._place(event)
                )
            )

    def _place(self, event: yaml.Event) -> Place:
        mark = event.start_mark
        assert mark is not None
        line = mark.line if mark.line < self._last else self._last
        return Place(self._file, line + 1, mark.column + 1, self._lines[line])

    def _report(self, message: str, place: Place, hint: str | None = None) -> None:
        self.problems.append(Problem(message, place, hint))


def _text(node: Node) -> str:
    """The text of a scalar; a blank for other nodes."""
    return node.text if isinstance(node, ScalarNode) else " "
