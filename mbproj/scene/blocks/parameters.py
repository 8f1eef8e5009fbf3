"""The `parameters` block: expressions that may use each other in any order."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from typing import ClassVar

from mbproj.base.errors import Place
from mbproj.scene.expressions.evaluate import RESERVED, Value
from mbproj.scene.expressions.syntax_tree import Expression, names
from mbproj.scene.expressions.units import BARE
from mbproj.scene.fields.fields import Field, Schema, mapping_schema, names_schema
from mbproj.scene.fields.quantities import Number, unit_text
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, as_mapping, describe

#: The pattern of names that expressions can use, and the rule in words.
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
NAME_RULE = "letters, digits and _, and does not begin with a digit"


class Parameters(Field[Mapping[str, float]]):
    """Numbers by name, from expressions over each other. Reading them defines the names of all other expressions."""

    node_type: ClassVar[type] = MappingNode
    defines_names: ClassVar[bool] = True

    @property
    def expects(self) -> str:
        return "a mapping {name: a number}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Mapping[str, float] | None:
        mapping = as_mapping(node)
        if mapping is None:
            self.reject(node, path, reading)
            return None
        trees: dict[str, Expression] = {}
        reading.names.update(dict.fromkeys(mapping.values))  # before any is read: they decide which words are units
        for name, value in mapping.values.items():
            where = (*path, name)
            reading.places[where] = value.place
            tree = _tree(name, value, mapping.keys[name], reading)
            if tree is not None:
                trees[name] = tree
        for name in _in_order(trees, mapping, reading):
            scalar, key = mapping.values[name], (*path, name)
            assert isinstance(scalar, ScalarNode)
            of_tree = reading.value(scalar, trees[name])
            reading.names[name] = _without_unit_unknown(of_tree)
            reading.units[key] = unit_text(None, None if of_tree is None else of_tree.dimension)
        known = {name: of_tree.number for name in mapping.values if (of_tree := reading.names[name]) is not None}
        return known if len(known) == len(mapping.values) else None

    def schema(self) -> Schema:
        number = Number(None).schema()
        return {**mapping_schema(self.expects, empty=True), **names_schema(NAME, RESERVED, number)}


def _tree(name: str, node: Node, key: Place, reading: Reading) -> Expression | None:
    """The tree of one parameter; None where the name or the expression is wrong, which is reported."""
    if name in RESERVED:
        reading.report(f"'{name}' is a reserved name", key, "give the parameter another name")
        return None
    if not NAME.fullmatch(name):
        reading.report(
            f"'{name}' cannot name a parameter",
            key,
            f"a name has {NAME_RULE}",
        )
        return None
    if not isinstance(node, ScalarNode) or not node.text.strip():
        reading.report(f"'{name}' needs a number, found {describe(node)}", node.place)
        return None
    return reading.parse(node)


def _without_unit_unknown(value: Value | None) -> Value | None:
    """The value, of unknown dimension where it was given without a unit: such a parameter may stand for any."""
    return replace(value, dimension=None) if value is not None and value.dimension == BARE else value


def _in_order(trees: Mapping[str, Expression], mapping: MappingNode, reading: Reading) -> list[str]:
    """The names of the parameters, each after those that it uses. Parameters in a cycle are reported, and left out with
    all that use them."""
    uses = {name: sorted(names(tree) & trees.keys()) for name, tree in trees.items()}
    sorter = TopologicalSorter(uses)
    with suppress(CycleError):  # names only one cycle
        sorter.prepare()
    ordered: list[str] = []
    while sorter.is_active() and (ready := sorter.get_ready()):
        ordered += ready
        sorter.done(*ready)
    done = set(ordered)
    for cycle in _cycles(uses, dict.fromkeys(name for name in uses if name not in done)):
        shown = cycle if len(cycle) <= 8 else [*cycle[:7], "..."]
        reading.report(
            f"parameters that depend on each other: {' -> '.join([*shown, cycle[0]])}",
            mapping.values[cycle[0]].place,
            "give one of them a number",
        )
    return ordered


def _cycles(uses: Mapping[str, list[str]], blocked: Mapping[str, None]) -> list[list[str]]:
    """The cycles among the `blocked` names, found by going from each to the first blocked name that it uses. There is
    at least one such cycle."""
    seen: set[str] = set()
    cycles = []
    for start in blocked:
        walk: list[str] = []
        name = start
        while name not in seen:
            seen.add(name)
            walk.append(name)
            name = next(other for other in uses[name] if other in blocked)
        if name in walk:
            cycles.append(walk[walk.index(name) :])
    return cycles
