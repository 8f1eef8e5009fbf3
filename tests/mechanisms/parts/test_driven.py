"""Driven mechanisms: kinematics in closed form, driving forces by inverse dynamics, and the work that they do."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from mbproj import compile_system
from mbproj.base.registry import PROJECTIONS
from mbproj.equations.constraints import set_jacobian
from mbproj.equations.forces import applied
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.scene.scene import read_scene_text
from tests.crossed import once
from tests.mechanisms.running import Run, assert_close, run_scene

PENDULUM = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 1 s, step: 20 ms}
bodies:
  bar: {mass: 2 kg, inertia: [0.1, 0.3, 0.3], position: [0.5, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, -1, 0]}
motions:
"""


def run(text: str, **simulation: object) -> Run:
    return run_scene(read_scene_text(text, "f.yaml", {}, {key: str(value) for key, value in simulation.items()}))


def drive(function: str, **simulation: object) -> Run:
    """The pendulum with its angle driven by this."""
    return run(f"{PENDULUM}  m: {{joint: A, angle: {function}}}\n", **simulation)


def torque(angle: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """(J + m a²) φ'' + m g a cos φ, φ up from the horizontal."""
    return 0.8 * acceleration + 9.8 * np.cos(angle)


ROWS = "[[0, 0], [0.3, 0.5], [0.7, 0.2], [1, 1]]"
TABLE = np.array([[0, 0], [0.3, 0.5], [0.7, 0.2], [1, 1]]).T


def quintic(t: np.ndarray) -> list[np.ndarray]:
    """From 0.2 to 1 between 0.1 and 0.7 s: value, rate, acceleration."""
    x = np.clip((t - 0.1) / 0.6, 0.0, 1.0)
    first, second = 30 * x**2 * (1 - x) ** 2, 60 * x * (1 - x) * (1 - 2 * x)
    return [0.2 + 0.8 * (10 * x**3 - 15 * x**4 + 6 * x**5), 0.8 / 0.6 * first, 0.8 / 0.36 * second]


MOTIONS = {
    "{constant_speed: 60 rpm}": lambda t: [2 * np.pi * t, 2 * np.pi + 0 * t, 0 * t],
    "{harmonic: {amplitude: 20 deg, frequency: 1.5 Hz, phase: 90 deg, offset: 0.1}}": lambda t: [
        0.1 + np.pi / 9 * np.cos(3 * np.pi * t),
        -np.pi / 9 * 3 * np.pi * np.sin(3 * np.pi * t),
        -np.pi / 9 * (3 * np.pi) ** 2 * np.cos(3 * np.pi * t),
    ],
    "{polynomial: [0.1, 0, 3, -1]}": lambda t: [0.1 + 3 * t**2 - t**3, 6 * t - 3 * t**2, 6 - 6 * t],
    "{smooth_step: {from: 0.2, to: 1, start: 100 ms, duration: 0.6}}": quintic,
    f"{{table: {ROWS}}}": lambda t: [CubicSpline(*TABLE, bc_type="natural")(t, k) for k in range(3)],
    f"{{table: {{rows: {ROWS}, between: clamped}}}}": lambda t: [
        CubicSpline(*TABLE, bc_type="clamped")(t, k) for k in range(3)
    ],
    "{expression: 0.5*sin(3*t)*exp(-t)}": lambda t: [
        0.5 * np.exp(-t) * np.sin(3 * t),
        0.5 * np.exp(-t) * (3 * np.cos(3 * t) - np.sin(3 * t)),
        0.5 * np.exp(-t) * (-6 * np.cos(3 * t) - 8 * np.sin(3 * t)),
    ],
    "(40*t**2) deg": lambda t: [np.radians(40 * t**2), np.radians(80 * t), np.radians(80 + 0 * t)],
}


@pytest.mark.parametrize("function", MOTIONS)
def test_a_driven_pendulum(function):
    """No degree of freedom is left: the angle is prescribed, and the torque follows (inverse dynamics)."""
    done = drive(function)
    inner = slice(0, -1)  # at its last row a clamped table goes over into a line
    t = done["time"][inner]
    angle, speed, acceleration = MOTIONS[function](t)
    assert done.report.degrees_of_freedom == 0
    assert_close(done.column("joints/coordinate", "A.angle")[inner], angle, 1e-13)
    assert_close(done.column("joints/speed", "A.angle")[inner], speed, 1e-12)
    assert_close(-done.column("bodies/angular_acceleration", "bar")[inner, 1], acceleration, 1e-10)
    assert_close(done["motions/value"][inner, 0], angle, 1e-13)
    assert_close(done["motions/rate"][inner, 0], speed, 1e-13)
    assert_close(done["motions/force"][inner, 0], torque(angle, acceleration), 1e-10)
    assert done.report.position_violation.value <= 1e-13


@pytest.mark.parametrize(
    ("projection", "acceleration"),
    once([name for name in PROJECTIONS if name not in ("popm", "none")], ["bordered", "eliminated"]),
)
def test_every_method_drives(projection, acceleration):
    how = {"projection": projection, "acceleration": acceleration, "kinematic": "false"}
    done = drive("0.5*sin(3*t)", **how, step="2 ms", duration=0.1)
    t = done["time"]
    tolerance = {"baumgarte": 1e-9}.get(projection, 1e-12)
    assert_close(done.column("joints/coordinate", "A.angle"), 0.5 * np.sin(3 * t), tolerance)
    assert_close(done["motions/force"][:, 0], torque(0.5 * np.sin(3 * t), -4.5 * np.sin(3 * t)), 1e-5)


def test_without_projection_a_driven_angle_drifts_with_the_order():
    errors = []
    for step in (0.02, 0.01):
        done = drive("sin(3*t)", projection="none", step=step, kinematic="false")
        errors.append(np.abs(done.column("joints/coordinate", "A.angle") - np.sin(3 * done["time"])).max())
    assert 1e-12 < errors[1] < errors[0] / 14.0


def test_error_control_and_the_continuous_extension():
    text = PENDULUM.replace("step: 20 ms", "tolerance: 1e-8, integrator: dopri5, output_step: 7 ms")
    done = run(f"{text}  m: {{joint: A, angle: sin(3*t)}}\n")
    assert_close(done.column("joints/coordinate", "A.angle"), np.sin(3 * done["time"]), 1e-12)
    assert np.abs(done["diagnostics/energy_balance"]).max() < 1e-6


@pytest.mark.parametrize(("integrator", "order"), [("heun2", 2), ("rk4", 4), ("dopri5", 5)])
def test_the_work_of_a_motion_closes_the_balance(integrator, order):
    errors = []
    for step in (0.02, 0.01):
        done = drive("sin(3*t)", integrator=integrator, step=step, kinematic="false")
        errors.append(np.abs(done["diagnostics/energy_balance"]).max())
        energy = done["diagnostics/total_energy"]
        assert_close(done["diagnostics/work"], energy - energy[0], 1.01 * errors[-1])
    assert np.log2(errors[0] / errors[1]) > order - 0.6


SLIDER_CRANK = """\
mbproj: 1
gravity: [0, 0, 0]
parameters: {r: 0.1, l: 0.3}
simulation: {duration: 1 s, step: 10 ms}
bodies:
  crank: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}
  rod: {mass: 1e-9, inertia: [1e-12, 1e-11, 1e-11], position: [r + l/2, 0, 0]}
  slider: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [r + l, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1]}
  B: {type: spherical, bodies: [crank, rod], location: [r, 0, 0]}
  C: {type: universal, bodies: [rod, slider], location: [r + l, 0, 0], axes: [[0, 0, 1], [0, 1, 0]]}
  D: {type: prismatic, bodies: [ground, slider], location: [0, 0, 0], axis: [1, 0, 0]}
motions:
  speed: {joint: A, angle: {constant_speed: 10}}
"""


def test_a_slider_crank_at_constant_speed():
    """x = r cos φ + √(l² - r² sin² φ); what has mass and changes its speed is the slider: τ = m x'' dx/dφ."""
    done = run(SLIDER_CRANK)
    t, w, r, l = done["time"], 10.0, 0.1, 0.3
    sine, cosine = np.sin(w * t), np.cos(w * t)
    root = np.sqrt(l**2 - r**2 * sine**2)
    slope = -r * sine - r**2 * sine * cosine / root
    bend = -r * cosine - r**2 * (cosine**2 - sine**2) / root - r**4 * sine**2 * cosine**2 / root**3
    slider = done.column("bodies/position", "slider")[:, 0]
    assert done.report.degrees_of_freedom == 0
    assert_close(slider, r * cosine + root, 1e-13)
    assert_close(done.column("bodies/velocity", "slider")[:, 0], w * slope, 1e-11)
    assert_close(done.column("bodies/acceleration", "slider")[:, 0], w**2 * bend, 1e-8)
    assert_close(done["motions/force"][:, 0], 2.0 * w**2 * bend * slope, 1e-6)
    assert_close(done.column("joints/coordinate", "A.angle"), w * t, 1e-12)


SHAKEN = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1.5 s, step: 20 ms, integrator: dop853}
bodies:
  table: {mass: 3, inertia: [1, 1, 1], position: [0, 0, 0]}
  block: {mass: 2, inertia: [1, 1, 1], position: [0, 1, 0]}
joints:
  T: {type: prismatic, bodies: [ground, table], location: [0, 0, 0], axis: [1, 0, 0]}
  B: {type: prismatic, bodies: [table, block], location: [0, 1, 0], axis: [1, 0, 0], speed: 0}
forces:
  k: {type: linear_spring_damper, joint: B, stiffness: 72}
motions:
  shake: {joint: T, displacement: {harmonic: {amplitude: 0.1, frequency: 4}}}
"""


def test_a_block_on_a_shaken_table():
    """s'' + 36 s = 0.1 · 16 sin 4t: s = A (sin 4t - ⅔ sin 6t), A = 1.6/20; the driver moves both: F = 3 x'' - k s."""
    done = run(SHAKEN)
    t = done["time"]
    s = 0.08 * (np.sin(4 * t) - 2.0 / 3.0 * np.sin(6 * t))
    assert done.report.degrees_of_freedom == 1
    assert_close(done.column("joints/coordinate", "B.displacement"), s, 1e-10)
    assert_close(done["motions/force"][:, 0], -3.0 * 1.6 * np.sin(4 * t) - 72.0 * s, 1e-8)
    assert_close(done["diagnostics/energy_balance"], 0.0, 1e-10)
    assert done.system.names.motion_units == ("m",)


ARM = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 0.5 s, step: 10 ms, integrator: dop853}
bodies:
  upper: {mass: 2, inertia: [0.1, 0.2, 0.25], position: [0.5, 0, 0]}
  lower: {mass: 1, inertia: [0.1, 0.15, 0.12], position: [1.5, 0.2, 0]}
joints:
  A: {type: cylindrical, bodies: [ground, upper], location: [0, 0, 0], axis: [0, 1, 0]}
  U: {type: universal, bodies: [upper, lower], location: [1, 0, 0], axes: [[0, 1, 0], [0, 0, 1]]}
"""
PATHS = {
    "a": "{joint: A, angle: sin(2*t)}",
    "b": "{joint: A, displacement: 0.3*t**2}",
    "c": "{joint: U, angle_1: 0.5*t**3}",
    "d": "{joint: U, angle_2: 1 - cos(3*t)}",
}


def test_forward_dynamics_with_the_torque_of_inverse_dynamics():
    """A torque on the joint, of the size that driving it takes, gives the driven motion without the motion."""
    angle, bend = "(0.5*sin(3*t))", "(-4.5*sin(3*t))"
    found = f"0.8*{bend} + 9.8*cos({angle})"
    text = PENDULUM.replace("axis: [0, -1, 0]}", "axis: [0, -1, 0], speed: 1.5}").replace("motions:", "forces:")
    done = run(f"{text}  m: {{type: torsion_spring_damper, joint: A, torque: {found}}}\n", integrator="dop853")
    assert_close(done.column("joints/coordinate", "A.angle"), 0.5 * np.sin(3 * done["time"]), 1e-9)


def test_all_coordinates_of_an_arm_driven_at_once():
    """A spatial arm without freedom follows its four functions, and the four drivers do the work that moves it."""
    done = run(ARM + "motions:\n" + "".join(f"  {name}: {path}\n" for name, path in PATHS.items()))
    t = done["time"]
    exact = np.stack([np.sin(2 * t), 0.3 * t**2, 0.5 * t**3, 1 - np.cos(3 * t)], axis=1)
    assert done.report.degrees_of_freedom == 0
    assert_close(done["joints/coordinate"], exact, 1e-12)
    power = np.sum(done["motions/force"] * done["motions/rate"], axis=1)
    energy = done["diagnostics/total_energy"]
    rate = (8 * (energy[3:-1] - energy[1:-3]) - (energy[4:] - energy[:-4])) / (12 * 0.01)
    np.testing.assert_allclose(power[2:-2], rate, atol=1e-4)
    assert_close(done["diagnostics/energy_balance"], 0.0, 1e-10 * np.ptp(energy))


def test_some_driven_some_free():
    done = run(ARM + f"motions:\n  b: {PATHS['b']}\n  d: {PATHS['d']}\n")
    assert done.report.degrees_of_freedom == 2
    t = done["time"]
    assert_close(done.column("joints/coordinate", "U.angle_2"), 1 - np.cos(3 * t), 1e-12)
    assert_close(done.column("joints/coordinate", "A.displacement"), 0.3 * t**2, 1e-12)
    assert_close(done["diagnostics/energy_balance"], 0.0, 1e-9)


def test_constant_speed_counts_from_where_the_joint_starts():
    text = PENDULUM.replace("axis: [0, -1, 0]}", "axis: [0, -1, 0], angle: 400 deg}")
    done = run(f"{text}  m: {{joint: A, angle: {{constant_speed: 100}}}}\n", duration=0.5)
    assert_close(done.column("joints/coordinate", "A.angle"), np.radians(400) + 100 * done["time"], 1e-11)
    assert_close(done["motions/value"][:, 0], np.radians(400) + 100 * done["time"], 1e-11)


def test_reactions_of_a_driven_joint_leave_its_driving_torque_to_the_motion():
    """The pin takes no torque about its axis; it carries the weight and the centripetal force."""
    done = drive("{constant_speed: 5}")
    assert np.abs(done["joints/reaction_torque"][:, 0, 1]).max() < 1e-11
    angle = 5 * done["time"]
    exact = np.stack([-25.0 * np.cos(angle), 0 * angle, 19.6 - 25.0 * np.sin(angle)], axis=1)
    assert_close(done["joints/reaction_force"][:, 0], exact, 1e-11)


LOADED = """\
forces:
  k: {type: spring_damper, points: {ground: [1, 0, 1], lower: [1.5, 0.5, 0]}, stiffness: 50, damping: 2}
  c: {type: friction, joint: A, coefficient: {angle: 0.3, displacement: 4}}
  f: {type: force, body: lower, location: [2, 0, 0], force: [3*t, 1, 0], axes: body}
"""


def test_newton_with_reactions_forces_and_driving_forces():
    """m a = m g + reactions + forces + driving forces for each body of a loaded and partly driven arm."""
    done = run(f"{ARM}{LOADED}motions:\n  b: {PATHS['b']}\n  d: {PATHS['d']}\n", duration=0.1)
    system, last = done.system, -1
    q = np.concatenate([done["bodies/position"][last], done["bodies/orientation"][last]], axis=1).ravel()
    pose = pose_of(q)
    rate = 0.5 * np.einsum("nij,ni->nj", pose.L[:-1], done["bodies/angular_velocity"][last])
    twist = twist_of(pose, np.concatenate([done["bodies/velocity"][last], rate], axis=1).ravel())
    loads = applied(Instant(system, pose, twist, float(done["time"][last]), done["joints/coordinate"][last])).force[:-1]
    along = set_jacobian(system.rows, pose)[system.joints.size :].reshape(-1, 2, 7)[..., :3]
    driving = np.einsum("k,kni->ni", done["motions/force"][last], along)
    reaction = done["joints/reaction_force"][last]
    total = loads + driving + np.array([reaction[0] - reaction[1], reaction[1]])
    mass = system.mass[:, None]
    np.testing.assert_allclose(mass * (done["bodies/acceleration"][last] - system.gravity), total, atol=1e-9)
    assert np.abs(loads).max() > 1.0
    assert np.abs(driving).max() > 1.0


def test_only_scenes_with_forces_or_motions_integrate_work():
    for text, integrals in ((PENDULUM.replace("motions:\n", ""), 0), (f"{PENDULUM}  m: {{joint: A, angle: t}}\n", 2)):
        scene = read_scene_text(text)
        system = compile_system(scene)
        assert system.integrated.size_of("quadratures") == integrals
