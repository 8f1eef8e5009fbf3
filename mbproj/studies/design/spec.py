"""The file of a design: a scene, the varied numbers with their bounds, and the matches, goals and constraints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place
from mbproj.scene.blocks.expectations import A_MEASURE as RECORD_OF_MEASURE
from mbproj.scene.blocks.expectations import (
    EXPECTATION,
    MEASURE,
    SUBJECTS,
    ExpectationKeys,
    Measure,
    complaints,
    items_of,
    measures_of,
    untimely,
)
from mbproj.scene.changes import Change
from mbproj.scene.expressions.evaluate import Unavailable, Value, evaluate
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse
from mbproj.scene.expressions.units import Dimension
from mbproj.scene.fields.fields import ByPath, NameChoice, Named, OneOf, Record, Text
from mbproj.scene.fields.quantities import Integer, Number, agrees, dimension_of, unit_text
from mbproj.scene.fields.reading import Reading, in_text_order
from mbproj.scene.ranges import BOUNDS, Uniform, column_of, read_mapping, scene_named, units_of
from mbproj.scene.records import Expectation, KeyPath
from mbproj.scene.scene import Scene, SceneText
from mbproj.scene.settings import settings_to_run
from mbproj.scene.text.nodes import MappingNode
from mbproj.studies.design.target import Match, Target

#: The default number of starts, and the default seed of their points.
STARTS, SEED = 20, 0
FORMAT = "1"
_OF = {key: EXPECTATION.keys[key] for key in SUBJECTS}
MATCH: Record[ExpectationKeys] = Record(
    "a match",
    {
        **_OF,
        "quantity": EXPECTATION.keys["quantity"],
        "through": Text(),
        "over": Text(),
        "columns": ByPath("what: heading of the column", Text()),
        "weight": Number(above=0.0),
        "deviation": Measure(above=0.0),
    },
    dict,
    required=("through",),
    choices=(OneOf(tuple(SUBJECTS), needed=True, hint="a match is of one thing; write another for the other"),),
)
SIDES = ("at_least", "at_most", "equals")
LIMIT: Record[ExpectationKeys] = Record(
    "a constraint",
    {**RECORD_OF_MEASURE.keys, "expression": Text(), **dict.fromkeys(SIDES, MEASURE)},
    dict,
    choices=(
        OneOf((*SUBJECTS, "expression"), needed=True, hint="a constraint is of one thing; write another for the other"),
        OneOf(SIDES, needed=True, hint="a constraint has one side; write another for the other"),
    ),
)
DESIGN: Record[dict[str, Any]] = Record(
    "a design",
    {
        "design": NameChoice("format version", lambda: (FORMAT,)),
        "scene": Text(),
        "vary": ByPath(
            "path of a number of the scene: [low, high]",
            BOUNDS,
            "say what varies, as in  parameters.length: [0.8 m, 1.2 m]",
        ),
        "match": Named("match", MATCH),
        "minimise": Named("goal", RECORD_OF_MEASURE),
        "maximise": Named("goal", RECORD_OF_MEASURE),
        "subject_to": Named("constraint", LIMIT),
        "starts": Integer(1),
        "seed": Integer(0),
    },
    dict,
    required=("design", "scene", "vary"),
)


@dataclass(frozen=True)
class Goal:
    """A measure to be minimised (`sign` 1) or maximised (`sign` -1)."""

    measure: Expectation
    sign: float


@dataclass(frozen=True)
class DesignLimit:
    """A constraint on a measure, or on an expression of the scene's parameters. `side` is "at_least", "at_most" or
    "equals"; the bound is in the SI unit `unit`."""

    name: str
    side: str
    bound: float
    unit: str
    measure: Expectation | None = None
    expression: str = ""


@dataclass(frozen=True, eq=False)
class DesignSpec:
    """The content of a design's file. d numbers with these `paths` vary between `low` and `high` (d,), in `units`.
    `scene_numbers` (d,): their values in the scene, NaN where unknown. `notes`: remarks on possible mistakes."""

    path: Path
    text: str = field(repr=False)
    scene: SceneText
    paths: tuple[str, ...]
    low: Array
    high: Array
    scene_numbers: Array
    units: tuple[str, ...]
    targets: tuple[Target, ...]
    goals: tuple[Goal, ...]
    limits: tuple[DesignLimit, ...]
    starts: int
    seed: int
    places: Mapping[KeyPath, Place] = field(repr=False)
    notes: tuple[str, ...] = ()

    def place(self, *path: str | int) -> Place | None:
        """The place of a key in the file."""
        return self.places.get(path)


def read_spec(path: Path) -> DesignSpec:
    """The design in the file at `path`. Raises InputError with every problem, at its place in the file, the scene or
    the measurements."""
    text, root, reading = read_mapping(path, DESIGN.what, f"it begins with 'design: {FORMAT}'")
    scene, base = scene_named(path, root, reading, DESIGN)
    reading.items = items_of(base)
    blocks = DESIGN.read(root, (), reading)
    if blocks is None:
        raise InputError(in_text_order(reading.problems))
    _check_wanted(blocks, root, reading)
    _check_measures(blocks, base, reading)
    units = units_of({path: each.dimension for path, each in blocks["vary"].items()}, scene)
    _check_bounds(blocks["vary"], units, scene, reading)
    if reading.problems:
        raise InputError(in_text_order(reading.problems))
    limits = tuple(_limits(blocks.get("subject_to", {}), base, scene, reading))
    matches = [Match(name, entry, base, path.parent, reading) for name, entry in blocks.get("match", {}).items()]
    targets = tuple(target for match in matches if (target := match.target()) is not None)
    data = sum(target.values.size for target in targets)
    if targets and data < len(blocks["vary"]) and not reading.problems:
        message = f"{len(blocks['vary'])} numbers vary, and there are {data} to match"
        reading.report(message, reading.places[("vary",)], "vary fewer, or match more")
    if reading.problems:
        raise InputError(in_text_order(reading.problems))
    bounds: Mapping[str, Uniform] = blocks["vary"]
    return DesignSpec(
        path=path,
        text=text,
        scene=scene,
        paths=tuple(bounds),
        low=np.array([each.low for each in bounds.values()]),
        high=np.array([each.high for each in bounds.values()]),
        scene_numbers=np.array(scene.numbers(tuple(bounds))),
        units=tuple(units.values()),
        targets=targets,
        goals=tuple(_goals(blocks, base)),
        limits=limits,
        starts=blocks.get("starts", STARTS),
        seed=blocks.get("seed", SEED),
        places=reading.places,
        notes=tuple(note for match in matches for note in match.notes),
    )


def _check_wanted(blocks: Mapping[str, Any], root: MappingNode, reading: Reading) -> None:
    """Report a design without matches and goals, or with both."""
    goals = [key for key in ("minimise", "maximise") if blocks.get(key)]
    if not blocks.get("match") and not goals:
        hint = "add match: {NAME: {marker: .., through: FILE.csv}}, or minimise: {NAME: {a measure}}"
        reading.report("nothing is matched, minimised or maximised", root.place, hint)
    if blocks.get("match") and goals:
        hint = "match alone, and bound the other by 'subject_to'"
        reading.report(f"'match' and '{goals[0]}' cannot both be given", root.keys[goals[0]], hint)
    names = [name for key in ("minimise", "maximise") for name in blocks.get(key, {})]
    for name in blocks.get("maximise", {}):
        if names.count(name) > 1:
            reading.report(f"two goals are called '{name}'", reading.places[("maximise", name)], "rename one")


def _check_measures(blocks: Mapping[str, Any], base: Scene, reading: Reading) -> None:
    """Report measures of goals and constraints that the scene does not have, and times without a sample."""
    for block in ("minimise", "maximise", "subject_to"):
        measures = {name: each for name, each in blocks.get(block, {}).items() if "expression" not in each}
        for name, each in measures.items():
            if "at" not in each:
                reading.report("missing key 'at'", reading.places[(block, name)], "add it: end, maximum, largest, ..")
            if not {"quantity", "diagnostic"} & each.keys():
                reading.report("missing key 'quantity'", reading.places[(block, name)], "add it")
        whole = {
            name: each for name, each in measures.items() if "at" in each and {"quantity", "diagnostic"} & each.keys()
        }
        settings = settings_to_run(base, by_options=False)
        for complaint in (*complaints(whole, base), *untimely(whole, settings)):
            where = (block, *complaint.path[1:])
            reading.report(complaint.message, reading.places[where], complaint.hint)


def _check_bounds(bounds: Mapping[str, Uniform], units: Mapping[str, str], scene: SceneText, reading: Reading) -> None:
    """Report bounds in a unit that does not fit the number, and problems of a bound itself in the scene. Problems of
    values that follow from it are not reported, as the arc cosine of a triangle that does not close. Such a design only
    does not run."""
    for path, each in bounds.items():
        if each.dimension is not None and not dimension_of(units[path]).agrees(each.dimension):
            what = f"'{column_of(path)}' is in {units[path]}, and its bounds are in {unit_text(None, each.dimension)}"
            reading.report(what, reading.places[("vary", path)], f"give them in {units[path]}")
        for node in each.nodes:
            try:
                scene.scene({path: Change(node, reading.places[("vary", path)])})
            except InputError as error:
                file = node.place.file
                reading.problems += [each for each in error.problems if each.place and each.place.file == file]


def _goals(blocks: Mapping[str, Any], base: Scene) -> Iterator[Goal]:
    for block, sign in (("minimise", 1.0), ("maximise", -1.0)):
        for measure in measures_of(blocks.get(block, {}), base):
            yield Goal(measure, sign)


def _limits(
    limits: Mapping[str, ExpectationKeys], base: Scene, scene: SceneText, reading: Reading
) -> Iterator[DesignLimit]:
    measures = {name: each for name, each in limits.items() if "expression" not in each}
    known = {measure.name: measure for measure in measures_of(measures, base)}
    names = {name: Value(number, None) for name, number in base.parameters.items()}
    units = units_of({f"parameters.{name}": None for name in names}, scene)
    with_units = {
        name: Value(each.number, dimension_of(unit) if unit else None)
        for (name, each), unit in zip(names.items(), units.values(), strict=True)
    }
    for name, each in limits.items():
        side = next(side for side in SIDES if side in each)
        bound: Value = each[side]
        measure, unit = known.get(name), ""
        if measure is not None:
            unit = measure.unit
            if not agrees(unit, bound.dimension):
                what = f"is in {unit}" if unit else "has no unit"
                place = reading.places[("subject_to", name, side)]
                reading.report(f"'{measure.quantity}' {what}", place, f"give '{side}' so")
        else:
            try:
                evaluate(parse(each["expression"], frozenset(names)), names)
            except (ExpressionError, Unavailable) as error:
                place = reading.places[("subject_to", name, "expression")]
                hint = getattr(error, "hint", None)
                reading.report(f"an expression of parameters: {error}", place, hint)
                continue
            dimension = _dimension(each["expression"], with_units)
            if dimension is not None and bound.dimension is not None and not dimension.agrees(bound.dimension):
                place = reading.places[("subject_to", name, side)]
                unit = unit_text(None, dimension)
                reading.report(f"'{each['expression']}' is in {unit}", place, f"give '{side}' so")
        yield DesignLimit(name, side, bound.number, unit, measure, each.get("expression", ""))


def _dimension(expression: str, names: Mapping[str, Value]) -> Dimension | None:
    """The dimension of an expression of parameters; None where a parameter has no unit, or units do not agree."""
    try:
        return evaluate(parse(expression, frozenset(names)), names).dimension
    except (ExpressionError, Unavailable):
        return None
