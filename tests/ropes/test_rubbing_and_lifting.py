"""A rope that rubs on sheaves, by Euler's and Eytelwein's law, and one that leaves a sheave and comes back."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbproj
from mbproj import InputError, read_scene_text
from mbproj.results.analysis.expectations import outcomes
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.ropes.scenes import G, scene
from tests.stops.runs import run

pytestmark = needs_kernel


# A rope that rubs on sheaves, against Euler's and Eytelwein's law: what holds, what slips, what is refused.

#: Two weights on a rope over a sheave that does not turn.
WEIGHTS = """
parameters: {heavy: 3, turns: 0, ratio: exp(0.3*pi)}
bodies:
  light: {mass: 1, inertia: [1, 1, 1], position: [1.9, 0, -1]}
  heavy: {mass: heavy, inertia: [1, 1, 1], position: [2.1, 0, -1]}
joints:
  one: {type: prismatic, bodies: [ground, light], location: [1.9, 0, -1], axis: z}
  other: {type: prismatic, bodies: [ground, heavy], location: [2.1, 0, -1], axis: z}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: light, at: [1.9, 0, -1]}
      - {sheave: ground, at: [2, 0, 0], radius: 0.1, bends: right, turns: turns, friction: 0.3}
      - {point: heavy, at: [2.1, 0, -1]}
"""
#: A weight on a rope over a sheave, to a slider that a motion pulls away.
PULLED = """
bodies:
  slider: {mass: 1, inertia: [1, 1, 1], position: [-0.5, 0, -0.6]}
  load: {mass: 2, inertia: [1, 1, 1], position: [0.1, 0, -1]}
joints:
  rail: {type: prismatic, bodies: [ground, slider], location: [-0.5, 0, -0.6], axis: [-1, 0, 0]}
  guide: {type: prismatic, bodies: [ground, load], location: [0.1, 0, -1], axis: z}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: slider, at: [-0.5, 0, -0.6]}
      - {sheave: ground, at: [0, 0, 0], radius: 0.1, bends: right, friction: 0.25}
      - {point: load, at: [0.1, 0, -1]}
motions:
  pulls: {joint: rail, displacement: {expression: 0.3*t + 0.2*t**2}}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(("turns", "heavy"), [(0, 3.0), (1, 20.0)])
@pytest.mark.parametrize("formulation", ["planar", "reduced", "full"])
def test_it_slips_where_the_weights_ask_for_more(formulation, turns, heavy):
    """T2 = e^(μα) T1 at half a turn and at one and a half: s'' = g (m2 - e^(μα) m1) / (m2 + e^(μα) m1)."""
    _, found = run(scene(WEIGHTS, formulation, 0.1 if formulation == "full" else 0.5), heavy=heavy, turns=turns)
    ratio = np.exp(0.3 * np.pi * (1 + 2 * turns))
    gain = G * (heavy - ratio) / (heavy + ratio)
    np.testing.assert_allclose(found["joints/coordinate"][:, 0], 0.5 * gain * found["time"] ** 2, atol=1e-11)
    first, second = found["ropes/tension"].T
    np.testing.assert_allclose(first, G + gain, rtol=1e-10)
    np.testing.assert_allclose(second / first, ratio, rtol=1e-12)
    assert found.unbalanced < 1e-9


@pytest.mark.parametrize(("turns", "heavy"), [(0, 2.5), (0, 0.4), (1, 16.8)])
def test_it_holds_below(turns, heavy):
    """e^(0.3 π) = 2.566, e^(0.9 π) = 16.9: the weights hang, and the tensions are theirs."""
    _, found = run(scene(WEIGHTS, "planar", 0.2), heavy=heavy, turns=turns)
    np.testing.assert_allclose(found["joints/coordinate"][:, :2], 0.0, atol=1e-13)
    np.testing.assert_allclose(found["ropes/tension"], [[G, heavy * G]] * len(found["time"]), rtol=1e-12)
    assert (found["friction/state"] == 0.0).all()


@pytest.mark.parametrize("formulation", ["planar", "full"])
def test_the_wrap_of_the_pose_counts(formulation):
    """The strand to the slider turns, and what lies on the sheave with it: T is of the moving load, T e^(μα) pulls."""
    _, found = run(scene(PULLED, formulation, 0.1 if formulation == "full" else 0.6))
    x, z = found["bodies/position"][:, 0, 0], found["bodies/position"][:, 0, 2]
    far = np.hypot(x, z)
    angle = np.arctan2(-z, -x) + np.arcsin(0.1 / far)  # of the strand up to the sheave
    wrap = angle + 0.5 * np.pi
    slack, pull = found["ropes/tension"].T[::-1]
    np.testing.assert_allclose(slack, 2.0 * (G + found["bodies/acceleration"][:, 1, 2]), rtol=1e-10)
    np.testing.assert_allclose(pull / slack, np.exp(0.25 * wrap), rtol=1e-10)
    assert np.ptp(wrap) > (0.01 if formulation == "full" else 0.1)
    assert found.unbalanced < 1e-9


def test_an_expectation_is_about_either_side_and_the_friction():
    text = (
        scene(WEIGHTS, "planar", 0.2)
        + "expect:\n"
        + (
            "  a: {joint: rope, quantity: tension_2, at: end, value: 2*3*9.81*ratio/(3 + ratio),"
            " relative: 1.0e-9, source: closed form}\n"
            "  b: {friction: rope.slip_1, quantity: state, at: end, value: -1, absolute: 1.0e-9, source: it slips}\n"
        )
    )
    parsed = read_scene_text(text)
    with mbproj.run(parsed) as results:
        assert [each.holds for each in outcomes(parsed.expectations, results)] == [True, True]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("{sheave: ground, at: [2, 0, 0]", "{wheel: light", "has 'friction' and is a wheel"),
        ("    path:", "    free: true\n    path:", "a rope whose length may change rubs on a sheave"),
        (
            "      - {point: heavy",
            "      - {sheave: ground, at: [2.8, 0, 0], radius: 0.1, bends: right, friction: 0.2}\n"
            "      - {point: heavy",
            "the rope rubs on place 2 already; make two ropes of it",
        ),
        (
            "{point: light, at: [1.9, 0, -1]}",
            "{drum: light, radius: 0.05, bends: left}",
            "turns a wheel or a drum; end it",
        ),
        (
            "{sheave: ground, at: [2, 0, 0]",
            "{sheave: loose, at: [2, 0, 0]",
            "whose body may turn against the plane of the",
        ),
        ("friction: 0.3", "friction: -0.3", "'friction' must be at least 0"),
    ],
)
def test_what_is_refused(old, new, message):
    assert old in WEIGHTS
    loose = "\nbodies:\n  loose: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0]}\n"
    with pytest.raises(InputError) as caught:
        read_scene_text(scene(WEIGHTS.replace(old, new).replace("\nbodies:\n", loose)))
    assert message in str(caught.value)


# A rope that leaves a sheave and comes back: against its own equations, orders of fixed steps, a start that is off.

#: A load on a rope from the ground over a sheave, which is thrown up: the rope lifts off, and lies down again.
THROWN = """
bodies:
  load: {mass: 2, inertia: [1, 1, 1], position: [0.6, 0, 0.05], velocity: [0, 0, 1.2]}
joints:
  plane: {type: planar, bodies: [ground, load], location: [0, 0, 0], axis: [0, 1, 0]}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: ground, at: [-1, 0, 0.1]}
      - {sheave: ground, at: [0, 0, 0], radius: 0.1, bends: right, lifts: true}
      - {point: load, at: [0.6, 0, 0.05]}
"""
ANCHOR, R = np.array([-1.0, 0.1]), 0.1


def strand(place):
    """Where the rope from the load goes, how long it is free, and by what angle it lies on the sheave: from the anchor
    it comes along z = R."""
    far = np.hypot(*place)
    turned = np.arctan2(place[1], place[0]) + np.arccos(R / far)  # of the place where it touches, from x
    wrap = 0.5 * np.pi - turned
    to = R * np.array([np.cos(turned), np.sin(turned)]) if wrap > 0.0 else ANCHOR
    return (to - place) / np.hypot(*(to - place)), np.hypot(*(to - place)), wrap


def expected(start, times):
    """Places (T, 2), tensions (T,) and the times at which the wrap is 0: steps end there."""

    def slope(_, y, on):
        place, v = y[:2], y[2:]
        toward, free, _ = strand(place)
        if not on:
            free = np.hypot(*(ANCHOR - place))
            toward = (ANCHOR - place) / free
        across = toward[0] * v[1] - toward[1] * v[0]
        pull = across**2 / free + toward[1] * G
        return np.concatenate([v, pull * toward - [0.0, G]])

    def edge(_, y, on):
        return strand(y[:2])[2]

    edge.terminal = True
    y, t, on, found, met = np.array(start), 0.0, True, [], []
    while True:
        edge.direction = -1.0 if on else 1.0
        part = solve_ivp(
            slope, (t, times[-1]), y, "DOP853", rtol=1e-12, atol=1e-13, args=(on,), events=edge, dense_output=True
        )
        inside = times[(times >= t) & ((times < part.t[-1]) | (part.status == 0))]
        for each in inside:
            state = part.sol(each)
            pull = np.add(slope(0.0, state, on)[2:], [0.0, G]) @ strand_of(state[:2], on)
            found.append([*state[:2], 2.0 * pull])
        if part.status == 0:
            return np.array(found), met
        y, t, on = part.y[:, -1], part.t[-1], not on
        met.append(t)


def strand_of(place, on):
    """The direction of the strand at the load."""
    return strand(place)[0] if on else (ANCHOR - place) / np.hypot(*(ANCHOR - place))


@pytest.mark.parametrize("formulation", ["planar", "reduced", full("full")])
def test_a_load_that_is_thrown_up_and_falls(formulation):
    _, found = run(scene(THROWN, formulation, 0.1 if formulation == "full" else 0.6))
    first = found["bodies/velocity"][0, 0, [0, 2]]  # across the strand, which is taut
    reference, met = expected([0.6, 0.05, *first], found["time"])
    np.testing.assert_allclose(found["bodies/position"][:, 0, [0, 2]], reference[:, :2], atol=2e-10)
    np.testing.assert_allclose(found["ropes/tension"][:, 0], reference[:, 2], atol=1e-8)
    events = [event for event in found.happened if "place 2" in event.kind]
    np.testing.assert_allclose([event.time for event in events], met, atol=1e-9)
    kinds = ["leaves its place 2", "comes back to its place 2"]
    assert [event.kind for event in events] == kinds[: len(met)] and len(met) == (1 if formulation == "full" else 2)
    assert found.unbalanced < 1e-9


def test_steps_end_where_it_leaves():
    """RK4 keeps its order up to both events, the second of them past the first."""
    exact = np.array([event.time for event in run(scene(THROWN, "planar", 0.3))[1].happened])
    off = []
    for count in (50, 100):
        text = scene(THROWN, "planar", 0.3).replace("output_step: 20 ms", "output_step: 0.3 s")
        text = text.replace("integrator: dop853, tolerance: 1.0e-12", f"integrator: rk4, step: {0.3 / count!r}")
        off.append(np.abs([event.time for event in run(text)[1].happened] - exact))
    assert np.log2(off[0] / off[1]).min() > 3.8


def test_a_rope_that_is_off_at_first():
    """Its length is that of the straight strand."""
    off = THROWN.replace("[0.6, 0, 0.05]", "[0.6, 0, 0.2]").replace("velocity: [0, 0, 1.2]", "velocity: [0, 0, 0]")
    _, found = run(scene(off, "planar", 0.2))
    length = np.hypot(1.6, 0.1)
    assert found["joints/coordinate"][0, 3] == pytest.approx(length, abs=1e-13)
    assert found["joints/coordinate"][0, 4] < 0.0 < found["joints/coordinate"][-1, 4]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("lifts: true", "lifts: true, friction: 0.2", "'lifts' off what is no plain sheave"),
        (
            "{sheave: ground, at: [0, 0, 0]",
            "{wheel: load, at: {load: [0, 0, 0]}",
            "'lifts' off what is no plain sheave",
        ),
        (
            "      - {point: load",
            "      - {sheave: ground, at: [0.3, 0, 0], radius: 0.1, bends: right, lifts: true}\n      - {point: load",
            "the rope lifts off places 2 and 3, which are beside each other",
        ),
    ],
)
def test_what_is_refused_of_lifting_ropes(old, new, message):
    assert old in THROWN
    with pytest.raises(InputError) as caught:
        read_scene_text(scene(THROWN.replace(old, new)))
    assert message in str(caught.value)
