"""Changes values of a document: parameters by name, or any value by its path, as in `bodies.bar1.mass`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from mbproj.errors import InputError, Place, Problem, choose_from, did_you_mean
from mbproj.scene.text.document import compose
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode, as_mapping, describe, from_value

PARAMETERS, SIMULATION = "parameters", "simulation"
#: The number of keys in a path to a key of an item, as `bodies.bar1.mass`; the item need not have that key yet.
OF_ITEM = 3
#: Keys of `simulation` that exclude each other: a new one takes the place of the other.
EITHER = {"step": "tolerance", "tolerance": "step"}


class Change(NamedTuple):
    """A new value as a node, and the place where the change is given."""

    node: Node
    place: Place


class _NotThere(Exception):
    """The document has no such path; the arguments are the message and a hint."""


def changed(root: MappingNode, changes: Mapping[str, object]) -> tuple[MappingNode, list[Problem]]:
    """The document with these values, by a parameter's name or a path, and the problems of the changes. A value is a
    `Change`, or text or a number as --set has it."""
    problems: list[Problem] = []
    for name, value in changes.items():
        change = value
        try:
            if not isinstance(change, Change):
                change = _change_of(name, value)
            root = _with(root, name, change)
        except _NotThere as error:
            message, hint = error.args
            assert isinstance(change, Change)
            problems.append(Problem(message, change.place, hint))
        except InputError as error:
            problems += error.problems
    return root, problems


def _change_of(name: str, value: object) -> Change:
    """The change that --set gives, where a list or a mapping is in YAML's flow style."""
    place = Place(f"--set {name}")
    if isinstance(value, str) and value.lstrip()[:1] in ("[", "{"):
        node, problems = compose(value.strip(), place.file)
        if problems:
            raise InputError(problems)
        return Change(node, place)
    return Change(from_value(value, place), place)


def _with(root: MappingNode, name: str, change: Change) -> MappingNode:
    keys = tuple(name.split("."))
    if keys[0] == PARAMETERS and len(keys) == 2:
        return _with_parameter(root, keys[1], change)
    if len(keys) == 1 and (name in _parameters(root) or name not in root.values):
        return _with_parameter(root, name, change)
    whole = _inside(root, keys, 0, change)
    assert isinstance(whole, MappingNode)
    return whole


def _with_parameter(root: MappingNode, name: str, change: Change) -> MappingNode:
    known = _parameters(root)
    if name not in known:
        listed = f"parameters are: {', '.join(known)}" if known else "the scene has no parameters"
        raise _NotThere(f"unknown parameter '{name}'", did_you_mean(name, known) or listed)
    block = root.values[PARAMETERS]
    assert isinstance(block, MappingNode)
    return _with_value(root, PARAMETERS, _with_value(block, name, change.node, change.place), change.place)


def _parameters(root: MappingNode) -> Mapping[str, Node]:
    block = root.values.get(PARAMETERS)
    return block.values if isinstance(block, MappingNode) else {}


def _inside(node: Node, keys: tuple[str, ...], depth: int, change: Change) -> Node:
    """The node at keys[:depth] with the change at keys[depth:] in it."""
    if depth == len(keys):
        return change.node
    key = keys[depth]
    if isinstance(node, SequenceNode):
        if not (key.isascii() and key.isdigit() and int(key) < len(node.items)):
            places = f"its places are 0 to {len(node.items) - 1}" if node.items else "it is empty"
            raise _NotThere(f"'{'.'.join(keys[:depth])}' is a list and has no place '{key}'", places)
        items = list(node.items)
        items[int(key)] = _inside(items[int(key)], keys, depth + 1, change)
        return replace(node, items=tuple(items))
    mapping = _mapping_at(node, keys[:depth])
    keys = _with_dots(mapping, keys, depth)
    key = keys[depth]
    there = mapping.values.get(key)
    if there is None:
        there = _new(mapping, keys, depth, change)
    return _with_value(mapping, key, _inside(there, keys, depth + 1, change), change.place)


def _with_dots(mapping: MappingNode, keys: tuple[str, ...], depth: int) -> tuple[str, ...]:
    """The path, where keys that the mapping has as one key with dots are joined, as a coupler's coordinate."""
    if keys[depth] not in mapping.values:
        for end in range(len(keys), depth + 1, -1):
            key = ".".join(keys[depth:end])
            if key in mapping.values:
                return (*keys[:depth], key, *keys[end:])
    return keys


def _mapping_at(node: Node, path: tuple[str, ...]) -> MappingNode:
    if path == (SIMULATION, "projection") and isinstance(node, ScalarNode) and node.text:
        return MappingNode({"method": node}, {"method": node.place}, node.place)
    mapping = as_mapping(node)
    if mapping is None:
        raise _NotThere(
            f"'{'.'.join(path)}' is {describe(node)} and has no keys", "give a path to a value of the scene"
        )
    return mapping


def _new(mapping: MappingNode, keys: tuple[str, ...], depth: int, change: Change) -> Node:
    """An empty node for a key that the document leaves out. Raises _NotThere where the format has no such optional
    key."""
    optional = keys[0] == SIMULATION or (depth >= OF_ITEM - 1 and keys[0] != PARAMETERS)
    if not optional:
        path = ".".join(keys[: depth + 1])
        raise _NotThere(f"the scene has no '{path}'", choose_from(keys[depth], mapping.values))
    return ScalarNode("", change.place)


def _with_value(mapping: MappingNode, key: str, node: Node, place: Place) -> MappingNode:
    """The mapping with this value; a key that it excludes is dropped. A new key has the place `place`."""
    other = EITHER.get(key, "")
    values = {name: value for name, value in mapping.values.items() if name != other}
    places = {name: place for name, place in mapping.keys.items() if name != other}
    values[key] = node
    places.setdefault(key, place)
    return replace(mapping, values=values, keys=places)
