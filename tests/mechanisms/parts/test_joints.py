"""Every joint against an exact solution, fixed joints as one body, and the direction of x."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, mobility, read_scene_text, settings_to_run, simulate
from mbproj.base.errors import InputError
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.kinematics import pose_of
from mbproj.studies.variants import RigidMotion
from tests.crossed import crossed
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.closed_forms import swinging
from tests.support import Recorder, assembled

# Every joint beside the paper's four against an exact solution; a fixed joint as one body and as a constraint.

G = 9.81
HEAD = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 0.6, integrator: dop853, tolerance: 1e-12, output_step: 0.02}
"""
BODY = "{mass: 2, inertia: [0.3, 0.4, 0.5], position: [0, 0, 0]}"


def run(text: str, **simulation):
    scene = read_scene_text(HEAD + text, simulation=simulation)
    system, state = assembled(scene)
    recorder = Recorder()
    report = simulate(system, state, settings_to_run(scene), recorder)
    assert report.position_violation.value <= 1e-13
    assert report.velocity_violation.value <= 1e-12
    return recorder, system, state


def freedom(system, state) -> int:
    return mobility(system, pose_of(state.q)).degrees_of_freedom


def test_cylindrical_a_falling_turning_sleeve():
    record, system, state = run(f"""
bodies: {{sleeve: {BODY}}}
joints:
  J:
    type: cylindrical
    bodies: [ground, sleeve]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    speed: {{angle: 5, displacement: 1}}
""")
    t = record["time"]
    assert freedom(system, state) == 2
    assert system.names.coordinates == ("J.angle", "J.displacement")
    np.testing.assert_allclose(record["joints/coordinate"][:, 0], 5.0 * t, rtol=0, atol=1e-11)
    np.testing.assert_allclose(record["joints/coordinate"][:, 1], t - 0.5 * G * t**2, rtol=0, atol=1e-11)
    assert np.abs(record["joints/reaction_force"]).max() < 1e-10


def test_planar_a_puck_on_a_wall():
    """Sliding in the x-z plane under gravity while it spins: a parabola, and a reaction that stays zero."""
    record, system, state = run(f"""
bodies: {{puck: {BODY}}}
joints:
  J:
    type: planar
    bodies: [ground, puck]
    location: [0, 0, 0]
    axis: [0, 1, 0]
    speed: {{displacement_x: 2, displacement_y: 3, angle: -4}}
""")
    t = record["time"]
    assert freedom(system, state) == 3
    x = record["bodies/position"][:, 0]
    direction = x[1] / t[1] + np.array([0.0, 0.0, 0.5 * G * t[1]])  # the start: in-plane axes are the joint's own
    assert np.linalg.norm(direction) == pytest.approx(np.hypot(2.0, 3.0), rel=1e-10)
    np.testing.assert_allclose(x, direction * t[:, None] + [0, 0, -0.5 * G] * t[:, None] ** 2, rtol=0, atol=1e-11)
    np.testing.assert_allclose(record["joints/coordinate"][:, 2], -4.0 * t, rtol=0, atol=1e-11)


@pytest.mark.parametrize("joint", ["distance", "revolute_spherical"])
def test_a_massless_link_to_the_centre_of_mass_is_a_mathematical_pendulum(joint):
    axis = ", axis: [0, 1, 0]" if joint == "revolute_spherical" else ""
    record, system, state = run(f"""
bodies: {{bob: {{mass: 2, inertia: [0.3, 0.4, 0.5], position: [0.8, 0, 0]}}}}
joints:
  link: {{type: {joint}, bodies: [ground, bob], locations: [[0, 0, 0], [0.8, 0, 0]]{axis}}}
""")
    assert freedom(system, state) == {"distance": 5, "revolute_spherical": 4}[joint]
    angle = swinging(np.pi / 2, np.sqrt(G / 0.8), record["time"])[0]
    np.testing.assert_allclose(record["bodies/position"][:, 0, 0], 0.8 * np.sin(angle), rtol=0, atol=1e-10)
    np.testing.assert_allclose(record["bodies/position"][:, 0, 2], -0.8 * np.cos(angle), rtol=0, atol=1e-10)
    tension = 2.0 * G * 3.0 * np.cos(angle)  # m g cos φ + m v²/l from the energy
    force = np.linalg.norm(record["joints/reaction_force"][:, 0], axis=1)
    np.testing.assert_allclose(force, tension, rtol=0, atol=1e-8)


def test_a_link_keeps_its_offset_along_the_axis():
    """The spherical end 0.3 m off the plane of the pin stays there, and the body hangs on it out of its centre."""
    record, system, _ = run("""
bodies: {bob: {mass: 2, inertia: [0.3, 0.4, 0.5], position: [0.8, 0.5, 0.1]}}
joints:
  link: {type: revolute_spherical, bodies: [ground, bob], locations: [[0, 0, 0], [0.8, 0.3, 0]], axis: [0, 1, 0]}
markers: {end: {body: bob, location: [0.8, 0.3, 0]}}
""")
    end = record["markers/position"][:, 0]
    np.testing.assert_allclose(end[:, 1], 0.3, rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(end, axis=1), np.hypot(0.8, 0.3), rtol=0, atol=1e-12)
    assert system.joints.size == 2


def test_a_given_length_is_assembled():
    _, _, state = run("""
bodies: {bob: {mass: 2, inertia: [0.3, 0.4, 0.5], position: [0.8, 0, 0]}}
joints: {link: {type: distance, bodies: [ground, bob], locations: [[0, 0, 0], [0.8, 0, 0]], length: 90 cm}}
""")
    assert np.linalg.norm(state.q[:3]) == pytest.approx(0.9, abs=1e-13)


@pytest.mark.parametrize("joint", ["point_on_line", "point_in_plane"])
def test_a_bead_on_an_incline(joint):
    """Down a line or a plane at 30 degrees: s = ½ g sin 30° t²."""
    axis = {"point_on_line": "[sqrt(3), 0, -1]", "point_in_plane": "[1, 0, sqrt(3)]"}[joint]
    record, system, state = run(f"""
bodies: {{bead: {BODY}}}
joints:
  J: {{type: {joint}, bodies: [ground, bead], location: [0, 0, 0], axis: {axis}}}
""")
    assert freedom(system, state) == {"point_on_line": 4, "point_in_plane": 5}[joint]
    t = record["time"]
    travelled = record["bodies/position"][:, 0] @ [np.sqrt(0.75), 0, -0.5]
    np.testing.assert_allclose(travelled, 0.25 * G * t**2, rtol=0, atol=1e-11)
    force = np.linalg.norm(record["joints/reaction_force"][:, 0], axis=1)
    np.testing.assert_allclose(force, 2.0 * G * np.sqrt(0.75), rtol=0, atol=1e-9)


@pytest.mark.parametrize("pitch", [0.2, -0.05])
def test_a_nut_runs_down_a_screw(pitch):
    """(m + J (2π/p)²) s'' = -m g; it turns through many threads without losing count."""
    record, system, state = run(
        f"""
bodies: {{nut: {BODY}}}
joints: {{J: {{type: screw, bodies: [ground, nut], location: [0, 0, 0], axis: [0, 0, 1], pitch: {pitch}}}}}
""",
        duration=3.0,
        output_step=0.1,
    )
    assert freedom(system, state) == 1
    s = -0.5 * G * 2.0 / (2.0 + 0.5 * (2 * np.pi / pitch) ** 2) * record["time"] ** 2
    np.testing.assert_allclose(record["joints/coordinate"][:, 1], s, rtol=0, atol=1e-11)
    np.testing.assert_allclose(record["joints/coordinate"][:, 0], 2 * np.pi * s / pitch, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("teeth", "ratio"), [("[20, 40]", -0.5), ("[20, -50]", 0.4)])
def test_gears(teeth, ratio):
    """A wheel with an eccentric mass drives another: (J1 + r² J2 + m e²) φ'' = m g e cos φ, angles in the ratio r."""
    record, system, state = run(
        f"""
bodies:
  driver: {{mass: 2, inertia: [0.3, 0.4, 0.5], position: [0.1, 0, 0]}}
  wheel: {{mass: 3, inertia: [0.3, 0.7, 0.5], position: [1, 0, 0]}}
joints:
  A: {{type: revolute, bodies: [ground, driver], location: [0, 0, 0], axis: [0, 1, 0]}}
  B: {{type: revolute, bodies: [ground, wheel], location: [1, 0, 0], axis: [0, 1, 0]}}
  G: {{type: gear, joints: [A, B], teeth: {teeth}}}
""",
        duration=4.0,
        output_step=0.05,
    )
    assert freedom(system, state) == 1
    first, second = record["joints/coordinate"].T
    np.testing.assert_allclose(second, ratio * first, rtol=0, atol=1e-12)
    total = 0.4 + ratio**2 * 0.7 + 2.0 * 0.1**2
    swing = swinging(np.pi / 2, np.sqrt(G * 2.0 * 0.1 / total), record["time"])[0]
    np.testing.assert_allclose(np.cos(first), np.sin(swing), rtol=0, atol=1e-10)
    torque = record["joints/reaction_torque"][:, 2] @ [0, 1, 0]  # of the gear on the wheel
    expected = 0.7 * record["bodies/angular_acceleration"][:, 1] @ [0, 1, 0]
    np.testing.assert_allclose(torque, expected, rtol=0, atol=1e-9)


HAMMER = """
bodies:
  handle: {mass: 1, inertia: [0.001, 0.02, 0.02], position: [0.25, 0, 0]}
  head:
    mass: 3
    inertia: [0.004, 0.002, 0.003]
    position: [0.5, 0, 0.02]
    orientation: {axis: [1, 0, 0], angle: 30 deg}
joints:
  pin: {type: revolute, bodies: [ground, handle], location: [0, 0, 0], axis: [0, 1, 0]}
  weld: {type: fixed, bodies: [handle, head], location: [0.5, 0, 0]%s}
markers: {tip: {body: head, location: [0.55, 0, 0.02]}}
"""


def test_fixed_joints_make_one_body_of_two():
    record, system, state = run(HAMMER % "")
    assert (system.bodies, system.names.bodies, system.names.joints) == (1, ("handle", "head"), ("pin",))
    assert freedom(system, state) == 1
    asked, separate, _ = run(HAMMER % ", reaction: true")
    assert (separate.bodies, separate.names.joints) == (2, ("pin", "weld"))
    for path in (
        "bodies/position",
        "bodies/velocity",
        "bodies/acceleration",
        "bodies/angular_velocity",
        "bodies/angular_acceleration",
        "markers/position",
        "markers/acceleration",
    ):
        np.testing.assert_allclose(record[path], asked[path], rtol=0, atol=1e-8 * max(1.0, np.abs(asked[path]).max()))
    np.testing.assert_allclose(
        np.abs(np.sum(record["bodies/orientation"] * asked["bodies/orientation"], axis=-1)), 1.0, rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(record["diagnostics/total_energy"], asked["diagnostics/total_energy"], rtol=0, atol=1e-9)
    force = 3.0 * (asked["bodies/acceleration"][:, 1] + [0, 0, G])
    np.testing.assert_allclose(asked["joints/reaction_force"][:, 1], force, rtol=0, atol=1e-8)


def test_fixed_to_the_ground_is_ground():
    record, system, _ = run("""
bodies:
  post: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 1]}
  bob: {mass: 2, inertia: [0.3, 0.4, 0.5], position: [0.8, 0, 2]}
joints:
  base: {type: fixed, bodies: [ground, post], location: [0, 0, 0]}
  link: {type: distance, bodies: [post, bob], locations: [[0, 0, 2], [0.8, 0, 2]]}
""")
    assert system.bodies == 1
    np.testing.assert_array_equal(record["bodies/position"][:, 0], np.tile([0.0, 0, 1], (len(record["time"]), 1)))
    angle = swinging(np.pi / 2, np.sqrt(G / 0.8), record["time"])[0]
    np.testing.assert_allclose(record["bodies/position"][:, 1, 2], 2.0 - 0.8 * np.cos(angle), rtol=0, atol=1e-10)


def test_fixed_joints_bring_their_points_together():
    """Local points that the guess of the poses does not join: the second body is shifted onto the first."""
    scene = read_scene_text(
        HEAD
        + """
bodies:
  a: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}
  b: {mass: 3, inertia: [0.1, 0.1, 0.1], position: [9, 9, 9]}
joints: {weld: {type: fixed, bodies: [a, b], location: {a: [1, 0, 0], b: [0, -1, 0]}}}
"""
    )
    system = compile_system(scene)
    assert system.mass[0] == 4.0
    np.testing.assert_allclose(system.body_offset[1] - system.body_offset[0], [1, 1, 0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(initial_guess(scene, system).q[:3], [0.75, 0.75, 0], rtol=0, atol=1e-15)
    assert system.inertia[0, 2, 2] == pytest.approx(0.2 + 0.75 * 2.0)  # reduced mass × distance²


# Bodies that fixed joints make one, and those that stay two.

#: A pendulum in the plane normal to [0.6, 0, 0.8] of two bodies welded together, which a ball joins once more.
WELDED = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {{duration: 0.1, step: 2 ms, output_step: 20 ms, formulation: {formulation}}}
bodies:
  a: {{mass: 1, inertia: [0.1, 0.2, 0.15], position: [0.5, 0, 0]}}
  b: {{mass: 60, inertia: [9, 8, 7], position: [1, 0, 0.3], orientation: {{axis: [1, 2, 3], angle: 0.4}}}}
  c: {{mass: 2, inertia: [0.1, 0.2, 0.15], position: [0.2, 1, 0]}}
joints:
  slide: {{type: planar, bodies: [ground, a], location: [0.2, 0.1, 0.7], axis: [0.6, 0, 0.8]}}
  weld: {{type: fixed, bodies: [a, b], location: [0.7, 0, 0.1]}}
  end: {{type: fixed, bodies: [a, c], location: [0.7, 0, 0.1]}}
{ball}
"""
BALL = "  ball: {type: spherical, bodies: [%s, b], location: [0.83, -0.11, -0.87]}"


def run_grouped(formulation: str, ball: str) -> tuple[Recorder, int, int]:
    """What was recorded, bodies that move, and degrees of freedom."""
    scene, recorder = read_scene_text(WELDED.format(formulation=formulation, ball=ball)), Recorder()
    system = compile_system(scene)
    report = simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    return recorder, system.bodies, report.degrees_of_freedom


@needs_kernel
@crossed("end, formulation", ["a", "c"], ["full", "reduced", "planar"], dear=["full"])
def test_a_joint_across_a_weld_changes_nothing(formulation, end):
    """Its rows would hold one body to itself: the welded bodies stay apart, and the rows are redundant for good."""
    one, bodies, freedom = run_grouped(formulation, "")
    assert (bodies, freedom) == (1, 3)
    several, bodies, freedom = run_grouped(formulation, BALL % end)
    assert (bodies, freedom) == (3, 3)
    for path in ("bodies/position", "bodies/velocity", "bodies/acceleration"):
        np.testing.assert_allclose(several[path], one[path], rtol=0, atol=1e-11)


# The direction of a joint's x, which the scene may say: displacements along it, angles from it.

SPEED = "{displacement_x: 2, displacement_y: 0.5}"
X = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
Y = np.array([-1.0, 1.0, 0.0]) / np.sqrt(2.0)


def scene(kind: str, x_axis: str, rest: str = "", axis: str = "[0, 0, 3]"):
    return read_scene_text(
        f"""
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 1, step: 0.01}}
bodies: {{puck: {{mass: 1, inertia: [1, 1, 1], position: [0.2, 0.3, 0]}}}}
joints:
  table: {{type: {kind}, bodies: [ground, puck], location: LOCATION, axis: {axis}, x_axis: {x_axis}{rest}}}
""".replace("LOCATION", "{ground: [0, 0, 0], puck: [0, 0, 0]}" if "puck" in x_axis else "[0, 0, 0]")
    )


def started(of):
    return assembled(of)


@pytest.mark.parametrize("kind", ["planar", "point_in_plane"])
def test_displacements_are_along_the_direction_given_and_across_it(kind):
    _, state = started(scene(kind, "[2, 2, 7]", f", speed: {SPEED}"))
    velocity = state.v[:3] + np.cross(2.0 * state.v[4:7], [-0.2, -0.3, 0.0])  # Λ = (1, 0, 0, 0): ω is 2 (e₁', e₂', e₃')
    np.testing.assert_allclose(velocity, 2.0 * X + 0.5 * Y, atol=1e-14)


def test_a_scene_that_is_turned_takes_the_direction_along():
    turn = RigidMotion(np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]), np.array([1.0, 2.0, 3.0]))
    given = scene("planar", "[2, 2, 7]", f", speed: {{{SPEED[1:-1]}, angle: 0}}")
    np.testing.assert_allclose(started(turn.scene(given))[1].v[:3], turn.rotation @ started(given)[1].v[:3], atol=1e-14)


def test_an_angle_is_counted_between_the_directions_of_both_bodies():
    by_body = "{ground: [1, 0, 0], puck: [cos(30 deg), sin(30 deg), 0]}"
    system, state = started(scene("planar", by_body, axis="{ground: [0, 0, 1], puck: [0, 0, 1]}"))
    at = system.names.coordinates.index("table.angle")
    np.testing.assert_allclose(coordinate_values(system, pose_of(state.q))[at], np.radians(30.0), atol=1e-14)


def test_a_direction_along_the_axis_is_none():
    with pytest.raises(InputError, match="'x_axis' is along the axis; give a direction across it"):
        scene("planar", "[0, 0, -1]")
