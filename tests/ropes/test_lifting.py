"""A rope that leaves a sheave and comes back: against its own equations, orders of fixed steps, a start that is off."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbproj import InputError, read_scene_text
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.ropes.scenes import G, scene
from tests.stops.runs import run

pytestmark = needs_kernel
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
def test_what_is_refused(old, new, message):
    assert old in THROWN
    with pytest.raises(InputError) as caught:
        read_scene_text(scene(THROWN.replace(old, new)))
    assert message in str(caught.value)
