"""Whatever is written as dry friction: it compiles to numbers that make sense, or the reader says where it is wrong."""

from __future__ import annotations

import numpy as np
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from mbproj import InputError, compile_system, read_scene_text
from mbproj.scene.blocks.friction import KEYS
from mbproj.scene.schema import scene_schema

VALIDATOR = Draft202012Validator(scene_schema())
TYPES = {"A": "revolute", "D": "prismatic", "C": "cylindrical", "S": "screw, pitch: 1", "P": "planar"}
PLACE = "location: [0, 0, 0], axis: [0, 0, 1]"
BODIES = [f"  {name}-body: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}\n" for name in TYPES]
JOINTS = [f"  {name}: {{type: {kind}, bodies: [ground, {name}-body], {PLACE}}}\n" for name, kind in TYPES.items()]
HEAD = f"mbproj: 1\ngravity: [0, 0, 0]\nbodies:\n{''.join(BODIES)}joints:\n{''.join(JOINTS)}forces:\n"
LINE = HEAD.count("\n") + 1
USUAL = ["0.1", "2", "3"]
ODD = ["0", "-1", "3 N", "3 N*m", "1 rad/s", "1 m/s", "2 mm", "1e99", "[1]", "{}", "x", ""]
#: What is right, and what may come to it or stand instead.
PLAIN = [{"torque": "2"}, {"force": "2"}, {"coefficient": "2"}, {"coefficient": "2", "radius": "1"}, {}]
MORE = st.one_of(
    st.just({}),
    st.dictionaries(st.sampled_from(["static", "stribeck_speed", "preload", "axial_radius"]), st.sampled_from(USUAL)),
    st.dictionaries(st.sampled_from([*KEYS, "radios"]), st.sampled_from(USUAL + ODD), max_size=2),
)


def flow(items):
    return "{" + ", ".join(f"{key}: {value}" for key, value in items.items()) + "}"


DRY = st.tuples(st.sampled_from(PLAIN), MORE).map(lambda both: flow(both[0] | both[1]))
BY_NAME = st.dictionaries(st.sampled_from(["angle", "displacement", "displacement_x"]), DRY, min_size=1).map(flow)


@settings(derandomize=True, deadline=None, max_examples=150)
@given(st.sampled_from("ADCSP"), DRY | BY_NAME, st.sampled_from(["", ", coefficient: 3"]))
@example("A", "{torque: 3, static: 4}", "")
@example("S", "{angle: {coefficient: 0.1, radius: 2}, displacement: {force: 3}}", "")
@example("D", "{coefficient: 0.1, bearing_length: 2, preload: 3, regularised: 2}", ", coefficient: 3")
def test_it_compiles_or_has_its_place(joint, dry, viscous):
    text = f"{HEAD}  k: {{type: friction, joint: {joint}, coulomb: {dry}{viscous}}}\n"
    try:
        scene = read_scene_text(text, "f.yaml")
    except InputError as error:
        assert all(problem.place is not None and problem.place.line == LINE for problem in error.problems)
        return
    assert VALIDATOR.is_valid(yaml.load(text, Loader=yaml.BaseLoader))
    system = compile_system(scene)
    (force,) = scene.forces
    assert set(system.names.frictions) | set(system.names.forces) == (
        {"k"} if len(force.coordinates) == 1 else {f"k.{name}" for name in force.coordinates}
    )
    if system.frictions is not None:
        found = system.frictions
        assert ((found.static >= found.sliding) & (found.sliding >= 0.0) & (found.stribeck >= 0.0)).all()
        assert ((found.stribeck == 0.0) | (found.static > found.sliding)).all()
    if system.bearings is not None:
        loads = system.bearings
        assert (np.maximum(loads.radial, loads.axial) > 0.0).all() and (loads.preload >= 0.0).all()
        assert (np.isinf(loads.length) | (loads.radial > 0.0)).all()
        np.testing.assert_array_equal(loads.axis, np.tile([0.0, 0.0, 1.0], (loads.size, 1)))


def test_a_coordinate_that_is_driven_may_have_friction():
    """The drive pays for it. Two brakes may be on one shaft."""
    force = "{type: friction, joint: A, coulomb: {torque: 3}}"
    scene = read_scene_text(f"{HEAD}  k: {force}\n  l: {force}\nmotions:\n  m: {{joint: A, angle: 2 * t}}\n")
    assert compile_system(scene).frictions.joint_coordinate.tolist() == [0, 0]
