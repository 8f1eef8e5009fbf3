"""Values that a user gives by name: coordinates of joints, control signals of actuators, motions of driven joints."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.base.text import plain_number
from mbproj.formats.chains import Coordinates
from mbproj.formats.mechanism import Bare, GivenSignal, ImportedMechanism, Signals
from mbproj.formats.yaml_text import number
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse
from mbproj.scene.text.document import compose, read_text
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode


def read_pose(path: Path) -> dict[str, float]:
    """Read coordinates by the name of the model's joint. Raises InputError at a value that is no number."""
    nodes, problems = _values_by_name(path, "a pose is a mapping of joints", "write lines as in 'hinge: 0.3'")
    coordinates: dict[str, float] = {}
    for name, node in nodes.items():
        try:
            coordinates[name] = plain_number(_text(node))
        except ValueError:
            problems.append(Problem(f"'{name}' needs a number", node.place, "give it in rad or m"))
    if problems:
        raise InputError(problems)
    return coordinates


def read_signals(path: Path) -> Signals:
    """Read signals by name from a YAML mapping. Raises InputError at a value that is no expression of t."""
    what = "signals are a mapping of names and expressions of t"
    nodes, problems = _values_by_name(path, what, "write lines as in 'hinge: 0.3 * sin(2*t)'")
    return _checked({name: GivenSignal(_text(node), node.place) for name, node in nodes.items()}, problems)


def _values_by_name(path: Path, what: str, hint: str) -> tuple[Mapping[str, Node], list[Problem]]:
    """The values of a file by name, and its problems. Raises InputError where it is no mapping."""
    root, problems = compose(read_text(path), str(path))
    if not isinstance(root, MappingNode):
        raise InputError(Problem(what, root.place, hint))
    return root.values, problems


def _text(node: Node) -> str:
    return node.text if isinstance(node, ScalarNode) else ""


def signals_of(source: Mapping[str, str | float] | str | Path, what: str) -> Signals:
    """Signals of a mapping, which messages call `what`, or of the file at a path."""
    if isinstance(source, (str, Path)):
        return read_signals(Path(source))
    return _checked({name: GivenSignal(str(text), Place(f"{what}['{name}']")) for name, text in source.items()}, [])


def _checked(signals: Signals, problems: list[Problem]) -> Signals:
    """Return the signals. Raises InputError, all problems at once, where one is no expression of t."""
    for name, signal in signals.items():
        try:
            compiled(parse(signal.text), {}, {"t": 0})
        except ExpressionError as error:
            problems.append(Problem(f"'{name}': {error.message}", signal.place, error.hint or "write a function of t"))
    if problems:
        raise InputError(problems)
    return signals


def refuse_unknown(signals: Signals, able: list[str], what: str) -> None:
    """Raises InputError at the first name that is not in `able`; `what` describes the names in the message."""
    for name, signal in signals.items():
        if name not in able:
            raise InputError(Problem(f"'{name}' is no {what}", signal.place, choose_from(name, able)))


def add_motions(
    mechanism: ImportedMechanism, coordinates: Coordinates, motions: Signals, start: Mapping[str, float]
) -> None:
    """Add motions that drive joint coordinates as functions of time; `start` are their values at the pose."""
    refuse_unknown(motions, list(coordinates), "joint of the model with a coordinate")
    for name, signal in motions.items():
        joint, coordinate = coordinates[name]
        begun = start.get(name, 0.0)
        text = signal.text if not begun else f"{signal.text} - ({number(begun)})"
        mechanism.motions[name] = {"joint": joint, coordinate: Bare(text)}
