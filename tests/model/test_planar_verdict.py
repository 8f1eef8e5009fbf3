"""Which scenes are planar, why others are not, and verdicts by the topology alone."""

from __future__ import annotations

import dataclasses
import sys
from itertools import pairwise

import numpy as np
import pytest

from mbproj import Mechanism, Scene
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.row_space import scaled_jacobian
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import NotPlanar, planar_reduction
from mbproj.scene.records import Joint
from mbproj.scene.scene import SceneText, read_scene
from tests.model.planar_scenes import REFUSED, SCENES, Drawing, chain, planar, planar_jacobian, reduced, turns
from tests.support import MECHANISMS, assembled

#: What the shipped mechanisms are: the plane's normal, or the reason.
SHIPPED = {
    "bennett": "joint 'B' is tilted, seen in the plane normal to [0, 0, 1]",
    "bicycle": "nothing but symmetry keeps body 'front' in the plane normal to [0, 1, 0]",
    "bouncing_ball": "nothing but symmetry can keep the bodies in a plane: no joint has an axis",
    "bricard": "nothing but symmetry keeps body 'bar2' in the plane normal to [1, 0, 0]",
    "bump_stop": [1, 0, 0],
    "cam": [0, 1, 0],
    "chaplygin_sleigh": [0, 0, 1],
    "crane": "nothing but symmetry keeps body 'load' in the plane normal to [0, 1, 0]",
    "delta_robot": "joint 'A2' is tilted, seen in the plane normal to [0, 1, 0]",
    "differential": [0, 1, 0],
    "door_closer": [0, 0, 1],
    "door_with_stop": [0, 0, 1],
    "double_pendulum": [0, 1, 0],
    "drum_brake": [0, 0, 1],
    "five_bar": [0, 1, 0],
    "free_body": "nothing but symmetry can keep the bodies in a plane: no joint has an axis",
    "governor": "nothing but symmetry keeps body 'right' in the plane normal to [0, 1, 0]",
    "heavy_top": "nothing but symmetry can keep the bodies in a plane: no joint has an axis",
    "hoist": [0, 1, 0],
    "geneva": [0, 1, 0],
    "valve_train": [0, 1, 0],
    "hooke_shaft": "nothing but symmetry keeps body 'driven' in the plane normal to [0, 0, 1]",
    "inline_four": [1, 0, 0],
    "locomotive": [0, 1, 0],
    "massless_coupler": [0, 1, 0],
    "n_four_bar": [0, 1, 0],
    "newtons_cradle": [0, 1, 0],
    "physical_pendulum": [0, 1, 0],
    "planar_four_bar": [0, 1, 0],
    "quarter_car": "joint 'lower' is tilted, seen in the plane normal to [1, 0, 0]",
    "rocking_cabinet": [0, 1, 0],
    "rattleback": "joint 'rolls' rolls out of the plane, seen in the plane normal to [0, 0, 1]",
    "rolling_coin": "joint 'ground' rolls out of the plane, seen in the plane normal to [0, 0, 1]",
    "screw_press": "joint 'nut' couples coordinates that are not in the plane, seen in the plane normal to [0, 1, 0]",
    "spatial_four_bar": "nothing but symmetry keeps body 'crank' in the plane normal to [0, 1, 0]",
    "spatial_slider_crank": "nothing but symmetry keeps body 'slider' in the plane normal to [1, 0, 0]",
    "spherical_pendulum": "nothing but symmetry can keep the bodies in a plane: no joint has an axis",
    "split_coupler": [0, 1, 0],
    "steered_car": "joint 'front_left_rolls' rolls out of the plane, seen in the plane normal to [0, 1, 0]",
    "stewart_platform": "joint 'U1' is tilted, seen in the plane normal to [0.999, -0.0204, 0.041]",
    "stick_slip": [0, 1, 0],
    "swinging_atwood": [0, 1, 0],
    "turntable": "joint 'rolls' rolls out of the plane, seen in the plane normal to [0, 0, 1]",
}


@pytest.mark.parametrize("path", MECHANISMS, ids=lambda path: path.stem)
def test_shipped_mechanisms(path):
    system, state = assembled(read_scene(path))
    found = planar_reduction(system, state.q)
    expected = SHIPPED[path.stem]
    if isinstance(expected, str):
        assert isinstance(found, NotPlanar)
        assert found.reason == expected
    else:
        assert isinstance(found, Plane)
        assert found.axes[:, 2].tolist() == expected


def renamed(scene: Scene) -> Scene:
    """Other names, and the bodies and joints in the opposite order."""
    names = {body.name: f"part {number}" for number, body in enumerate(scene.bodies)} | {"ground": "ground"}
    joints = {joint.name: f"link {number}" for number, joint in enumerate(scene.joints)}

    def other(joint: Joint) -> Joint:
        couples = joint.couples and dataclasses.replace(
            joint.couples,
            of={
                f"{joints[own]}.angle": k
                for own, k in zip(joint.couples.joints, joint.couples.of.values(), strict=True)
            },
        )
        bodies = tuple(names[body] for body in joint.bodies)
        return dataclasses.replace(joint, name=joints[joint.name], bodies=bodies, couples=couples)

    bodies = [dataclasses.replace(body, name=names[body.name]) for body in reversed(scene.bodies)]
    return dataclasses.replace(scene, bodies=tuple(bodies), joints=tuple(map(other, reversed(scene.joints))))


def test_a_long_chain_is_planar():
    _, _, plane = planar(chain(Drawing(5), ["revolute"] * 2000))
    assert plane.joints.size == 4000


def test_a_long_chain_of_balls_is_not():
    _, _, found = reduced(chain(Drawing(5), ["revolute"] + ["spherical"] * 501))
    assert found.reason.startswith("nothing but symmetry keeps body 'body501' in the plane")


@pytest.mark.parametrize("name", SCENES)
def test_every_motion_that_the_joints_allow_is_in_the_plane(name):
    """The null space of C_q, from the full equations alone, and its dimension from the plane's."""
    system, q, plane = planar(SCENES[name](Drawing(1)))
    _, values, motions = np.linalg.svd(scaled_jacobian(system, pose_of(q)))
    free = motions[np.count_nonzero(values > 1e-9) :] * np.tile([system.length] * 3 + [1.0] * 4, system.bodies)
    p, u = plane.reduce(np.tile(q, (len(free), 1)), free)
    np.testing.assert_allclose(plane.expand(p, u, 0 * u)[1], free, rtol=0, atol=1e-12)
    assert len(free) == p.shape[1] - np.linalg.matrix_rank(planar_jacobian(plane, plane.reduce(q, q)[0]), tol=1e-9)


@pytest.mark.parametrize("name", SCENES)
def test_assembly_leaves_a_pose_that_is_planar(name):
    scene = SCENES[name](Drawing(2))
    system = compile_system(scene)
    guess = initial_guess(scene, system)
    moved = guess.q + 1e-3 * np.random.default_rng(2).normal(size=len(guess.q))
    state = assemble(system, dataclasses.replace(guess, q=moved))
    plane = planar_reduction(system, state.q)
    assert isinstance(plane, Plane), plane
    p, u = plane.reduce(state.q, state.v)
    at, v, _ = plane.expand(p, u, 0 * u)
    np.testing.assert_allclose(at, state.q, rtol=0, atol=1e-13)
    np.testing.assert_allclose(v, state.v, rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", SCENES)
def test_turning_and_renaming_the_scene_changes_nothing(name):
    scenes = [SCENES[name](Drawing(3, turn)) for turn in turns(3)]
    scenes.append(renamed(scenes[-1]))
    first, *others = [planar(scene)[2] for scene in scenes]
    for plane in others:
        assert sorted(plane.joints.kinds) == sorted(first.joints.kinds)
        assert len(plane.constant) == len(first.constant)
        np.testing.assert_allclose(np.sort(plane.inertia), np.sort(first.inertia), rtol=1e-12)


@pytest.mark.parametrize("name", REFUSED)
def test_scenes_that_only_look_planar_are_refused(name):
    build, reason = REFUSED[name]
    for turn in turns(4):
        scene = build(Drawing(4, turn))
        for variant in (scene, renamed(scene)):
            _, _, found = reduced(variant)
            assert isinstance(found, NotPlanar)
        _, _, found = reduced(scene)
        assert found.reason.startswith(reason), found.reason


@pytest.mark.parametrize(("second", "verdict"), [((1.0, 0.0), NotPlanar), ((0.6, 0.8), Plane)])
def test_bodies_that_hold_each_other_are_tested_together(second, verdict):
    """Each of two flaps can turn about a line in the plane, and two points of one slide on the other: on one common
    line they flap together, on two lines that cross they cannot."""
    drawing = Drawing(6)
    bodies = [drawing.body("one", (0.0, 1.0)), drawing.body("two", (0.3, 1.4))]
    joints = [
        drawing.joint("A", "universal", ("ground", "one"), (0.0, 0.0), axes=((0, 0, 1), (1, 0, 0))),
        drawing.joint("B", "universal", ("ground", "two"), (1.0, 0.0), axes=((0, 0, 1), (*second, 0))),
        drawing.joint("C", "point_in_plane", ("one", "two"), (0.2, 1.0)),
        drawing.joint("D", "point_in_plane", ("one", "two"), (0.1, 2.0)),
    ]
    assert isinstance(reduced(drawing.scene(bodies, joints))[2], verdict)


@pytest.mark.parametrize(("widest", "verdict"), [(0.0, NotPlanar), (np.pi, Plane)])
def test_a_large_piece_that_hangs_together_is_tested_as_one(widest, verdict):
    """A row of flaps, each hinged to the ground and resting on the next at two points: hinged on one common line they
    flap together, on lines that cross no two of them can."""
    drawing, count = Drawing(8), THRESHOLDS.large + 1
    angle = widest * np.arange(count) * (np.sqrt(5.0) - 1.0) / 2.0
    names = [f"flap{number}" for number in range(count)]
    joints = [
        drawing.joint(f"H{at}", "universal", ("ground", name), (at, 0.0), axes=((0, 0, 1), (c, s, 0)))
        for at, (name, c, s) in enumerate(zip(names, np.cos(angle), np.sin(angle), strict=True))
    ]
    joints += [
        drawing.joint(f"P{at}_{height}", "point_in_plane", names_of, (at + 0.3 * height, height))
        for at, names_of in enumerate(pairwise(names))
        for height in (1.0, 2.0)
    ]
    scene = drawing.scene([drawing.body(name, (float(at), 1.0)) for at, name in enumerate(names)], joints)
    assert isinstance(reduced(scene)[2], verdict)


# Verdicts on planes that the topology alone gives: they are those of the whole analysis, to the bit.

REDUCTION = sys.modules["mbproj.model.planar.reduction"]
FOUR_BAR = SceneText(
    next(path for path in MECHANISMS if path.stem == "n_four_bar").read_text(encoding="utf-8"), "scene"
)


def numbers(part) -> list:
    """All that a plane holds, arrays as their bytes."""
    if isinstance(part, np.ndarray):
        return [part.dtype.str, part.shape, part.tobytes()]
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        return [numbers(getattr(part, field.name)) for field in dataclasses.fields(part)]
    return [part]


@pytest.fixture
def calls(monkeypatch):
    """Lists that the results of `certain_plane` and those of `escape`, the test of the rank, are added to."""
    found = {"certain": [], "escape": []}
    for name, own in (("certain", "certain_plane"), ("escape", "escape")):
        whole = getattr(REDUCTION, own)

        def kept(*given, whole=whole, name=name):
            found[name].append(whole(*given))
            return found[name][-1]

        monkeypatch.setattr(REDUCTION, own, kept)
    return found


def both(system, q, monkeypatch):
    """The verdict, and that of the whole analysis."""
    short = planar_reduction(system, q)
    with monkeypatch.context() as patched:
        patched.setattr(REDUCTION, "certain_plane", lambda *_: None)
        return short, planar_reduction(system, q)


@pytest.mark.parametrize("name", [*SCENES, *REFUSED])
def test_it_is_the_verdict_of_the_whole_analysis(name, monkeypatch):
    build = SCENES[name] if name in SCENES else REFUSED[name][0]
    for turn in turns(9)[:2]:
        system, q, _ = reduced(build(Drawing(9, turn)))
        short, whole = both(system, q, monkeypatch)
        assert type(short) is type(whole)
        assert numbers(short) == numbers(whole)


def test_other_lengths_are_not_analysed_again(calls, monkeypatch):
    for length in (1.0, 1.1, 0.7, 1.0000001):
        mechanism = Mechanism.of(FOUR_BAR.scene({"length": length}))
        short, whole = both(mechanism.system, mechanism.state.q, monkeypatch)
        assert isinstance(short, Plane)
        assert numbers(short) == numbers(whole)
    assert [found.is_held for found in calls["certain"]] == [True] * 4
    assert len(calls["escape"]) == 4  # of the whole analysis alone


SCENE = """\
mbproj: 1
gravity: [0, 0, 0]
parameters: {lean: 0, beside: 1 m}
bodies:
  rod: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
  tip: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}
"""


def verdicts(joints: str, name: str, values: list[float]) -> list[type]:
    """Those of the scene with further joints and these values of a parameter."""
    text = SceneText(SCENE + joints + "simulation: {duration: 1 s}\n", "scene")
    found = [Mechanism.of(text.scene({name: value})) for value in values]
    return [type(planar_reduction(each.system, each.state.q)) for each in found]


def test_an_axis_that_leans_is_analysed_again(calls):
    hinge = "  B: {type: revolute, bodies: [rod, tip], location: [1, 0, 0], axis: [0, 1, lean]}\n"
    assert verdicts(hinge, "lean", [0.0, 0.1, 0.0]) == [Plane, NotPlanar, Plane]
    assert [found is not None and found.is_held for found in calls["certain"]] == [True, False, True]


def test_a_rank_that_depends_on_lengths_is_looked_at_each_time(calls):
    """The tip hangs on a ball, and two of its points stay in the plane: unless these are in line with the ball."""
    joints = """\
  B: {type: spherical, bodies: [rod, tip], location: [1, 0, 0]}
  C: {type: point_in_plane, bodies: [ground, tip], location: [1, 0, 1], axis: [0, 1, 0]}
  D: {type: point_in_plane, bodies: [ground, tip], location: [1 + beside, 0, 1], axis: [0, 1, 0]}
"""
    assert verdicts(joints, "beside", [1.0, 0.0, 2.0]) == [Plane, NotPlanar, Plane]
    assert [found.is_held for found in calls["certain"]] == [False] * 3
    assert len(calls["escape"]) >= 3
