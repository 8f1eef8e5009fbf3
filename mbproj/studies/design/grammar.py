"""The words of a file that describes a design: its keys, and what may stand there."""

from __future__ import annotations

from typing import Any

from mbproj.scene.blocks.expectations import EXPECTATION, MEASURE, SUBJECTS, Given, Measure
from mbproj.scene.blocks.measures import MEASURE as RECORD_OF_MEASURE
from mbproj.scene.fields.choices import NameChoice
from mbproj.scene.fields.containers import ByPath, Named, OneOf, Record
from mbproj.scene.fields.fields import Text
from mbproj.scene.fields.quantities import Integer, Number
from mbproj.scene.ranges import BOUNDS

FORMAT = "1"
_OF = {key: EXPECTATION.keys[key] for key in SUBJECTS}
MATCH: Record[Given] = Record(
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
