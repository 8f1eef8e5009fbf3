"""The JSON Schema of the format: never narrower than the reader, and as strict as a schema can be."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from mbproj.base.errors import InputError
from mbproj.base.registry import PROJECTIONS
from mbproj.joints.table import JOINTS
from mbproj.scene.blocks.solids import SHAPES
from mbproj.scene.fields.fields import OneOf
from mbproj.scene.scene import read_scene_text
from mbproj.scene.schema import scene_schema
from tests.cli.commands import mbproj
from tests.crossed import campaign, crossed
from tests.scene.scenes import BLIND, GOOD, IDS, ROWS, changed, read
from tests.stops.scenes import SCENE as STOPS
from tests.support import MECHANISMS

SCHEMA = scene_schema()
VALIDATOR = Draft202012Validator(SCHEMA)
LOADER = getattr(yaml, "CBaseLoader", yaml.BaseLoader)


def as_text(scene: str) -> Any:
    """The scene as the reader sees it: mappings, lists and texts."""
    return yaml.load(scene, Loader=LOADER)


def typed(value: Any) -> Any:
    """The value with its texts as YAML 1.2's JSON schema, which editors use, takes them: numbers, true, false, null."""
    if isinstance(value, dict):
        return {key: typed(item) for key, item in value.items()}
    if isinstance(value, list):
        return [typed(item) for item in value]
    try:
        found = json.loads(value or "null", parse_constant=str)
    except ValueError:
        return value
    return value if isinstance(found, (str, list, dict)) else found


def as_typed(scene: str) -> Any:
    return typed(as_text(scene))


def as_python(scene: str) -> Any:
    """The scene as PyYAML's usual loader gives it (YAML 1.1), in which 1e-6 is a text."""
    return yaml.load(scene, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))


def assert_valid(data: Any) -> None:
    assert [f"{error.json_path}: {error.message}" for error in VALIDATOR.iter_errors(data)] == []


def test_the_schema_is_one() -> None:
    Draft202012Validator.check_schema(SCHEMA)
    assert json.loads(json.dumps(SCHEMA)) == SCHEMA


@crossed("path, load", MECHANISMS, [as_text, as_typed, as_python], together=1)
def test_the_shipped_mechanisms_are_valid(path: Path, load: Any) -> None:
    assert_valid(load(path.read_text(encoding="utf-8")))


@pytest.mark.parametrize("load", [as_text, as_typed, as_python])
def test_open_sides_of_ranges_are_valid_as_text_and_as_null(load: Any) -> None:
    assert "[null, 0.5]" in STOPS
    assert_valid(load(STOPS))


@pytest.mark.parametrize("identity", IDS)
def test_wrong_scenes_are_invalid_but_for_those_marked_as_beyond_a_schema(identity: str) -> None:
    """Those that are no YAML at all, and so never come before a schema, count as invalid."""
    old, new, _ = ROWS[IDS.index(identity)]
    try:
        data = as_typed(changed(old, new))
    except yaml.YAMLError:
        assert identity not in BLIND
    else:
        assert VALIDATOR.is_valid(data) == (identity in BLIND)


M, P = "markers:", "points: {ground: [0, 0, 0], rod: [0, 0, 1]}"
ROD = "mass: 0.5, inertia: [4e-3, 4e-4, 4e-3], position: [0.1, 0.05, 0.1]"
B = '{type: spherical, bodies: [crank, rod], location: [0, 0.1, "0.12 + crank_length"]}'
#: What is legal, though it may not look so.
ODD = [
    ("title: Sp", "title: 2015 #"),
    ("title: Sp", "title: true #"),
    ("title: Sp", "title: #"),
    ("mbproj: 1 ", "mbproj: '1' "),
    ("mbproj: 1 ", 'mbproj: "1" '),
    ("gravity: [0, 0, -9.8]", "gravity: ['0', 0, .5]"),
    ("gravity: [0, 0, -9.8]", "gravity: [1e-6, 1E+3, -5.]"),
    ("gravity: [0, 0, -9.8]", "gravity: [010, +5, -(5)]"),
    ("gravity: [0, 0, -9.8]", "gravity: [2015-01-01, 2, 0]"),
    ("{crank_length: 0.08, rod_length: 0.3}", "{crank_length: rod_length / 2, rod_length: 0.3 m, on: 1, null: 3}"),
    ("duration: 10", "duration: 10 s"),
    ("duration: 10", ""),
    ("projection: gpopm", "projection: {method: none}"),
    ("projection: gpopm", "projection: none"),
    ("projection: gpopm", "projection: {position: false, velocity: 'true', every: 2.0, max_iterations: 3 * 5}"),
    ("projection: gpopm", "projection: {method: baumgarte, gains: 5}"),
    ("projection: gpopm", "projection: {method: baumgarte, gains: [5 / (1 s), 1e1]}"),
    ("projection: gpopm", "projection: {method: baumgarte, gains: [25 1/s, 25 s^-1]}"),
    ("mass: 0.12", "mass: 0"),
    ("mass: 0.12", "mass: |\n      1 +\n      2"),
    ("mass: 0.12", "mass: '0.12 kg'"),
    ("inertia: [1.0e-4, 1.0e-5, 1.0e-4]", "inertia: [2, 2, 2, 0.1, 0.2, 0.3 kg*m^2]"),
    ("inertia: [1.0e-4, 1.0e-5, 1.0e-4]", "inertia: [[2, 0, 0], [0, 2, 0], [0, 0, 2]]"),
    ("{axis: [1, 0, 0], angle: 90 deg}", "{quaternion: [2, 2, 0, 0]}"),
    ("{axis: [1, 0, 0], angle: 90 deg}", "{matrix: [[1, 0, 0], [0, 0, -1], [0, 1, 0]]}"),
    ("{axis: [1, 0, 0], angle: 90 deg}", "{euler: [90 deg, 0, 0], sequence: xyz}"),
    ("  tip: {", "  'true': {"),
    ("  tip: {", "  null: {"),
    ("  tip: {", "  _a-1: {"),
    ("markers:\n  tip: {body: slider, location: [0.2, 0, 0]}\n", "markers:\n"),
    ("{body: slider, location: [0.2, 0, 0]}", "{body: slider, location: {slider: [1, 2, 3]}}"),
    (ROD, "density: 7.85 g/cm^3, shape: {box: [1, 2, 3 mm]}, position: [0, 0, 0]"),
    (ROD, "mass: 1, shape: {cylinder: {radius: 1, length: 2, axis: y}}, position: [0, 0, 0]"),
    (ROD, "mass: 1, shape: {tube: {outer_radius: 2, inner_radius: 1, length: 2}}, position: [0, 0, 0]"),
    (ROD, "mass: 1, shape: {point}, position: [0, 0, 0]"),
    (ROD, "mass: 0, shape: {point: {}}, position: [0, 0, 0]"),
    (ROD, "shapes: [{sphere: 1, mass: 1}, {rod: {length: 1}, mass: 2, position: [0, 0, 1]}], origin: [0, 0, 0]"),
    (B, "{type: fixed, bodies: [crank, rod], location: [0, 0, 0], reaction: true}"),
    (B, "{type: distance, bodies: [crank, rod], locations: [[0, 0, 0], [0, 0, 1]], length: 1}"),
    (B, "{type: distance, bodies: [crank, rod], locations: {rod: [0, 0, 0], crank: [0, 0, 1]}}"),
    (B, "{type: cylindrical, bodies: [crank, ground], location: [0, 0, 0], axis: [0, 0, 1], speed: {angle: 2}}"),
    (B, "{type: cylindrical, bodies: [crank, ground], location: [0, 0, 0], axis: [0, 0, 1], displacement: 1}"),
    (B, "{type: cylindrical, bodies: [crank, ground], location: [0, 0, 0], axis: [0, 0, 1], speed: }"),
    *(
        (M, f"forces:\n  k: {force}\n{M}")
        for force in (
            f"{{type: spring_damper, {P}, stiffness: 1 N/mm}}",
            f"{{type: spring_damper, {P}, force: -3*l + t}}",
            f"{{type: spring_damper, {P}, damping: 2, table: [[0, 1], [1 mm, 2 N]]}}",
            f"{{type: spring_damper, {P}, table: {{rows: [[0, 1], [1, '2']], between: linear}}}}",
            "{type: spring_damper, bodies: [rod, ground], locations: {rod: [0, 0, 0], ground: [1, 0, 0]}, damping: 1}",
            "{type: torsion_spring_damper, joint: C, coordinate: angle_2, torque: 3}",
            "{type: linear_spring_damper, joint: D, stiffness: 0, free_displacement: -1}",
            "{type: friction, joint: C, coefficient: {angle_1: 1, angle_2: 2 N*m*s/rad}}",
            "{type: friction, joint: A, coulomb: {torque: 0, static: '3 * 2', stribeck_speed: 1 rpm}, coefficient: 0}",
            "{type: friction, joint: D, coulomb: {displacement: {coefficient: 1 / 7, regularised: 1 mm/s}}}",
            "{type: friction, joint: A, coulomb: {coefficient: 0.1, radius: 1, bearing_length: 1 cm, preload: 2 kN}}",
            "{type: force, body: rod, force: [0, t, 1 kN], location: {rod: [0, 0, 0]}, axes: body}",
            "{type: torque, body: rod, torque: [0, t, 1 N*m]}",
        )
    ),
    *(
        (M, f"motions:\n  m: {{joint: A, angle: {function}}}\n{M}")
        for function in (
            "6*t",
            "'3'",
            "2",
            "{constant_speed: 3 rpm}",
            "{harmonic: {amplitude: 1, frequency: 2 Hz}}",
            "{polynomial: [1, 2, 3]}",
            "{smooth_step: {to: 1, duration: 2 s}}",
            "{table: [[0, 1], [1, 2]]}",
            "{table: {rows: [[0, 1], [1, 2]], between: clamped}}",
            "{expression: sin(t)}",
            "|\n      t +\n      1",
        )
        if not function.startswith("|")
    ),
    (M, f"forces:\n{M}"),
    (M, f"motions: {{}}\n{M}"),
    *(
        (M, f"expect:\n  e: {expectation}\n{M}")
        for expectation in (
            "{marker: tip, quantity: position, at: 3 s, value: [1 mm, '2', 3], absolute: 1e-6, source: x}",
            "{marker: tip, quantity: position, component: norm, at: end, value: 1, relative: 1e-6, source: 2015}",
            "{diagnostic: kinetic_energy, at: maximum, below: 3 J, source: x}",
            "{joint: C, quantity: angle_2_speed, at: 0, above: -3 rpm, source: x}",
        )
    ),
    (M, f"expect:\n{M}"),
    (M, f"expect: {{}}\n{M}"),
    (B, "{type: screw, bodies: [crank, rod], location: [0, 0, 0], axis: [0, 0, 1], pitch: -1 mm}"),
]


@pytest.mark.parametrize("load", [as_text, as_typed])
@pytest.mark.parametrize(("old", "new"), ODD, ids=range(len(ODD)))
def test_odd_but_legal_scenes_are_valid(old: str, new: str, load: Any) -> None:
    text = changed(old, new)
    read(text)
    assert_valid(load(text))


@campaign(
    st.integers(0, len(GOOD)),
    st.integers(0, 12),
    st.text("0123456789.eE+-*/() _abmsxyz[],{}:'\"\n", max_size=6),
    few=60,
    many=500,
)
def test_what_the_reader_accepts_is_valid(at: int, length: int, piece: str) -> None:
    text = GOOD[:at] + piece + GOOD[at + length :]
    try:
        read_scene_text(text)
    except InputError:
        return
    data = as_text(text)
    assert_valid(data)
    assert_valid(typed(data))


def test_descriptions_and_choices_are_those_of_the_reader() -> None:
    body = SCHEMA["properties"]["bodies"]["patternProperties"]["^(?:[A-Za-z_][A-Za-z0-9_-]*)$"]
    assert body["properties"]["mass"] == {
        "description": "a number in kg",
        "type": ["number", "string"],
        "pattern": r"\S",
        "minimum": 0.0,
    }
    assert body["properties"]["shape"]["properties"].keys() == SHAPES.keys()
    joint = next(iter(SCHEMA["properties"]["joints"]["patternProperties"].values()))
    assert joint["properties"]["type"]["enum"] == [*JOINTS]
    assert [choice["then"]["description"] for choice in joint["allOf"]] == [f"a {name} joint" for name in JOINTS]
    projection = SCHEMA["properties"]["simulation"]["properties"]["projection"]
    assert projection["anyOf"][0]["enum"] == [*PROJECTIONS]


def test_the_command_prints_or_writes_it(tmp_path: Path) -> None:
    printed = mbproj("schema", folder=tmp_path)
    assert json.loads(printed.stdout) == SCHEMA
    written = mbproj("schema", "-o", "a/scene.json", folder=tmp_path)
    assert (written.stdout, written.stderr, written.returncode) == ("a/scene.json\n", "", 0)
    assert (tmp_path / "a" / "scene.json").read_text(encoding="utf-8") == printed.stdout
    wrong = mbproj("schema", "-o", "a", folder=tmp_path)
    assert (wrong.stdout, wrong.returncode) == ("", 2)
    assert wrong.stderr == "error: 'a' is a directory; give a file in it, or choose another with -o\n"


def test_at_most_one_key_of_a_group_or_exactly_one_where_it_is_needed() -> None:
    for needed, allowed in ((False, [0, 1]), (True, [1])):
        validator = Draft202012Validator(OneOf(("a", "b", "c"), needed).schema())
        given = [dict.fromkeys(keys) for count in range(4) for keys in combinations("abc", count)]
        assert [keys for keys in given if validator.is_valid(keys)] == [keys for keys in given if len(keys) in allowed]
