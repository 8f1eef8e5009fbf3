"""A ball or a wheel on a stop with friction: it sticks as a joint rolls, and slides, lifts off and lands as well."""

import numpy as np
import pytest

import mbproj
from tests.crossed import crossed, full

BALL = """
mbproj: 1
gravity: [2, 0.7, -9.81]
simulation: {duration: 0.2, tolerance: 1.0e-11, integrator: dop853, output_step: 50 ms}
bodies:
  ball:
    mass: 2 kg
    inertia: [0.008, 0.008, 0.008]
    position: [0, 0, 0.1]
    velocity: [0.3, 0, 0]
    angular_velocity: [0, 3, 1]
"""
WHEEL = """
mbproj: 1
gravity: [3, 0, -9]
simulation: {duration: 0.3, tolerance: 1.0e-11, integrator: dop853, output_step: 50 ms}
bodies:
  ball: {mass: 2 kg, inertia: [0.008, 0.01, 0.008], position: [0, 0, 0.1]}
  rod: {mass: 1 kg, inertia: [0.01, 0.01, 0.01], position: [0.1, 0, 0.2]}
joints:
  plane: {type: planar, bodies: [ground, rod], location: [0.1, 0, 0.2], axis: [0, 1, 0]}
  pin: {type: revolute, bodies: [ball, rod], location: [0, 0, 0.1], axis: [0, 1, 0]}
"""
COIN = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.3, tolerance: 1.0e-11, integrator: dop853, output_step: 50 ms}
bodies:
  ball:
    mass: 1 kg
    inertia: [0.0225, 0.0225, 0.045]
    position: [1, 0, 0.3 * sin(75 deg)]
    orientation: {axis: [0, 1, 0], angle: 75 deg}
    velocity: [0, 1.3, 0]
    angular_velocity: [-1.3 * sin(75 deg), 0, 1.3 * cos(75 deg) - 4.7]
"""
PLANE = "plane: {location: [0, 0, 0], normal: [0, 0, 1]}"
AS_STOP = (
    "floor: {{type: stop, plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}, "
    "point: {{body: ball, location: {{ball: [0, 0, 0]}}}}, rigid: true, {}}}"
)
ROLLS = {
    "ball": (BALL, f"rolling_ball, bodies: [ground, ball], {PLANE}, centre: [0, 0, 0.1], radius: 0.1", "radius: 0.1"),
    "wheel": (
        WHEEL,
        f"rolling_wheel, bodies: [ground, ball], {PLANE}, centre: [0, 0, 0.1], axis: [0, 1, 0], radius: 0.1",
        "radius: 0.1, axis: [0, -1, 0]",
    ),
    "coin": (
        COIN,
        f"rolling_wheel, bodies: [ground, ball], {PLANE}, centre: [1, 0, 0.3 * sin(75 deg)], radius: 0.3, "
        "axis: [sin(75 deg), 0, cos(75 deg)]",
        "radius: 0.3, axis: {ball: [0, 0, 1]}",
    ),
}


def stopped(scene: str, given: str) -> str:
    return f"{scene}forces:\n  {AS_STOP.format(given)}\n"


def joined(scene: str, joint: str) -> str:
    return f"{scene}{'' if 'joints:' in scene else 'joints:'}\n  floor: {{type: {joint}}}\n"


def started_as(scene: str, results: mbproj.Results) -> str:
    """The scene with the velocities with which a run of a joint begins: they close its rows."""
    ball = results.body("ball")
    given = {"velocity": ball.velocity[0], "angular_velocity": ball.angular_velocity[0]}
    lines = [line for line in scene.splitlines() if line.split(":")[0].strip() not in given]
    at = lines.index("  ball:") + 1
    return "\n".join([*lines[:at], *(f"    {key}: {list(map(float, v))}" for key, v in given.items()), *lines[at:], ""])


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(
    ("name", "formulation"),
    [
        ("ball", "full"),
        ("ball", "reduced"),
        ("wheel", "reduced"),
        ("wheel", "planar"),
        full("coin", "full"),
        ("coin", "reduced"),
    ],
)
def test_what_sticks_moves_as_the_joint_rolls(name, formulation):
    scene, joint, given = ROLLS[name]
    until = 0.02 if formulation == "full" else 0.2
    rolls = mbproj.run(joined(scene, joint), formulation=formulation, duration=until, output_step=0.1 * until)
    scene = started_as(scene, rolls) if name == "coin" else scene
    sticks = mbproj.run(
        stopped(scene, f"{given}, friction: 0.9"), formulation=formulation, duration=until, output_step=0.1 * until
    )
    assert [event.kind for event in sticks.events] == ["contact"]
    for quantity in ("position", "angular_velocity"):
        apart = np.subtract(getattr(rolls.body("ball"), quantity), getattr(sticks.body("ball"), quantity))
        assert np.abs(apart).max() < 1e-11, quantity
    push = np.array(rolls.joint("floor").reaction_force)[:, 2]
    np.testing.assert_allclose(sticks.stop("floor").force, push, rtol=1e-9)


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
@pytest.mark.parametrize("law", ["rigid: true", "stiffness: 4e4"])
def test_a_wheel_rests_on_its_rim(law, formulation):
    """In the plane its centre once went down to the floor."""
    scene, _, given = ROLLS["wheel"]
    text = stopped(scene, given).replace("rigid: true", law)
    wheel = mbproj.run(text, formulation=formulation, duration=0.1, output_step=0.02)
    height = wheel.body("ball").position[:, 2]
    pressed = 0.0 if "rigid" in law else 2.0 * 27.0 / 4e4  # of a weight that is put down at once
    assert np.all(np.abs(height - 0.1) <= pressed + 1e-9)
    force = wheel.stop("floor").force
    touches = force > 0.0
    assert touches.sum() >= 3
    np.testing.assert_allclose(height[touches], 0.1 - (force[touches] / 4e4 if pressed else 0.0), atol=1e-12)


def test_a_ball_slides_until_it_rolls():
    """At 2 v/(7 μ g), with 5/7 of its speed (Coriolis 1835)."""
    scene = BALL.replace("[2, 0.7, -9.81]", "[0, 0, -9.81]").replace("[0, 3, 1]", "[0, 0, 0]")
    results = mbproj.run(stopped(scene, "radius: 0.1, friction: 0.2"))
    (stick,) = (event for event in results.events if event.kind == "stick")
    assert abs(stick.time - 2.0 * 0.3 / (7.0 * 0.2 * 9.81)) < 1e-12
    np.testing.assert_allclose(results.body("ball").velocity[-1], [0.3 * 5.0 / 7.0, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize(("friction", "left"), [(1.0, 0.3 * 5.0 / 7.0), (0.02, 0.3 - 0.02 * 1.5 * 1.0)])
def test_a_ball_that_bounces_takes_spin(friction, left):
    """It comes down at 1 m/s with e = 1/2: friction stops the slip, or gives all that the impulse lets it."""
    scene = BALL.replace("[2, 0.7, -9.81]", "[0, 0, 0]").replace("[0, 3, 1]", "[0, 0, 0]").replace("0, 0.1]", "0, 0.2]")
    scene = scene.replace("velocity: [0.3, 0, 0]", "velocity: [0.3, 0, -1]")
    results = mbproj.run(stopped(scene, f"radius: 0.1, restitution: 0.5, friction: {friction}"))
    ball = results.body("ball")
    np.testing.assert_allclose(ball.velocity[-1], [left, 0.0, 0.5], atol=1e-12)
    assert abs(0.008 * ball.angular_velocity[-1][1] - 0.1 * 2.0 * (0.3 - left)) < 1e-12


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("axis: [0, 1, 0]", "has an 'axis' and no 'radius'"),
        ("radius: 0.1, axis: {ground: [0, 1, 0]}", "has its axis on body 'ground'; the wheel is on body 'ball'"),
    ],
)
def test_what_no_wheel_is(given, said):
    with pytest.raises(mbproj.InputError, match=said):
        mbproj.run(stopped(BALL, given))


STRIBECK = "friction: {coefficient: 0.06, static: 0.09, stribeck_speed: 0.3}"
CHAIN = "".join(
    f"  b{k}: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [3, {0.2 * k + 0.1!r}, 0]}}\n" for k in range(8)
)
PINS = "".join(
    f"  p{k}: {{type: revolute, bodies: [{f'b{k - 1}' if k else 'ground'}, b{k}], location: [3, {0.2 * k!r}, 0], "
    "axis: [1, 0, 0]}\n"
    for k in range(8)
)


@crossed(
    "name, more, integrator",
    [
        pytest.param("ball", False),
        pytest.param("ball", True),
        pytest.param("wheel", False),
        pytest.param("coin", False),
    ],
    ["radau5", "esdirk4"],
    together=1,
)
def test_implicit_steps_take_the_slip_at_a_stop_as_a_force(name, more, integrator):
    """Its row comes after those of the joints: it once counted among them, and memory was written past its end."""
    scene, _, given = ROLLS[name]
    if more:
        scene = f"{scene}{CHAIN}joints:\n{PINS}"
    text = stopped(scene.replace("velocity: [0.3, 0, 0]", "velocity: [0.8, 0, 0]"), f"{given}, {STRIBECK}")
    explicit = mbproj.run(text, duration=0.1, tolerance=1e-9)
    implicit = mbproj.run(text, duration=0.1, tolerance=1e-7, integrator=integrator)
    assert explicit["friction/rate"][-1].any()
    np.testing.assert_allclose(implicit["bodies/position"], explicit["bodies/position"], rtol=0, atol=2e-6)
