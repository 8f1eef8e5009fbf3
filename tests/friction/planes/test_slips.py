"""Where a slip begins, by closed forms, and forces within their cones in the plane and in space."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.base.errors import SimulationError
from mbproj.base.thresholds import Thresholds
from tests.crossed import full
from tests.friction.mechanisms import block
from tests.friction.planes.scenes import CORNERS, IN_PLANE, box, puck
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import DOP853, FIXED, run, same, simulated

pytestmark = needs_kernel


# Where a slip begins: feet at a reversal, directions of slips that begin, and bodies of small inertia. What is right
# comes from closed forms and from an independent integration.

FOOT = """  {name}:
    type: stop
    plane: {{body: {floor}, location: [0, 0, {z}], normal: [0, 0, 1]}}
    point: {{body: {body}, location: {{{body}: [{x}, 0, {below}]}}}}
    rigid: true
    friction: {friction}
"""
CRANKED = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: 1, formulation: {formulation}, {steps}}}
bodies:
  crank: {{mass: 1, inertia: [0.2, 0.3, 0.2], position: [0, 0, 0]}}
  {body}
joints:
  A: {{type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, -1, 0], speed: {speed}}}
  {joints}
{motions}
forces:
{feet}
"""
M, R, W, MU = 3.0, 0.12, 9.0, 0.25


def yoke(formulation="auto", steps=DOP853, places=(-0.15, 0.1), motions=None):
    """A Scotch yoke: its block on feet at these places moves as R cos(ωt)."""
    feet = (
        FOOT.format(name=f"f{k}", floor="ground", body="block", x=x, z=-0.04, below=-0.04, friction=MU)
        for k, x in enumerate(places)
    )
    return CRANKED.format(
        formulation=formulation,
        steps=steps,
        speed=W,
        body=f"block: {{mass: {M}, inertia: [0.02, 0.03, 0.02], position: [{R}, 0, 0]}}",
        joints=f"slot: {{type: point_on_line, bodies: [block, crank], location: [{R}, 0, 0], axis: z}}\n"
        f"  plane: {{type: planar, bodies: [ground, block], location: [{R}, 0, 0], axis: y, x_axis: x, "
        "speed: {displacement_y: 0, angle: 0}}",
        motions=motions or f"motions:\n  drive: {{joint: A, angle: {{constant_speed: {W}}}}}",
        feet="".join(feet),
    )


@pytest.mark.parametrize(
    ("formulation", "steps", "near"),
    [("auto", DOP853, 1e-8), ("reduced", DOP853, 1e-8), ("auto", "integrator: radau5, tolerance: 1.0e-8", 1e-5)],
)
@pytest.mark.parametrize("places", [(-0.15, 0.1), (-0.2, -0.02, 0.15)])
def test_feet_of_a_driven_block_slide_on_after_each_dead_centre(formulation, steps, near, places):
    """The drive turns against inertia and all of the friction: T = R sin(ωt) (m R ω² cos(ωt) ± μ m g)."""
    if "radau5" in steps:
        steps += ", output_step: 0.1"
    _, recorded = run(yoke(formulation, steps, places))
    angle = W * recorded["time"]
    force = M * R * W**2 * np.cos(angle) + MU * M * 10.0 * np.sign(np.sin(angle))
    right = R * np.sin(angle) * force
    assert recorded["motions/force"][1:, 0] == pytest.approx(right[1:], abs=near * M * R**2 * W**2)
    assert not recorded.of("stick")


@pytest.mark.parametrize("x", [0.2, -0.1])
def test_feet_of_a_free_slider_crank_lose_what_friction_takes(x):
    """The slider moves through dead centres of a crank that turns freely: energy is lost by μ m g times the way."""
    text = CRANKED.format(
        formulation="auto",
        steps=DOP853,
        speed=14,
        body="rod: {mass: 0.4, inertia: [0.01, 0.02, 0.01], position: [0.25, 0, 0]}\n"
        "  block: {mass: 2, inertia: [0.02, 0.02, 0.02], position: [0.4, 0, 0]}",
        joints="B: {type: revolute, bodies: [crank, rod], location: [0.1, 0, 0], axis: [0, 1, 0]}\n"
        "  C: {type: revolute, bodies: [rod, block], location: [0.4, 0, 0], axis: [0, 1, 0]}\n"
        "  plane: {type: planar, bodies: [ground, block], location: [0.4, 0, 0], axis: y, x_axis: x}",
        motions="",
        feet="".join(
            FOOT.format(name=f"f{k}", floor="ground", body="block", x=place, z=-0.05, below=-0.05, friction=0.3)
            for k, place in enumerate((x - 0.15, x))
        ),
    )
    _, recorded = run(text)
    assert recorded.unbalanced < 1e-8
    assert not recorded.of("stick")
    assert (recorded["friction/dissipation"][-1] > 0.5).any()


STAGE = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 0.8, formulation: {formulation}, {steps}}}
bodies:
  x: {{mass: 6, inertia: [1, 1, 1], position: [0, 0, 0.5]}}
  y: {{mass: 0.3, inertia: [1, 1, 1], position: [0, 0, 0.4]}}
  z: {{mass: 0.7, inertia: [1, 1, 1], position: [0, 0, 0.1]}}
joints:
  X: {{type: prismatic, bodies: [ground, x], location: [0, 0, 0.5], axis: x}}
  Y: {{type: prismatic, bodies: [x, y], location: [0, 0, 0.4], axis: y}}
  Z: {{type: prismatic, bodies: [y, z], location: [0, 0, 0.1], axis: z}}
forces:
  foot:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: z, location: [0, 0, 0]}}
    rigid: true
    friction: 0.4
  push: {{type: force, body: z, force: ["{push[0]}", "{push[1]}", 0]}}
"""
#: Pushes at the edge of the cone at 0.1 s, and their rates. With the first one n·M⁻¹Ḟ < 0: the foot that keeps the
#: direction n of the static force would be pushed back.
HELD = 0.4 * 0.7 * 9.81
RATES = [(2.2, -1.1), (0.0, 1.5), (1.0, 1.0)]


def push(rate, angle=0.7):
    return [f"{float(HELD * c)!r} + {r}*(t - 0.1)" for c, r in zip((np.cos(angle), np.sin(angle)), rate, strict=True)]


def regularised(rate, angle=0.7, width=1e-8):
    """The place of the foot at 0.8 s, with friction v / sqrt(v² + w²)."""
    masses, edge = np.array([7.0, 1.0]), HELD * np.array([np.cos(angle), np.sin(angle)])

    def slope(t, y):
        v = y[2:]
        return np.r_[v, (edge + np.array(rate) * (t - 0.1) - HELD * v / np.sqrt(v @ v + width**2)) / masses]

    found = solve_ivp(slope, (0.0, 0.8), np.zeros(4), method="Radau", rtol=1e-9, atol=1e-13, max_step=0.02)
    return found.y[:2, -1]


@pytest.mark.parametrize("rate", [RATES[0], *map(full, RATES[1:])])
def test_a_slip_begins_along_the_velocity_that_arises(rate):
    report, recorded = run(STAGE.format(formulation="auto", steps=DOP853, push=push(rate)))
    assert recorded["bodies/position"][-1, 2, :2] == pytest.approx(regularised(rate), abs=2e-6)
    assert recorded["friction/dissipation"][-1].sum() > 0.0 and recorded.unbalanced < 1e-9
    assert [event.time for event in recorded.of("slip")] == pytest.approx([0.1], abs=1e-7)
    assert report.unresolved == ()


@pytest.mark.parametrize(
    "steps", [full("integrator: radau5, tolerance: 1.0e-7"), "integrator: esdirk4, tolerance: 1.0e-7"]
)
def test_so_it_does_in_implicit_steps(steps):
    _, recorded = run(STAGE.format(formulation="auto", steps=f"{steps}, output_step: 0.1", push=push(RATES[1])))
    assert recorded["bodies/position"][-1, 2, :2] == pytest.approx(regularised(RATES[1]), abs=1e-5)


def test_fixed_steps_say_that_they_do_not_resolve_it():
    """RK4 has order 1 then: at 1 ms it is off by some per cent."""
    report, _ = run(STAGE.format(formulation="auto", steps=FIXED, push=push(RATES[0])))
    assert len(report.unresolved) == 1 and "'foot.1', whose slip turns as it begins" in report.unresolved[0]


BLOCK = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: 1.2, formulation: {formulation}, {steps}}}
bodies:
  block: {{mass: 8, inertia: [{J}, {J}, {J}], position: [0, 0, 0.06]}}
joints:
  plane: {{type: planar, bodies: [ground, block], location: [0, 0, 0.06], axis: [0, 1, 0]}}
forces:
{feet}
  push: {{type: force, body: block, axes: global, force: ["30*t", 0, 0], location: [0, 0, 0.06]}}
"""


def block_on_feet(inertia, places=(-0.25, 0.35), formulation="auto", steps=DOP853):
    feet = (
        FOOT.format(name=f"f{k}", floor="ground", body="block", x=x, z=0, below=-0.06, friction=0.3)
        for k, x in enumerate(places)
    )
    return BLOCK.format(J=inertia, formulation=formulation, steps=steps, feet="".join(feet))


@pytest.mark.parametrize("inertia", [5e-4, 0.002, 0.2])
@pytest.mark.parametrize("places", [(-0.25, 0.35), (-0.25, 0.1, 0.35)])
def test_an_inertia_about_feet_that_slip_together_does_not_matter(inertia, places):
    """It slips at 30 t = μ m g, t = 0.8 s, and moves by 30 (t - 0.8)³ / (6 m) from there."""
    _, recorded = run(block_on_feet(inertia, places))
    assert recorded["bodies/position"][-1, 0, 0] == pytest.approx(30.0 / 8.0 * 0.4**3 / 6.0, abs=1e-9)
    assert [event.time for event in recorded.of("slip")] == pytest.approx([0.8] * len(places), abs=1e-7)


def test_friction_that_pushes_along_the_motion_ends_the_run():
    """No scene leads there: with this threshold a slip keeps its first direction, also after the push has reversed."""
    turned = [f"{each} - 60*max(t - 0.2, 0)" for each in push((1.0, 1.0))]
    scene = read_scene_text(STAGE.format(formulation="auto", steps=DOP853, push=turned))
    system = replace(compile_system(scene), thresholds=Thresholds(straight_speed=1e3))
    state = assemble(system, initial_guess(scene, system))
    with pytest.raises(SimulationError, match=r"dry friction pushes along the motion, so it creates energy") as found:
        simulate(system, state, settings_to_run(scene))
    assert "friction 'foot.1'" in str(found.value) and 0.2 < found.value.time < 0.6


# Stops with friction: forces within their cones, and one motion in the plane and in space.

INCLINE = (10.0 * np.sin(0.3), 0.0, -10.0 * np.cos(0.3))
STATIC = "{coefficient: 0.3, static: 0.5}"
STRIBECK = "{coefficient: 0.3, static: 0.5, stribeck_speed: 0.2}"
FRO, ROUND = '["20*sin(6*t)", 0, 0]', '["20*sin(5*t)", "7*cos(5*t)", 0]'
WIDE = {"a": (-0.36, 0.26), "b": (0.45, -0.07), "c": (-0.19, 0.04), "d": (-0.08, -0.38)}
TWO, THREE = {"a": (-0.45, 0.0), "b": (0.4, 0.0)}, {"a": (-0.4, 0.0), "b": (0.1, 0.0), "c": (0.35, 0.0)}


def scenes(steps):
    """Each with the formulations that it is for."""
    thrown = {"velocity": (1, 0.4, 0), "spin": (0, 0, 5), "duration": 0.4, "steps": steps}
    return {
        "a puck that turns downhill": puck("0.4", [0, 2, 0], gravity=INCLINE, steps=steps),
        "a puck that bounces": puck(STATIC, [1, 0.5, -1], height=0.2, e=0.5, duration=1.5, steps=steps),
        "a puck of Stribeck's": puck(STRIBECK, [1, 2, 0], steps=steps),
        "two feet in the plane": box(TWO, STATIC, push=19, joint=IN_PLANE, formulation="planar", steps=steps),
        "three feet in the plane": box(
            THREE, "0.25", velocity=(1.02, 0, 0), joint=IN_PLANE, formulation="planar", steps=steps
        ),
        "three feet": box({name: CORNERS[name] for name in "abc"}, STATIC, **thrown),
        "four feet": box(CORNERS, "0.25", **thrown),
        "four feet that are pushed": box(CORNERS, STATIC, push=19, duration=0.9, steps=steps),
        "two feet that are pushed to and fro": box(
            TWO, STATIC, force=FRO, height=0.05, joint=IN_PLANE, formulation="planar", steps=steps
        ),
        "a box that lifts a foot while it slides": box(
            WIDE, STRIBECK, velocity=(-0.48, 0.5, 0), force=ROUND, height=0.22, duration=0.8, steps=steps
        ),
        "a block that rocks": block(0.6, 0.1, R=0.5, α=0.3, duration=0.6, steps=steps),
    }


RECORDED = ("bodies/position", "bodies/velocity", "stops/force", "friction/force", "friction/dissipation")


#: All by error, and every other one with either kind of fixed steps.
CASES = [(name, steps) for k, name in enumerate(scenes("rk4")) for steps in ("dop853", ("rk4", "radau5")[k % 2])]


@pytest.mark.parametrize(("name", "steps"), CASES)
def test_forces_are_within_their_cones(name, steps):
    """No stop pulls, what pushes is closed, and friction is at most the largest coefficient times the push."""
    _, recorded = run(scenes(steps)[name])
    assert len(recorded.happened) > 0
    push, rub = recorded["stops/force"], recorded["friction/force"]
    assert push.min() >= 0.0
    assert (recorded["stops/gap"] * push).max() < 1e-7 * push.max()
    assert recorded["stops/gap"].min() > -1e-7
    across = np.hypot(rub[:, ::2], rub[:, 1::2])
    assert (across - 0.5 * push).max() < 1e-6 * push.max()  # no scene here has a larger one
    assert np.diff(recorded["friction/dissipation"], axis=0).min() > -1e-7


@pytest.mark.parametrize("steps", ["dop853", "rk4"])
@pytest.mark.parametrize("name", [name for name in scenes("rk4") if "in the plane" in name or "to and fro" in name])
def test_it_is_the_same_in_the_plane_and_in_space(name, steps):
    """With loads that stops share, and joints: what they bear beside the plane is told, too."""
    text = scenes(steps)[name]
    assert "formulation: planar" in text
    _, space = run(text.replace("formulation: planar", "formulation: reduced"))
    same(run(text)[1], space, RECORDED, 1e-7)


def test_the_least_share_within_the_cones_is_reported():
    """Two feet bear half of what pushes each, until one can bear no more."""
    text = box(TWO, STATIC, push=20, joint=IN_PLANE, formulation="planar", duration=0.7)
    _, recorded = run(text)
    push, bears = 20.0 * recorded["time"], recorded["stops/force"][:, 0]
    least = np.minimum(0.5 * push, 0.5 * bears)
    assert (least < 0.5 * push - 0.1).any()
    np.testing.assert_allclose(-recorded["friction/force"][:, 0], least, atol=1e-7)
    np.testing.assert_allclose(-recorded["friction/force"][:, 2], push - least, atol=1e-7)


@pytest.mark.parametrize("steps", ["dop853", "rk4"])
@pytest.mark.parametrize("until", [0.13, 0.31])
def test_a_run_goes_on_with_the_bits_of_a_longer_one(steps, until):
    """While four feet slide, which share a load at will."""
    given = {"velocity": (1, 0.4, 0), "spin": (0, 0, 5), "steps": steps}
    whole, _ = simulated(box(CORNERS, "0.25", duration=0.5, **given))
    _, kept = simulated(box(CORNERS, "0.25", duration=until, **given))
    rest, _ = simulated(box(CORNERS, "0.25", duration=0.5, **given), kept[-1])
    after = whole["time"] > kept[-1]["t"]
    for path in ("time", *RECORDED):
        assert np.array_equal(rest[path], whole[path][after]), path
    assert rest.happened == whole.happened
