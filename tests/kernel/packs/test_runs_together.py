"""Runs side by side in packs, four or eight at once: each has the bits of the same run by itself."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mbproj import Scene
from mbproj.integrate import choose
from mbproj.kernel import core, pack_width
from mbproj.scene import ProjectionSettings, Settings, read_scene, read_scene_text
from tests.kernel.scenes import assembled, loops, star, tree
from tests.support import MECHANISMS, random_chain

pytestmark = pytest.mark.skipif(pack_width() == 0, reason="packs need the kernel, and a processor with AVX2")
MOST, FOREVER = 2**31, 1e9
DOP853 = {"integrator": "dop853", "tolerance": 1e-8, "output_step": 0.013}
RK4 = {"integrator": "rk4", "step": 0.005, "output_step": 0.02}
PEAKS = ("position_peak", "joint_peak", "velocity_peak")


def run_of(scene: Scene, projection: str = "gpopm", **keys: Any) -> Any:
    """A run of the kernel that has not begun."""
    system, state = assembled(scene)
    settings = Settings(projection=ProjectionSettings(method=projection), **keys)
    compiled = choose(system, state, settings).compiled
    assert compiled is not None
    return compiled.run(state, settings)


def side_by_side(runs: Sequence[Any]) -> Any:
    return core().together(list(runs), FOREVER, lambda: None)


def alike(scene: Scene, count: int, seed: int = 0) -> list[Scene]:
    """Scenes that differ in masses, in moments of inertia, in speeds and in gravity."""
    rng = np.random.default_rng(seed)

    def body(given: Any) -> Any:
        heavier, faster = rng.uniform(0.8, 1.25, size=2)
        inertia = np.asarray(given.inertia, dtype=float) * heavier
        return replace(
            given,
            mass=given.mass * heavier,
            inertia=tuple(map(tuple, inertia)) if inertia.ndim == 2 else tuple(inertia),
            angular_velocity=tuple(faster * np.asarray(given.angular_velocity, dtype=float)),
        )

    return [
        replace(
            scene,
            bodies=tuple(body(each) for each in scene.bodies),
            gravity=tuple(rng.uniform(0.9, 1.1) * np.asarray(scene.gravity, dtype=float)),
        )
        for _ in range(count)
    ]


def assert_alike(runs: Sequence[Any], others: Sequence[Any]) -> Counter[str]:
    """That runs side by side, which go on by themselves where packs leave them, are those of the others, each by
    itself; how many packs have made to the end, and in part."""
    together, made = side_by_side(runs), Counter[str]()
    running, finished = core().Status.running, core().Status.finished
    for run, samples, other in zip(runs, together, others, strict=True):
        parts = [] if samples is None else [samples]
        made["to the end" if run.outcome.status == finished else "in part" if parts else "not"] += 1
        if run.outcome.status == running:
            parts.append(run.advance(MOST, FOREVER))
        alone = other.advance(MOST, FOREVER)
        assert run.outcome.status == other.outcome.status != running
        for name, expected in alone.items():
            found = np.concatenate([part[name] for part in parts])
            np.testing.assert_array_equal(found, expected, name)
        np.testing.assert_array_equal(run.counters, other.counters)
        np.testing.assert_array_equal(run.standing["y"], other.standing["y"])
        assert run.standing["t"] == other.standing["t"] and run.standing["turns"] == other.standing["turns"]
        for peak in PEAKS:
            one, two = getattr(run, peak), getattr(other, peak)
            assert (one.value, one.row, one.time) == (two.value, two.row, two.time)
    return made


def made_alike(scenes: Sequence[Scene], **keys: Any) -> Counter[str]:
    return assert_alike(*([run_of(scene, **keys) for scene in scenes] for _ in range(2)))


@pytest.mark.parametrize("projection", ["gpopm", "gopm"])
@pytest.mark.parametrize("keys", [DOP853, RK4], ids=["dop853", "rk4"])
@pytest.mark.parametrize("name", ["five_bar", "planar_four_bar", "spatial_slider_crank", "double_pendulum"])
def test_shipped_mechanisms_have_the_bits_of_runs_by_themselves(name, keys, projection):
    scene = read_scene(next(path for path in MECHANISMS if path.stem == name))
    made = made_alike(alike(scene, 9), projection=projection, duration=0.5, **keys)
    assert made["to the end"] >= 7  # two slider-cranks look for rows near dependent on their way with fixed steps


#: Why packs do not make a shipped mechanism.
NOT_PACKED = {
    "bicycle": "it rolls",
    "bricard": "other rows than the usual ones serve where it begins",
    "chaplygin_sleigh": "it rolls",
    "rattleback": "it rolls",
    "rolling_coin": "it rolls",
    "bouncing_ball": "contacts",
    "bump_stop": "contacts",
    "door_closer": "contacts",
    "door_with_stop": "contacts",
    "drum_brake": "contacts",
    "newtons_cradle": "contacts",
    "rocking_cabinet": "contacts",
    "screw_press": "contacts",
    "steered_car": "it rolls",
    "stick_slip": "contacts",
    "valve_train": "contacts",
    "cam": "curves",
    "geneva": "curves",
    "hoist": "a rope",
    "massless_coupler": "light bodies",
    "swinging_atwood": "a rope",
    "turntable": "it rolls",
}


@pytest.mark.parametrize("keys", [DOP853, RK4], ids=["dop853", "rk4"])
@pytest.mark.parametrize("path", MECHANISMS, ids=lambda path: path.stem)
def test_packs_make_each_shipped_mechanism_but_these(path, keys):
    """Those that pass singular poses, choose among redundant rows or come to rest go on by themselves from there."""
    scene = read_scene(path)
    runs, others = (
        [run_of(each, **keys, duration=min(0.05, scene.settings.duration)) for each in alike(scene, 5)]
        for _ in range(2)
    )
    if path.stem in NOT_PACKED:
        assert side_by_side(runs) == [None] * len(runs)
    else:
        assert assert_alike(runs, others)["not"] == 0


#: Springs, dampers, bushings, drives with states, functions of what moves, and functions of time with kinks.
FORCED = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {k: 40, pull: 3, slow: 0.7, gain: 2}
bodies:
  crank: {mass: 1, inertia: [0.05, 0.04, 0.05], position: [0.3, 0, 0]}
  bob: {mass: 2, inertia: [0.1, 0.2, 0.15], position: [0.9, 0, 0.1]}
  load: {mass: 1.5, inertia: [0.1, 0.1, 0.1], position: [1.5, 0, 0.1]}
joints:
  pin: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0], speed: 9}
  ball: {type: BALL, bodies: [crank, bob], location: [0.6, 0, 0]AXIS}
signals:
  lag: slow - pin.angle
states:
  integral: {derivative: lag - 0.1*integral}
forces:
  twist: {type: torsion_spring_damper, joint: pin, stiffness: k, damping: 0.3}
  drive: {type: torsion_spring_damper, joint: pin, torque: gain*integral - 0.2*tanh(angle_dot)}
  cord: {type: spring_damper, points: {ground: [0, 0.2, 1], bob: [0.9, 0, 0.2]}, stiffness: 3*k, damping: 2}
  odd:
    type: spring_damper
    points: {ground: [1, 0.1, -1], bob: [1, 0, 0.1]}
    force: >-
      pull*(sin(l) + cos(2*l_dot) + tan(0.1*l) + asin(0.1*l) + acos(0.1*l) + atan(l) + sinh(0.1*l) + cosh(0.1*l)
      + exp(-l) + log(l) + log10(l) + sqrt(l) + l**1.5 + l**(1 + 0.1*l) + atan2(l, 1 + l) + hypot(l, l_dot)
      - l_dot**3/(1 + l**2)) - l_dot
  wind: {type: force, body: bob, location: [1, 0, 0], force: [pull*abs(sin(20*t)), 0, "max(0, pull*sin(17*t))"]}
  hum: {type: torque, body: crank, axes: body, torque: [0, pull*sign(cos(15*t)), 0]}
  mount:
    type: bushing
    bodies: [bob, load]
    location: [1.2, 0, 0.1]
    stiffness: {translation: [50*k, 40*k, 50*k], rotation: [2*k, k, 2*k]}
    damping: {translation: [5, 5, 5], rotation: [0.2, 0.2, 0.2]}
  creep: {type: maxwell, points: {ground: [0, 0, 1], load: [1.5, 0, 0.1]}, stiffness: k, damping: 4}
"""


@pytest.mark.parametrize("keys", [DOP853, RK4], ids=["dop853", "rk4"])
@pytest.mark.parametrize(("ball", "axis"), [("spherical", ""), ("revolute", ", axis: [0, 1, 0]")])
def test_forces_states_and_breaks_have_the_bits_of_runs_by_themselves(ball, axis, keys):
    """In space and in a plane: what functions give varies, and the times of kinks are those of each lane."""
    text = FORCED.replace("BALL", ball).replace("AXIS", axis)
    cases = np.random.default_rng(5).uniform(0.5, 2, (7, 4)) * [40, 3, 0.7, 2]
    names = ("k", "pull", "slow", "gain")
    scenes = [read_scene_text(text, "forced", dict(zip(names, case, strict=True))) for case in cases.tolist()]
    pairs = [[run_of(scene, **keys, duration=0.6) for scene in scenes] for _ in range(2)]
    assert assert_alike(*pairs) == {"to the end": 7}


DRIVEN = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {turn: 9, far: 1}
bodies:
  crank: {mass: 1, inertia: [0.05, 0.04, 0.05], position: [0.1, 0, 0]}
  rod: {mass: 2, inertia: [0.1, 0.2, 0.15], position: [0.6, 0, 0]}
  slider: {mass: 1.5, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0]}
  wheel: {mass: 1, inertia: [0.05, 0.04, 0.05], position: [0, 0, 1]}
joints:
  pin: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  knee: {type: revolute, bodies: [crank, rod], location: [0.2, 0, 0], axis: [0, 1, 0]}
  ankle: {type: revolute, bodies: [rod, slider], location: [1, 0, 0], axis: [0, 1, 0]}
  rail: {type: prismatic, bodies: [ground, slider], location: [1, 0, 0], axis: [1, 0, 0]}
  axle: {type: revolute, bodies: [ground, wheel], location: [0, 0, 1], axis: [0, 1, 0]}
  teeth: {type: gear, joints: [pin, axle], teeth: [20, 30]}
motions:
  drive: {joint: pin, angle: {smooth_step: {to: turn, duration: 0.3, start: 0.1}}}
forces:
  push: {type: linear_spring_damper, joint: rail, force: far*sin(30*t) - 100*displacement}
"""


@pytest.mark.parametrize("keys", [DOP853, RK4], ids=["dop853", "rk4"])
def test_motions_and_gears_have_the_bits_of_runs_by_themselves(keys):
    """A motor that turns by several turns and rests before and after, and a gear that counts its teeth. With fixed
    steps runs go on by themselves where it stops: that looks like a change of the branch."""
    turns = np.linspace(3, 20, 7).tolist()
    scenes = [read_scene_text(DRIVEN, "driven", {"turn": turn, "far": turn}) for turn in turns]
    pairs = [[run_of(scene, **keys, duration=0.6) for scene in scenes] for _ in range(2)]
    assert assert_alike(*pairs) == {"to the end" if keys is DOP853 else "in part": 7}


SHAPES = {
    **{f"tree {seed}": lambda seed=seed: tree(seed) for seed in range(3)},
    **{f"loops {seed}": lambda seed=seed: loops(seed) for seed in range(3)},
    **{f"star {seed}": lambda seed=seed: star(seed) for seed in range(2)},
    "chain": lambda: random_chain(7, ["revolute", "universal", "spherical", "cylindrical"]),
}


@pytest.mark.parametrize("keys", [DOP853, RK4], ids=["dop853", "rk4"])
@pytest.mark.parametrize("shape", SHAPES)
def test_random_mechanisms_have_the_bits_of_runs_by_themselves(shape, keys):
    assert made_alike(alike(SHAPES[shape](), 6, seed=1), duration=0.1, **keys)["to the end"] >= 3


def test_lengths_and_ends_differ_from_case_to_case():
    """A pack holds lengths, tolerances and ends of its own in each lane; lanes that have ended take the next cases."""
    path = next(path for path in MECHANISMS if path.stem == "five_bar")
    rng = np.random.default_rng(3)
    made = [
        (read_scene(path, {"length": length}), {**DOP853, "duration": duration, "tolerance": tolerance})
        for length, duration, tolerance in zip(
            rng.uniform(0.3, 3.0, 11), rng.uniform(0.05, 0.4, 11), 10.0 ** rng.uniform(-10, -5, 11), strict=True
        )
    ]
    pairs = [[run_of(scene, **keys) for scene, keys in made] for _ in range(2)]
    assert assert_alike(*pairs) == {"to the end": len(made)}


def test_what_packs_do_not_make_runs_by_itself():
    """Another signature, another method, a run that has begun: None, and the run goes on as it would have."""
    paths = {path.stem: path for path in MECHANISMS}
    keys = {**RK4, "duration": 0.1}
    five_bar, other = read_scene(paths["five_bar"]), read_scene(paths["double_pendulum"])
    begun = run_of(five_bar, **keys)
    begun.advance(1, FOREVER)
    runs = [run_of(five_bar, **keys), run_of(five_bar, **{**keys, "integrator": "heun2"}), begun, run_of(other, **keys)]
    packed = side_by_side(runs)
    assert [samples is None for samples in packed] == [False, True, True, True]
    for run in runs[1:]:
        assert run.outcome.status == core().Status.running
        run.advance(MOST, FOREVER)
        assert run.outcome.status == core().Status.finished


def test_a_look_that_raises_leaves_the_runs_as_they_were():
    scene = read_scene(next(path for path in MECHANISMS if path.stem == "five_bar"))
    runs, others = ([run_of(scene, **RK4, duration=2.0) for _ in range(5)] for _ in range(2))

    def raising() -> None:
        raise TimeoutError

    with pytest.raises(TimeoutError):
        core().together(runs, 0.0, raising)
    assert assert_alike(runs, others) == {"to the end": 5}
