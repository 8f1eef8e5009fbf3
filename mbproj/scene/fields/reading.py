"""The state of one reading: the names that expressions and references may use, the places, the problems found."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import field
from math import nan
from typing import TYPE_CHECKING, Any

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Place, Problem
from mbproj.scene.expressions.evaluate import Unavailable, Value, evaluate
from mbproj.scene.expressions.syntax_tree import Expression, ExpressionError, NumberNode, names, parse
from mbproj.scene.expressions.units import SYMBOLS, Dimension
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import CasesNode, MappingNode, Node, ScalarNode, SequenceNode, as_mapping

if TYPE_CHECKING:
    from mbproj.functions.program import Program
    from mbproj.scene.expressions.dimensions import Inferred
    from mbproj.scene.text.reading_cache import ReadingCache


class Unfit(Exception):
    """A value is well written but impossible. The message follows the key, as in "'axis' is a zero vector"."""

    def __init__(self, message: str, hint: str | None = None) -> None:
        super().__init__(message)
        self.message, self.hint = message, hint


@dataclass
class Reading:
    """The state of one reading, to which fields add. `names` are the parameters (None: wrong, and reported), `items`
    the names of each block's items. `notes` are on legal input that may be a mistake. `units` are the SI units of the
    numbers by path, where they are known. `cache` has the values of an earlier reading, or stores those of this one.
    `inner` are the full names of the short names that expressions may use within an item. `dimension_of` returns the
    dimension of a signal, a state, or a name with a point, None where it is not known."""

    items: Mapping[str, Collection[str]] = field(default_factory=dict)
    names: dict[str, Value | None] = field(default_factory=dict)
    places: dict[KeyPath, Place] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    notes: list[Problem] = field(default_factory=list)
    units: dict[KeyPath, str] = field(default_factory=dict)
    cache: ReadingCache | None = None
    inner: Mapping[str, str] = field(default_factory=dict)
    dimension_of: Callable[[str, Reading], Dimension | None] = lambda name, reading: None

    def read(self, kind: Any, node: Node, path: KeyPath) -> Any:
        """The value of the field `kind` at `path`. It comes from an earlier reading where nothing has changed that it
        depends on."""
        self.places[path] = node.place
        if self.cache is None or kind.defines_names:
            return kind.read(node, path, self)
        if self.cache.is_full:
            entry = self.cache.again(kind, node, path, self.names, self.items)
            if entry is None:
                return kind.read(node, path, self)
            self.notes += entry.notes
            return entry.value
        problems, notes = len(self.problems), len(self.notes)
        value = kind.read(node, path, self)
        if len(self.problems) == problems:
            self.cache.keep(kind, node, path, value, self.notes[notes:])
        return value

    def report(self, message: str, place: Place | None, hint: str | None = None) -> None:
        """Record a problem; the reading goes on."""
        self.problems.append(Problem(message, place, hint))

    def parse(self, node: ScalarNode, variables: Iterable[str] = ()) -> Expression | None:
        """The tree of an expression that may name `variables` beside parameters; None where it is wrong, which is
        reported at the character."""
        if isinstance(node, CasesNode):
            return NumberNode(node.numbers, 0)
        try:
            return parse(node.text, self._named_as_units(variables))
        except ExpressionError as error:
            self.report(error.message, node.place_at(error.at), error.hint)
            return None

    def _names_channel(self, node: ScalarNode, tree: Expression) -> bool:
        """Whether an expression that must be constant names a signal or a state, which is reported."""
        blocks = [self.items[block] for block in ("signals", "states") if self.items.get(block)]
        if not blocks:
            return False
        for name in sorted(names(tree) - self.names.keys()):
            if any(name in block for block in blocks):
                hint = "forces, the numbers of springs, dry friction, signals and states may name it"
                self.report(f"'{name}' changes during a run, and this number is constant", node.place, hint)
                return True
        return False

    def _named_as_units(self, variables: Iterable[str]) -> frozenset[str]:
        """The symbols of units that are names of parameters, signals, states or variables of this expression."""
        named = (
            tuple(variables),
            self.names,
            self.inner,
            *(self.items.get(block, ()) for block in ("signals", "states")),
        )
        return frozenset(symbol for symbol in SYMBOLS for names in named if symbol in names)

    def program(
        self, node: ScalarNode, tree: Expression | None, variables: Mapping[str, int], known: Mapping[str, Inferred]
    ) -> tuple[Program, Inferred] | None:
        """The program of the node's tree and the dimension of its value; None where it is wrong, which is reported.
        `known` are the dimensions of variables."""
        from mbproj.functions.program import Program
        from mbproj.scene.expressions.compiled import compiled

        try:
            if tree is not None:
                code, inferred = compiled(tree, self.names, variables, known)
                return Program(code, node.text.strip()), inferred
        except ExpressionError as error:
            self.report(error.message, node.place_at(error.at), error.hint)
        except Unavailable:
            pass
        return None

    def value(self, node: ScalarNode, tree: Expression | None) -> Value | None:
        """The value of the node's tree; None where it has none, which is reported at the character."""
        if tree is not None and self._names_channel(node, tree):
            return None
        try:
            return None if tree is None else evaluate(tree, self.names)
        except ExpressionError as error:
            self.report(error.message, node.place_at(error.at), error.hint)
        except Unavailable:
            pass
        return None


def in_text_order(problems: Iterable[Problem]) -> list[Problem]:
    """Each problem once: those of the command line first, then those of the file by line and column."""

    def position(problem: Problem) -> tuple[int, int]:
        place = problem.place
        return (place.line or 0, place.column or 0) if place is not None else (0, 0)

    return sorted(dict.fromkeys(problems), key=position)


def either(names: Iterable[str]) -> str:
    """The names as a choice: "a", "a or b", "a, b or c"."""
    *others, last = names
    return f"{', '.join(others)} or {last}" if others else last


def label(path: KeyPath) -> str:
    """The name of the value at `path` in messages, by the nearest key."""
    return next((f"'{key}'" for key in reversed(path) if isinstance(key, str)), "a scene")


#: The blocks whose items other items may name.
_REFERRED = ("bodies", "curves", "joints", "forces", "motions", "markers", "signals", "states", "controllers")
#: The blocks whose items declare units of what expressions name, and the keys of an item that do so.
_DECLARING, _DECLARED_BY = ("signals", "states", "controllers", "forces"), ("unit", "type", "initial", "scale")


def items_of(root: MappingNode) -> dict[str, dict[str, None]]:
    """The names of the items that others may name, by block; an item may have faults."""
    blocks = {key: as_mapping(root.values[key]) for key in _REFERRED if key in root.values}
    return {key: dict.fromkeys(block.keys) for key, block in blocks.items() if block is not None}


def declares_units(changes: Mapping[str, object]) -> bool:
    """Whether changes, by path, may change the unit of a name, so that all expressions have to be checked again."""
    paths = [path.split(".") for path in changes]
    return any(path[0] in _DECLARING and (len(path) < 3 or path[-1] in _DECLARED_BY) for path in paths)


def number_at(root: MappingNode, path: str, reading: Reading) -> float:
    """The number at a path, or of the parameter with this name; NaN where there is no constant number."""
    keys = path.split(".")
    node: Node = root
    for key in keys if len(keys) > 1 else ("parameters", *keys):
        inside = node.values.get(key) if isinstance(node, MappingNode) else None
        if isinstance(node, SequenceNode) and key.isascii() and key.isdecimal() and int(key) < len(node.items):
            inside = node.items[int(key)]
        if inside is None:
            return nan
        node = inside
    if not isinstance(node, ScalarNode):
        return nan
    value = reading.value(node, reading.parse(node))
    return nan if value is None else value.number
