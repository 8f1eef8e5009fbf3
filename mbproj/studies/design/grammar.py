"""The words of a file that describes a design: its keys, and what may stand there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbproj.scene.blocks.expectations import EXPECTATION, MEASURE, SUBJECTS, Given, Measure
from mbproj.scene.blocks.measures import MEASURE as RECORD_OF_MEASURE
from mbproj.scene.fields.choices import NameChoice
from mbproj.scene.fields.containers import Named, OneOf, Record
from mbproj.scene.fields.fields import Field, Text
from mbproj.scene.fields.quantities import Integer, Number
from mbproj.scene.fields.reading import Reading
from mbproj.scene.ranges import BOUNDS, Uniform
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, as_mapping

FORMAT = "1"


class Bounded(Field[Mapping[str, Uniform]]):
    """Bounds by the paths of what they are of."""

    node_type = MappingNode

    @property
    def expects(self) -> str:
        return "a mapping {path of a number of the scene: [low, high]}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Mapping[str, Uniform] | None:
        mapping = as_mapping(node)
        if mapping is None:
            self.reject(node, path, reading)
            return None
        if not mapping.values:
            reading.report(
                "'vary' is empty", mapping.place, "say what varies, as in  parameters.length: [0.8 m, 1.2 m]"
            )
            return None
        for name in mapping.values:
            where = (*path, name)
            reading.places[where] = mapping.keys[name]
        found = {name: BOUNDS.read(value, (*path, name), reading) for name, value in mapping.values.items()}
        whole = {name: each for name, each in found.items() if each is not None}
        return whole if len(whole) == len(found) else None

    def schema(self) -> dict[str, Any]:
        return {"description": self.expects, "type": "object", "additionalProperties": BOUNDS.schema()}


class Headings(Field[Mapping[str, str]]):
    """Headings of a table by what they are of, as in {time: "t", position_x: "X"}."""

    node_type = MappingNode

    @property
    def expects(self) -> str:
        return "a mapping {what: heading of the column}"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Mapping[str, str] | None:
        mapping = as_mapping(node)
        if mapping is None or not all(isinstance(each, ScalarNode) for each in mapping.values.values()):
            self.reject(node, path, reading)
            return None
        for name in mapping.values:
            where = (*path, name)
            reading.places[where] = mapping.keys[name]
        return {name: each.text for name, each in mapping.values.items() if isinstance(each, ScalarNode)}

    def schema(self) -> dict[str, Any]:
        return {"description": self.expects, "type": "object", "additionalProperties": Text().schema()}


_OF = {key: EXPECTATION.keys[key] for key in SUBJECTS}
MATCH: Record[Given] = Record(
    "a match",
    {
        **_OF,
        "quantity": EXPECTATION.keys["quantity"],
        "through": Text(),
        "over": Text(),
        "columns": Headings(),
        "weight": Number(above=0.0),
        "deviation": Measure(above=0.0),
    },
    dict,
    required=("through",),
    choices=(OneOf(tuple(SUBJECTS), needed=True, hint="a match is of one thing; write another for the other"),),
)
SIDES = ("at_least", "at_most", "equals")
LIMIT: Record[Given] = Record(
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
        "vary": Bounded(),
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
