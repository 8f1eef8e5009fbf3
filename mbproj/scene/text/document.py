"""Scene text -> nodes with places, from PyYAML's events: no implicit types, no tags, no merge keys, bounded aliases."""

from __future__ import annotations

import io
import os
import re
import stat
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import yaml

from mbproj.base.errors import InputError, Place, Problem, did_you_mean
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode, WrittenKey

# --- A scene file's bytes -> its text and lines, or the one reason why it cannot be read ------------------------------


MAX_BYTES = 10_000_000
#: The characters that YAML does not allow in a file.
_UNPRINTABLE = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
#: The line ends of YAML.
_LINE_BREAK = re.compile("\r\n|[\r\n\x85\u2028\u2029]")
#: The formats of models, by the tag with which they begin.
_MODELS = {b"<mujoco": "MJCF", b"<robot": "URDF", b"<sdf": "SDF"}


def read_text(path: Path) -> str:
    """The text of the file, without byte order mark. Raises InputError with one problem."""
    place = Place(str(path))
    try:
        data = _bytes_of(path)
    except FileNotFoundError:
        raise InputError(Problem("there is no such file", place, _similar_file(path))) from None
    except IsADirectoryError:
        raise InputError(Problem("this is a directory, not a scene file", place)) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(Problem(f"cannot be read: {reason}", place)) from None
    if len(data) > MAX_BYTES:
        raise InputError(Problem(f"the file is larger than {MAX_BYTES // 1_000_000} MB", place))
    return _decode(data, place)


def _bytes_of(path: Path) -> bytes:
    """The bytes of the file or of a pipe (`<(...)` of a shell), at most one more than allowed.

    Raises InputError where nobody writes into a pipe, which mbproj would wait for without end.
    """
    opened = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    with os.fdopen(opened, "rb", buffering=0) as file, io.BufferedReader(file) as buffered:
        if hasattr(os, "set_blocking") and stat.S_ISFIFO(os.fstat(file.fileno()).st_mode):
            first = file.read(1)
            if first == b"":
                raise InputError(Problem("this is a pipe that nobody writes into", Place(str(path))))
            os.set_blocking(file.fileno(), True)
            return (first or b"") + buffered.read(MAX_BYTES)
        return buffered.read(MAX_BYTES + 1)


def lines_of(text: str, file: str) -> list[str]:
    """The lines of the text as YAML counts them. Raises InputError at a character that YAML does not allow."""
    lines = _LINE_BREAK.split(text)
    if _UNPRINTABLE.search(text) is not None:
        number, line = next((number, line) for number, line in enumerate(lines, 1) if _UNPRINTABLE.search(line))
        match = _UNPRINTABLE.search(line)
        assert match is not None
        problem = f"the character U+{ord(match[0]):04X} is not allowed in a scene file"
        raise InputError(Problem(problem, Place(file, number, match.start() + 1)))
    return lines


def _model_in(head: bytes) -> str | None:
    """The format of a model whose file begins with `head`; None where `mbproj import` reads no such format."""
    if not head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        return None
    return next((kind for tag, kind in _MODELS.items() if tag in head), None)


def _decode(data: bytes, place: Place) -> str:
    if data.startswith(b"\x89HDF"):
        raise InputError(Problem("this is a results file, not a scene", place, "'mbproj rerun' repeats its run"))
    if (kind := _model_in(data[:4096])) is not None:
        hint = f"'mbproj import {place.file} -o scene.yaml' makes a scene of it"
        raise InputError(Problem(f"this is a model in {kind}, not a scene", place, hint))
    if b"\0" in data:
        raise InputError(Problem("this is a binary file, not a scene", place, "a scene is YAML text in UTF-8"))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        problem = f"the byte 0x{data[error.start]:02x} is not UTF-8 text"
        raise InputError(Problem(problem, Place(place.file, line), "save the file as UTF-8")) from None


def _similar_file(path: Path) -> str | None:
    try:
        return did_you_mean(path.name, (other.name for other in path.parent.iterdir()))
    except (OSError, ValueError):
        return None


# --- Scene text -> nodes with places, from PyYAML's events ------------------------------------------------------------


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


# --- Values that a comma cuts in two ----------------------------------------------------------------------------------
# Inside { } and [ ] a comma ends a value, so that `{torque: max(0, t)}` has two keys.
# The pieces are joined again, so that the comma is the one problem reported.


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
    joined: list[WrittenKey] = []
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
            count, node = (
                2,
                replace(
                    _as_one_text([value, following[0]]),
                    text=f"{_without_quotes(value)}.{_without_quotes(following[0])}",
                ),
            )
            problems.append(_problem("{ }", node, f"decimals take a point: {_name(key)}: {node.text}"))
        joined.append(WrittenKey(key, place, node if count else value))
        at += count or 1
    return joined, problems


def _problem(inside: str, node: ScalarNode, hint: str) -> Problem:
    return Problem(f"this value is cut off: inside {inside} a comma ends it", node.place, hint)


def _keys_alone(entries: Sequence[WrittenKey]) -> list[Node]:
    """The keys of the entries up to the first that has a value."""
    alone: list[Node] = []
    for entry in entries:
        if _without_quotes(entry.value) != "":
            break
        alone.append(entry.key)
    return alone


def _without_quotes(node: Node) -> str | None:
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
    return _unclosed(_without_quotes(node) or "") > 0


def _in_parentheses(pieces: Sequence[Node]) -> int:
    """The number of pieces up to the one that closes the parentheses of the first; 0 where they stay open."""
    still_open = 0
    for count, piece in enumerate(pieces, 1):
        text = _without_quotes(piece)
        if text is None:
            return 0
        still_open += _unclosed(text)
        if still_open <= 0:
            return count
    return 0


def _decimal_comma(value: Node, following: Node) -> bool:
    """Whether the two are a number with a decimal comma: no key begins with a digit."""
    before, after = _without_quotes(value) or "", _without_quotes(following) or ""
    return _WHOLE_NUMBER.fullmatch(before) is not None and after[:1].isdecimal()


def _as_one_text(pieces: Sequence[Node]) -> ScalarNode:
    """The pieces as one text, with the characters of the line where all stand in one line."""
    texts = [piece for piece in pieces if isinstance(piece, ScalarNode)]
    first, last = texts[0], texts[-1]
    line = first.place.text
    if line is None or first.column is None or last.column is None or first.place.line != last.place.line:
        return replace(first, text=", ".join(piece.text for piece in texts), column=None)
    return replace(first, text=line[first.column - 1 : last.column - 1 + len(last.text)])
