"""Slopes by dual numbers along one run: closed forms, differences of runs, and what they do not follow."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import mbproj
from mbproj import read_scene
from mbproj.base.errors import InputError
from mbproj.base.mechanisms_folder import mechanism
from mbproj.motion.formulations.choice import choose
from mbproj.motion.tangents import numbers_of
from mbproj.studies.design.slopes import DifferenceWork, differences
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.studies.design.following import NEIGHBOURS, directions_of, follow
from tests.studies.design.scenes import SPRING
from tests.support import assembled

pytestmark = needs_kernel


# Slopes of measures by dual numbers along one run: closed forms, and what moves a parameter into the run.

PENDULUM = """\
mbproj: 1
gravity: [0, 0, -g]
parameters: {length: 0.8 m, g: 9.81 m/s^2, mass: 2 kg, release: 2 rad}
bodies:
  bob: {mass: mass, inertia: [1.0e-6, 1.0e-6, 1.0e-6], position: [length*sin(release), 0, -length*cos(release)],
        orientation: {axis: [0, -1, 0], angle: release}}
joints: {pin: {type: revolute, bodies: [ground, bob], location: [0, 0, 0], axis: [0, -1, 0]}}
simulation: {duration: 3 s, tolerance: 1.0e-9, integrator: dop853, output_step: 0.05 s}
expect:
  swing: {joint: pin, quantity: angle, at: end, below: 100 rad, source: cd}
  turn: {joint: pin, quantity: angle_speed, at: end, below: 100 rad/s, source: cd}
  middle: {joint: pin, quantity: angle, at: 1.35 s, below: 100 rad, source: cd}
  pull: {joint: pin, quantity: reaction_force, component: norm, at: 2 s, below: 1000 N, source: mass and motion}
"""


def swung(t, length, g, release):
    """A pendulum's angle, let go at `release`: 2 arcsin(k cd(ω t, k)) (Whittaker, Analytical Dynamics, § 44)."""
    k, omega = np.sin(release / 2.0), np.sqrt(g / (length + 5e-7 / length))
    _, cn, dn, _ = ellipj(omega * t, k * k)
    return 2.0 * np.arcsin(k * cn / dn)


def derivative(of, at, h=1e-3):
    """Of fourth order, of a closed form."""
    return (8.0 * (of(at + h) - of(at - h)) - (of(at + 2 * h) - of(at - 2 * h))) / (12.0 * h)


def test_pendulum_of_any_swing():
    """By length, gravity and release, at the end and between samples that are ends of steps; a mass changes the load of
    the pin alone, and is a factor of that."""
    found = mbproj.sensitivity(PENDULUM)
    assert not any(map(any, found.why))
    length, g, release = 0.8, 9.81, 2.0
    by = {
        "length": lambda x, t: swung(t, x, g, release),
        "g": lambda x, t: swung(t, length, x, release),
        "release": lambda x, t: swung(t, length, g, x) - x,
    }
    measures, paths = [each.name for each in found.measures], list(found.paths)
    for name, value in (("length", length), ("g", g), ("release", release)):
        column = paths.index(name)
        for measure, t in (("swing", 3.0), ("middle", 1.35)):
            expected = derivative(lambda x, t=t, name=name: by[name](x, t), value)
            assert found.slopes[measures.index(measure), column] == pytest.approx(expected, rel=2e-8)
    mass = paths.index("mass")
    assert np.abs(found.slopes[:3, mass]).max() < 1e-5  # inertia beside mass: 1e-6 kg m²
    assert found.elasticity[3, mass] == pytest.approx(1.0, abs=1e-5)


def test_period_by_length():
    """T = 4 K(k)/ω. Where the angle passes 0 the second time, dt/dl is -∂φ/∂l over the speed."""
    text = PENDULUM.replace("duration: 3 s", "duration: T").replace("release: 2 rad}", "release: 2 rad, T: 1 s}")
    period = 4.0 * ellipk(np.sin(1.0) ** 2) * np.sqrt((0.8 + 5e-7 / 0.8) / 9.81)
    text = text.partition("  middle")[0].replace("T: 1 s", f"T: {float(0.75 * period)!r} s")
    found = mbproj.sensitivity(text, of="swing,turn", to="length")
    assert found.values[0] == pytest.approx(-2.0, abs=1e-9)  # it counts from where the bob is let go
    by_length, speed = -found.slopes[0, 0] / found.values[1], found.values[1]
    assert abs(speed) == pytest.approx(2.0 * np.sin(1.0) * np.sqrt(9.81 / 0.8), rel=1e-5)
    assert by_length == pytest.approx(0.75 * period / 2.0 / 0.8, rel=1e-5)


def test_spring_and_mass():
    """x = cos(√(k/m) t), at the end and where it is largest in size among its samples."""
    expect = """\
expect:
  end: {joint: rail, quantity: displacement, at: end, below: 9 m, source: cos}
"""
    found = mbproj.sensitivity(SPRING.replace("step: 0.01 s,", "tolerance: 1.0e-9, integrator: dop853,") + expect)
    assert not any(map(any, found.why))
    ω, t = 5.0, 2.0
    by_stiffness = -t * np.sin(ω * t) * ω / 2.0 / 50.0
    assert found.slopes[0] == pytest.approx([-by_stiffness * 50.0 / 2.0, by_stiffness], rel=1e-8)
    coarse = mbproj.sensitivity(SPRING + expect)
    assert np.all(np.abs(coarse.slopes[0] - found.slopes[0]) < coarse.uncertainty[0])
    assert np.all(coarse.uncertainty[0] < 100.0 * np.abs(coarse.slopes[0] - found.slopes[0]))


@pytest.mark.parametrize(("name", "to"), [("five_bar", "length,width"), ("planar_four_bar", "crank,speed,down")])
def test_steps_and_what_they_are_off_by(name, to):
    """The scene's fixed steps are off from precise ones by no more than is said."""
    scene = mbproj.read_scene(mechanism(name))
    exact = mbproj.sensitivity(scene.with_({}), to=to)
    text = scene.text
    if scene.settings.step is None:
        text = text.replace("tolerance: 1.0e-8", "step: 2.5 ms").replace("integrator: dop853", "integrator: rk4")
        coarse = mbproj.sensitivity(mbproj.read_scene_text(text), to=to)
    else:
        coarse, text = exact, text.replace("step: 10 ms", "tolerance: 1.0e-11\n  output_step: 10 ms")
        exact = mbproj.sensitivity(mbproj.read_scene_text(text.replace("rk4", "dop853")), to=to)
    apart = np.abs(coarse.slopes - exact.slopes)
    assert np.all(apart <= 1.5 * coarse.uncertainty + 1e-9)
    assert apart.max() > 1e-9


# Slopes by dual numbers beside differences of runs, over what a scene may hold; what they do not follow is said.

#: Two bodies on a rail and a hinge; what acts on them is added. The numbers `a` and `b` are those of that.
HEAD = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {{{parameters}}}
bodies:
  cart: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
  bob: {{mass: 1, inertia: [0.02, 0.03, 0.02], position: [0.5, 0, 0]}}
joints:
  rail: {{type: prismatic, bodies: [ground, cart], location: [0, 0, 0], axis: [1, 0, 0]}}
  pin: {{type: revolute, bodies: [cart, bob], location: [0, 0, 0], axis: [0, -1, 0]}}
simulation: {{duration: 0.6 s, tolerance: 1.0e-9, integrator: dop853, output_step: 0.05 s}}
expect:
  way: {{joint: rail, quantity: displacement, at: end, below: 100 m, source: differences}}
  turn: {{joint: pin, quantity: angle_speed, at: 0.35 s, below: 100 rad/s, source: differences}}
  load: {{joint: pin, quantity: reaction_force, component: norm, at: largest, below: 1.0e6 N, source: differences}}
"""
#: By what acts: the parameters, and the blocks.
ACTS = {
    "spring": (
        "a: 40 N/m, b: 2 N*s/m",
        "forces: {f: {type: linear_spring_damper, joint: rail, stiffness: a, damping: b}}",
    ),
    "law of its own": (
        "a: 3, b: 2",
        "forces: {f: {type: linear_spring_damper, joint: rail, force: a*sin(b*x) - 0.3*v}}\n"
        "signals: {x: rail.displacement, v: rail.displacement_dot}",
    ),
    "force of time": (
        "a: 5 N, b: 4 rad/s",
        "forces: {f: {type: force, body: bob, location: [0.5, 0, 0], force: [a*sin(b*t), 0, a*cos(b*t)]}}",
    ),
    "motion": ("a: 0.2 m, b: 5 rad/s", "motions: {m: {joint: rail, displacement: a*sin(b*t)}}"),
    "bushing": (
        "a: 2000 N/m, b: 30 N*m/rad",
        "forces: {f: {type: bushing, bodies: [ground, bob], location: [0.5, 0, 0], stiffness: "
        "{translation: [a, a, a], rotation: [b, b, b]}}}",
    ),
    "state": (
        "a: 3 N, b: 0.1 s",
        "states: {x: {derivative: (sin(7 1/s*t) - x)/b, initial: 0.2}}\n"
        "forces: {f: {type: linear_spring_damper, joint: rail, force: a*x}}",
    ),
}


def apart(scene, found):
    """By how much slopes differ from those by differences, less what these may be off by and 1e-6 of themselves."""
    work = DifferenceWork(scene, scene.settings, found.paths, found.measures)
    other = differences(work, found.x, np.where(found.x == 0.0, 1.0, np.abs(found.x)), 1)
    assert np.abs(other.slopes).max() > 0.0
    return np.max(np.abs(found.slopes - other.slopes) - other.uncertainty - 1e-6 * np.abs(other.slopes))


@pytest.mark.parametrize("name", ACTS)
def test_of_what_acts(name):
    parameters, blocks = ACTS[name]
    scene = mbproj.read_scene_text(HEAD.format(parameters=parameters) + blocks + "\n")
    found = mbproj.sensitivity(scene, jobs=1)
    assert not any(map(any, found.why))
    assert np.all(np.abs(found.elasticity).max(axis=0) > 1e-4)
    assert apart(scene, found) <= 0.0


@pytest.mark.parametrize(
    ("name", "to", "of"),
    [
        full("differential", "ice,road", ""),  # gears
        ("governor", "ball,arm", ""),  # loops in space
        full("rolling_coin", "R,m", ""),  # rows of velocities
        ("chaplygin_sleigh", "a,J", ""),
        ("hoist", "g,load", ""),  # a rope around pulleys
        full("planar_four_bar", "crank,speed", ""),
        full("spatial_four_bar", "rocker", ""),  # loops with a motion
    ],
)
def test_of_mechanisms(name, to, of):
    scene = mbproj.read_scene(mechanism(name))
    found = mbproj.sensitivity(scene, to=to, jobs=1)
    assert not any(map(any, found.why))
    assert apart(scene, found) <= 0.0


@pytest.mark.parametrize(
    ("name", "to", "why"),
    [
        ("hoist", "radius", "a rope's path"),
        ("door_with_stop", "width", "stops or dry friction"),
    ],
)
def test_what_they_do_not_follow_is_said(name, to, why):
    found = mbproj.sensitivity(mbproj.read_scene(mechanism(name)), to=to, jobs=1)
    assert why in found.why[0][0]
    assert {(row[-2], why in row[-1]) for row in found.table.rows} == {("differences", True)}


def test_instants_that_move_are_said():
    """A force that sets in at `a`: its kink is where steps end."""
    blocks = 'forces: {f: {type: linear_spring_damper, joint: rail, force: "-9*max(t - a, 0)"}}\n'
    text = HEAD.format(parameters="a: 0.2, b: 3") + blocks
    found = mbproj.sensitivity(mbproj.read_scene_text(text), to="a", of="way", jobs=1)
    assert found.why[0][0].startswith("it moves instants")
    assert found.slopes[0, 0] > 0.0


def test_one_measure_that_is_no_state_goes_by_differences_alone():
    """Energy that dampers lose is found along the run: E + D = k s²/2, with s = 1 m at the start."""
    text = HEAD.format(parameters="k: 50, c: 0.7") + (
        "forces: {f: {type: linear_spring_damper, joint: rail, stiffness: k, damping: c, free_displacement: -1}}\n"
    )
    ends = "at: end, below: 100, source: energy"
    text = text.replace(
        "expect:", f"expect:\n  lost: {{diagnostic: dissipation, {ends}}}\n  left: {{diagnostic: total_energy, {ends}}}"
    )
    found = mbproj.sensitivity(mbproj.read_scene_text(text), to="k,c", of="lost,left", jobs=1)
    assert found.why == (("'diagnostics/dissipation' is no function of the state",) * 2, ("", ""))
    assert found.slopes.sum(axis=0) == pytest.approx([0.5, 0.0], abs=1e-9)
    assert np.abs(found.slopes).min() > 1e-3


# Slopes of the motion by parameters, which dual numbers follow along a run, against differences of runs.

#: Of each mechanism parameters, their values and by what neighbours differ: a length, a mass, a speed at the start.
CASES = {
    "five_bar": {"length": (1.0, 3e-4), "bodies.bar3.mass": (1.0, 3e-4), "joints.A.speed": (0.5, 3e-4)},
    "spatial_slider_crank": {
        "crank_length": (0.08, 3e-5),
        "bodies.rod.mass": (0.5, 3e-4),
        "speed": (6.0, 3e-3),
        "rod_pin": (4e-3, 3e-6),
        "bodies.slider.mass": (2.0, 1e-3),
    },
}
EXACT = {"integrator": "dop853", "tolerance": 1e-12, "step": None}


def builder(name, formulation="auto", **simulation):
    """Of the values of its parameters a mechanism ready to run; and its settings."""
    keys = {"duration": 0.5, "formulation": formulation, **simulation}

    def build(values):
        parameters = dict(zip(CASES[name], map(float, values), strict=True))
        scene = read_scene(mechanism(name), parameters, keys)
        system, state = assembled(scene)
        return choose(system, state, scene.settings).compiled, state, scene.settings

    return build


def values_and_widths(name):
    return np.array(list(CASES[name].values())).T


def tangents(name, **keys):
    """The run that was followed, the slopes of q and q' at its end, and what was built."""
    build, (values, widths) = builder(name, **keys), values_and_widths(name)
    compiled, state, directions = directions_of(lambda at: build(at)[:2], values, widths)
    followed = follow(compiled, state, build(values)[2], directions)
    return followed, np.concatenate(followed.coordinates(compiled), axis=1), compiled


def end(build, values):
    """q and q' at the end of a run."""
    compiled, state, settings = build(values)
    run = compiled.run(state, settings)
    run.advance(2**31, 1e9)
    assert compiled.failure(run, settings) is None
    return np.concatenate(compiled.coordinates(compiled.bodies_of(run.standing["y"])))


def differences_of_runs(name, k, **keys):
    """The slope of q and q' at the end by parameter k, by four runs."""
    build, (values, widths) = builder(name, **keys), values_and_widths(name)
    step = np.eye(len(values))[k] * widths[k]
    return sum(weight * end(build, values + place * step) for place, weight in NEIGHBOURS) / widths[k]


@cache
def exact(name):
    return tangents(name, **EXACT)


@pytest.mark.parametrize(("name", "k"), [(name, k) for name, own in CASES.items() for k in range(len(own))])
def test_slopes_are_those_of_precise_runs(name, k):
    _, slopes, _ = exact(name)
    expected = differences_of_runs(name, k, **EXACT)
    assert np.abs(expected).max() > 1e-3
    assert np.abs(slopes[k] - expected).max() < 2e-9 * np.abs(expected).max()


@pytest.mark.parametrize(
    ("integrator", "projection", "apart"), [("rk4", "gpopm", 2e-5), ("dop853", "gpopm", 1e-8), ("rk4", "gopm", 3e-7)]
)
def test_slopes_of_coarse_steps_are_those_of_the_same_steps(integrator, projection, apart):
    """Fixed steps are the same for a neighbour. A projection whose factor is of another pose is not quite the least
    one: with RK4, whose steps leave 0.3 mm here, the slopes show that. GOPM has a factor of its own, of the pose."""
    keys = {"integrator": integrator, "step": 0.01, "duration": 0.3, "projection": projection}
    _, slopes, _ = tangents("spatial_slider_crank", **keys)
    for k in range(3):
        expected = differences_of_runs("spatial_slider_crank", k, **keys)
        assert np.abs(slopes[k] - expected).max() < apart * np.abs(expected).max()


def test_states_are_those_of_the_run():
    followed, _, compiled = exact("five_bar")
    build, (values, _) = builder("five_bar", **EXACT), values_and_widths("five_bar")
    assert followed.t[0] == 0.0
    assert followed.t[-1] == 0.5
    own = np.concatenate(compiled.coordinates(compiled.bodies_of(followed.y[-1])))
    assert np.array_equal(own, end(build, values))


def test_slopes_keep_to_the_joints():
    """G ∂q = -∂C by the parameters: at the end all rows are closed for the neighbour that the slopes predict."""
    followed, _, _ = exact("spatial_slider_crank")
    build, (values, widths) = builder("spatial_slider_crank", **EXACT), values_and_widths("spatial_slider_crank")
    step = np.eye(len(values))[0] * widths[0]
    sides = []
    for place, weight in NEIGHBOURS:
        compiled = build(values + place * step)[0]
        y = followed.y[-1] + place * widths[0] * followed.slopes[-1, 0]
        sides.append(weight * compiled.equations().constraint(np.ascontiguousarray(compiled.bodies_of(y)), 0.5))
    assert np.abs(sum(sides) / widths[0]).max() < 1e-9


def test_planar_and_spatial_slopes_agree():
    _, planar, _ = exact("five_bar")
    _, spatial, _ = tangents("five_bar", formulation="reduced", **EXACT)
    assert spatial == pytest.approx(planar, abs=1e-8 * np.abs(planar).max())


def test_more_directions_than_a_dual_number_has():
    """They are followed in groups: each direction's slopes are the same in any group."""
    build, (values, widths) = builder("five_bar", **EXACT), values_and_widths("five_bar")
    compiled, state, three = directions_of(lambda at: build(at)[:2], values, widths)
    rows = np.arange(9) % 3
    nine = replace(three, numbers=three.numbers[rows], start=three.start[rows])
    followed = follow(compiled, state, build(values)[2], nine)
    assert np.array_equal(followed.slopes[-1], exact("five_bar")[0].slopes[-1][rows])


def test_numbers_of_a_model_are_what_a_parameter_changes():
    """A mass, and the inertia that the scene makes of it: no other number."""
    build, (values, widths) = builder("five_bar", formulation="reduced"), values_and_widths("five_bar")
    heavier = values + np.eye(3)[1] * widths[1]
    change = numbers_of(build(heavier)[0]) - numbers_of(build(values)[0])
    assert np.flatnonzero(change).tolist() == [2 * 10]  # of body 3 the mass, then nine moments
    assert change[20] == pytest.approx(widths[1])


@pytest.mark.parametrize(
    ("keys", "why"),
    [({"integrator": "radau5"}, "tableau is not that of explicit steps"), ({"projection": "baumgarte"}, "projection")],
)
def test_slopes_that_are_not_known_are_refused(keys, why):
    with pytest.raises(InputError, match=why):
        tangents("five_bar", **keys)
