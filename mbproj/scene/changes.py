"""Changes values of a document: parameters by name, or any value by its path, as in `bodies.bar1.mass`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import yaml

from mbproj.base.errors import InputError, Place, Problem, choose_from, did_you_mean
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


# --- Changes values in the text of a scene ----------------------------------------------------------------------------
# Its blocks in place, every other character as it was.


#: New texts by key; None removes a key, a mapping changes the keys inside of one.
Changes: TypeAlias = Mapping[str, "str | Changes | None"]
#: An edit: the first character, the one after the last, and the text that replaces them.
Edit = tuple[int, int, str]


def text_with_changes(text: str, changes: Changes) -> str:
    """The text of a scene with changes to blocks that it has. Comments stay; a new key comes last in its block.

    Raises ValueError where a block is written in a way that cannot be changed in place (an alias, for example).
    """
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    if not isinstance(root, yaml.MappingNode):
        raise ValueError("a scene is a mapping")
    return _changed(text, _edits(text, root, changes))


def with_simulation(text: str, changes: Changes) -> str:
    """The text of a scene with its `simulation` block changed, or with a new one; otherwise as `with_changes`."""
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    if not isinstance(root, yaml.MappingNode):
        raise ValueError("a scene is a mapping")
    block = dict(_entries(root)).get("simulation")
    if block is None:
        return f"{text}{'' if text.endswith(chr(10)) else chr(10)}simulation: {_flow(changes)}\n"
    return _changed(text, _edits(text, block[1], changes))


def _entries(node: yaml.MappingNode) -> Iterator[tuple[str, tuple[yaml.Node, yaml.Node]]]:
    for key, value in node.value:
        yield key.value, (key, value)


def _edits(text: str, block: yaml.Node, changes: Changes) -> Iterator[Edit]:
    """The edits inside of a block, or the one that replaces a value by a block."""
    if not isinstance(block, yaml.MappingNode):
        yield block.start_mark.index, block.end_mark.index, _lead(text, block) + _flow(changes)
        return
    there, names = dict(_entries(block)), dict[str, str]()
    for name in there:
        other = EITHER.get(name, "")
        names[name] = other if name in changes and changes[name] is None and other in changes else name
    remaining = {name: new for name, new in names.items() if changes.get(new, "") is not None}
    if block.flow_style and len(remaining) < len(there):
        items = [f"{new}: {_value(text, there[name][1], changes, new)}" for name, new in remaining.items()]
        items += [f"{name}: {_as_text(new)}" for name, new in _added(changes, names).items()]
        yield block.start_mark.index, block.end_mark.index, "{" + ", ".join(items) + "}"
        return
    for name, (key, value) in there.items():
        if name not in remaining:
            yield _removal(text, key, value)
        elif remaining[name] in changes:
            yield key.start_mark.index, key.end_mark.index, remaining[name]
            yield value.start_mark.index, _end(value), _value(text, value, changes, remaining[name])
    if _added(changes, names):
        yield _addition(text, block, _added(changes, names))


def _items(text: str, block: yaml.SequenceNode, changes: Changes) -> Iterator[Edit]:
    """The edits inside of a list; keys are the numbers of its items. Raises ValueError where an item is missing."""
    for name in changes:
        item = block.value[int(name)] if name.isdecimal() and int(name) < len(block.value) else None
        if item is None:
            raise ValueError(f"the list has no item {name}")
        yield item.start_mark.index, _end(item), _value(text, item, changes, name)


def _value(text: str, value: yaml.Node, changes: Changes, name: str) -> str:
    """The text of a value after the changes."""
    start, end, new = value.start_mark.index, _end(value), changes.get(name)
    if isinstance(new, Mapping) and isinstance(value, yaml.MappingNode):
        return _changed(text[:end], _edits(text[:end], value, new))[start:]
    if isinstance(new, Mapping) and isinstance(value, yaml.SequenceNode):
        return _changed(text[:end], _items(text[:end], value, new))[start:]
    return text[start:end] if new is None else _as_text(new)


def _changed(text: str, edits: Iterator[Edit]) -> str:
    for start, end, new in sorted(edits, reverse=True):
        text = text[:start] + new + text[end:]
    return text


def _added(changes: Changes, names: Mapping[str, str]) -> dict[str, str | Changes | None]:
    """The changes to keys that the block does not have."""
    return {name: new for name, new in changes.items() if new is not None and name not in names.values()}


def _end(node: yaml.Node) -> int:
    """The character at which a value ends; a block ends with its last value, before any comment."""
    if isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        return _end(last[1] if isinstance(node, yaml.MappingNode) else last)
    return int(node.end_mark.index)


def _removal(text: str, key: yaml.Node, value: yaml.Node) -> Edit:
    """The edit that removes the lines of a key and its value; the last line may have no line end."""
    newline, start = text.find("\n", _end(value)), text.rfind("\n", 0, key.start_mark.index) + 1
    if newline < 0:
        return len(text[:start].rstrip("\r\n")), len(text), ""
    return start, newline + 1, ""


def _addition(text: str, block: yaml.MappingNode, added: Changes) -> Edit:
    """The edit that adds new keys after the last one, in the style of the block."""
    if block.flow_style:
        inside = _flow(added)[1:-1]
        end = _end(block.value[-1][1]) if block.value else block.start_mark.index + 1
        return end, end, f", {inside}" if block.value else inside
    newline, line_end = text.find("\n", _end(block.value[-1][1])), "\r\n" if "\r\n" in text else "\n"
    end, before = (len(text), line_end) if newline < 0 else (newline + 1, "")
    indent = " " * block.value[0][0].start_mark.column
    return end, end, before + "".join(f"{indent}{name}: {_as_text(new)}{line_end}" for name, new in added.items())


def _lead(text: str, block: yaml.Node) -> str:
    """A space before a value where there was none: `simulation:` with nothing after it."""
    return " " if text[block.start_mark.index - 1 : block.start_mark.index] == ":" else ""


def _as_text(new: str | Changes | None) -> str:
    return _flow(new) if isinstance(new, Mapping) else str(new)


def _flow(changes: Changes) -> str:
    entries = {name: new for name, new in changes.items() if new is not None}
    if set(entries) == {"method"}:
        return _as_text(entries["method"])
    return "{" + ", ".join(f"{name}: {_as_text(new)}" for name, new in entries.items()) + "}"
