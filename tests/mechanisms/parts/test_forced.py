"""Forces against exact solutions, the balance of energy, and dampers of rotation."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.registry import implicit_integrators, integrators
from mbproj.scene.scene import read_scene_text
from tests.crossed import full
from tests.kernel.scenes import needs_kernel
from tests.mechanisms.running import Run, assert_close, run_scene

# Forces against exact solutions, and the balance of energy, which closes with the order of the integrator.

BLOCK = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, step: 20 ms, integrator: dop853}
bodies:
  block: {mass: 2 kg, inertia: [1, 1, 1], position: [0.3, 0, 0]}
joints:
  D: {type: prismatic, bodies: [ground, block], location: [0, 0, 0], axis: [1, 0, 0]}
forces:
"""
WHEEL = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, step: 10 ms, integrator: dop853}
bodies:
  wheel: {mass: 2 kg, inertia: [1, 1.2, 0.5], position: [0, 2, 0]}
joints:
  A: {type: revolute, bodies: [ground, wheel], location: [0, 2, 0], axis: [0, 0, 1]}
forces:
"""


def run(text: str, **simulation: object) -> Run:
    return run_scene(read_scene_text(text, "f.yaml", {}, {key: str(value) for key, value in simulation.items()}))


def damped(t: np.ndarray, m: float, c: float, k: float, x0: float, v0: float) -> np.ndarray:
    """m x'' + c x' + k x = 0."""
    decay, rate = c / (2 * m), np.sqrt(k / m - (c / (2 * m)) ** 2)
    return np.exp(-decay * t) * (x0 * np.cos(rate * t) + (v0 + decay * x0) / rate * np.sin(rate * t))


SPRINGS = {
    "points": "k: {type: spring_damper, points: {ground: [-1, 0, 0], block: [0, 0, 0]}, "
    "stiffness: 200 N/m, damping: 3 N*s/m, free_length: 0.9}",
    "joint": "k: {type: linear_spring_damper, joint: D, stiffness: 0.2 N/mm, damping: 3, free_displacement: -10 cm}",
    "expression": "k: {type: linear_spring_damper, joint: D, force: -200*(displacement + 0.1) - 3*displacement_dot}",
    "of the length": "k: {type: spring_damper, points: {ground: [-1, 0, 0], block: [0, 0, 0]}, "
    "force: -200*(l - 90 cm) - 3*l_dot}",
    "table": "k: {type: linear_spring_damper, joint: D, table: [[-1, 180], [1, -220]], damping: 3}",
}


@pytest.mark.parametrize("way", SPRINGS)
def test_a_damped_oscillator(way):
    done = run(f"{BLOCK}  {SPRINGS[way]}\n")
    t = done["time"]
    exact = -0.1 + damped(t, 2.0, 3.0, 200.0, 0.1, 0.0)
    assert_close(done.column("joints/coordinate", "D.displacement"), exact, 1e-9)
    assert np.abs(done["diagnostics/energy_balance"]).max() < 1e-9
    assert done.system.names.forces == ("k",)
    rate = done.column("joints/speed", "D.displacement")
    np.testing.assert_allclose(done["forces/force"][:, 0], -200.0 * (exact + 0.1) - 3.0 * rate, atol=1e-6)


def test_where_the_energy_goes():
    """A damper dissipates, a function does work, a spring keeps its energy; the balance is the same."""
    one, other = (run(f"{BLOCK}  {SPRINGS[way]}\n") for way in ("joint", "expression"))
    for done in (one, other):
        assert np.abs(done["diagnostics/energy_balance"]).max() < 1e-9
    potential = 100.0 * (one.column("joints/coordinate", "D.displacement") + 0.1) ** 2
    assert_close(one["diagnostics/potential_energy"], potential, 1e-12)
    assert_close(other["diagnostics/potential_energy"], 0.0, 0.0)
    assert_close(one["diagnostics/work"], 0.0, 0.0)
    assert_close(other["diagnostics/dissipation"], 0.0, 0.0)
    lost = -other["diagnostics/work"] + potential[0] - potential
    assert_close(one["diagnostics/dissipation"], lost, 1e-7)
    assert np.all(np.diff(one["diagnostics/dissipation"]) > 0.0)


def test_a_torsion_pendulum_has_its_period_whatever_it_is_wound_up_to():
    """0.5 φ'' = -8 φ: φ0 cos 4t, here from two and a half turns."""
    wound = WHEEL.replace("axis: [0, 0, 1]}", "axis: [0, 0, 1], angle: 900 deg}")
    done = run(wound + "  k: {type: torsion_spring_damper, joint: A, stiffness: 8}\n")
    angle = 5 * np.pi * np.cos(4.0 * done["time"])
    assert_close(done.column("joints/coordinate", "A.angle"), angle, 2e-6)
    assert_close(done["forces/coordinate"][:, 0], angle, 2e-6)
    assert_close(done["diagnostics/energy_balance"], 0.0, 5e-5)


def test_friction_slows_exponentially():
    spinning = WHEEL.replace("axis: [0, 0, 1]}", "axis: [0, 0, 1], speed: 30}")
    done = run(spinning + "  f: {type: friction, joint: A, coefficient: 1.5}\n")
    exact = 30.0 * np.exp(-3.0 * done["time"])
    assert_close(done.column("joints/speed", "A.angle"), exact, 1e-7)
    assert_close(done["diagnostics/dissipation"], 0.25 * (900.0 - exact**2), 1e-5)
    assert_close(done["diagnostics/energy_balance"], 0.0, 1e-7)


def test_friction_of_several_coordinates():
    """On a cylindrical joint each coordinate slows on its own."""
    text = WHEEL.replace("type: revolute", "type: cylindrical").replace(
        "axis: [0, 0, 1]}", "axis: [0, 0, 1], speed: {angle: 30, displacement: 2}}"
    )
    done = run(text + "  f: {type: friction, joint: A, coefficient: {angle: 1.5, displacement: 3}}\n")
    t = done["time"]
    assert done.system.names.forces == ("f.angle", "f.displacement")
    assert_close(done["joints/speed"], np.stack([30 * np.exp(-3 * t), 2 * np.exp(-1.5 * t)], axis=1), 1e-7)


FREE = """\
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 1 s, step: 20 ms, integrator: dop853}
bodies:
  ball: {mass: 2 kg, inertia: [0.4, 0.4, 0.4], position: [0, 0, 0], angular_velocity: [0, 0, 3]}
  other: {mass: 1 kg, inertia: [0.1, 0.2, 0.15], position: [1, 0.5, 0]}
forces:
"""


def test_a_constant_force_and_one_of_time():
    forces = "  c: {type: force, body: ball, force: [4, 0, -6]}\n  t: {type: force, body: ball, force: [0, 12*t, 0]}\n"
    done = run(FREE + forces)
    t = done["time"]
    exact = np.stack([t**2, t**3, -1.5 * t**2], axis=1)
    assert_close(done.column("bodies/position", "ball"), exact, 1e-12)
    assert_close(done["diagnostics/work"], 4 * t**2 + 9 * t**4 + 9 * t**2, 1e-11)


def test_a_force_in_body_axes_turns_with_the_body():
    """2 x'' = 4 (cos 3t, sin 3t): the ball spins at 3 rad/s."""
    done = run(FREE + "  f: {type: force, body: ball, force: [4, 0, 0], axes: body}\n")
    t = done["time"]
    exact = 2.0 * np.stack([(1 - np.cos(3 * t)) / 9, (3 * t - np.sin(3 * t)) / 9, 0 * t], axis=1)
    assert_close(done.column("bodies/position", "ball"), exact, 1e-9)


def test_a_force_off_the_centre_turns_and_a_torque_does_so_alone():
    """About z: 0.4 ω' = x f_y, and 0.4 ω' = τ."""
    off = FREE.replace(", angular_velocity: [0, 0, 3]", "")
    push = "  f: {type: force, body: ball, location: [0.5, 0, 0], force: [0, 0.8, 0], axes: body}\n"
    turn = "  f: {type: torque, body: ball, torque: [0, 0, 0.4]}\n"
    for forces in (push, turn):
        done = run(off + forces)
        assert_close(done.column("bodies/angular_velocity", "ball")[:, 2], done["time"], 1e-9)
    assert_close(done.column("bodies/position", "ball"), 0.0, 0.0)


def test_internal_forces_leave_momentum_alone():
    """Linear and angular momentum of two free bodies, and both are moved."""
    points = "points: {ball: [0, 0.2, 0.1], other: [1, 0.6, 0]}"
    done = run(f"{FREE}  k: {{type: spring_damper, {points}, stiffness: 10, damping: 0.5, free_length: 0.8}}\n")
    mass = np.array([2.0, 1.0])
    linear = np.einsum("b,tbi->ti", mass, done["bodies/velocity"])
    assert_close(linear, 0.0, 1e-12)
    angular = np.einsum("b,tbi->ti", mass, np.cross(done["bodies/position"], done["bodies/velocity"]))
    for body in done.scene.bodies:
        spin = done.column("bodies/angular_velocity", body.name) @ np.array(body.inertia)
        angular += np.einsum("tij,tj->ti", done.rotation(body.name), spin)
    assert_close(angular, [0.0, 0.0, 1.2], 1e-7)
    assert np.abs(done["bodies/velocity"]).max() > 0.3
    assert np.abs(done["diagnostics/energy_balance"]).max() < 1e-6


EVERYTHING = """\
mbproj: 1
gravity: [0, 0, -9.8]
simulation: {duration: 0.4 s, step: 10 ms}
bodies:
  upper: {mass: 2, inertia: [0.1, 0.2, 0.25], position: [0.5, 0, 0]}
  lower: {mass: 1, inertia: [0.1, 0.15, 0.12], position: [1.5, 0.2, 0]}
joints:
  A: {type: revolute, bodies: [ground, upper], location: [0, 0, 0], axis: [0, 1, 0]}
  U: {type: universal, bodies: [upper, lower], location: [1, 0, 0], axes: [[0, 1, 0], [0, 0, 1]]}
forces:
  k: {type: spring_damper, points: {ground: [1, 0, 1], lower: [1.5, 0.5, 0]}, stiffness: 50, damping: 2}
  n: {type: spring_damper, points: {ground: [0, 1, 1], upper: [1, 0, 0]}, force: 5*sin(3*t)/l - l_dot}
  c: {type: friction, joint: U, coefficient: {angle_1: 0.1, angle_2: 0.2}}
  t: {type: torsion_spring_damper, joint: A, table: [[-2, 3], [0, 0], [1, -2], [3, -9]], damping: 0.2}
  f: {type: force, body: lower, location: [2, 0, 0], force: [3*t, 1, 0], axes: body}
"""


@pytest.mark.parametrize("name", list(integrators()))
def test_the_balance_closes_with_the_order_of_the_integrator(name):
    order = integrators()[name].order
    # Of small errors the knots of the table, which fixed steps pass over, would be a large part.
    steps = (0.04, 0.02) if order > 5 else (0.02, 0.01) if integrators()[name].implicit else (0.01, 0.005)
    errors = [np.abs(run(EVERYTHING, integrator=name, step=step)["diagnostics/energy_balance"]).max() for step in steps]
    assert np.log2(errors[0] / errors[1]) > order - 0.6
    assert errors[1] < 1e-3


@pytest.mark.parametrize("projection", ["none", "gopm", "mmopm", "mass-orthogonal"])
def test_every_projection_keeps_the_balance(projection):
    done = run(EVERYTHING, projection=projection, step=0.002, duration=0.1)
    assert np.abs(done["diagnostics/energy_balance"]).max() < 1e-6


def test_the_eliminated_equations_have_the_same_forces():
    one, other = (run(EVERYTHING, acceleration=kind, duration=0.1) for kind in ("bordered", "eliminated"))
    np.testing.assert_allclose(one["bodies/acceleration"], other["bodies/acceleration"], atol=1e-8)


def test_error_control_steps_as_the_forces_ask():
    text = BLOCK.replace("step: 20 ms, integrator: dop853", "tolerance: 1e-9, integrator: dopri5, output_step: 0.01")
    done = run(f"{text}  {SPRINGS['expression']}\n")
    exact = -0.1 + damped(done["time"], 2.0, 3.0, 200.0, 0.1, 0.0)
    assert_close(done.column("joints/coordinate", "D.displacement"), exact, 1e-7)
    assert np.abs(done["diagnostics/energy_balance"]).max() < 1e-6


# Dampers of rotation resist the relative angular velocity however far the bodies have turned, as closed forms say.

#: N m s/rad; about the axes across the figure's and about that, kg m².
DAMPING, ACROSS, ABOUT = 0.02, 0.05, 0.08
SPIN = np.array([3.0, -1.0, 20.0])

#: A top without weight whose frame stands 2 rad apart from the ground's at the start; it turns three times round.
TOP = f"""
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 1, step: 0.01}}
bodies:
  top:
    mass: 1
    inertia: [{ACROSS}, {ACROSS}, {ABOUT}]
    position: [0, 0, 0]
    angular_velocity: {SPIN.tolist()}
    orientation: {{axis: [1, 2, -1], angle: 2 rad}}
joints:
  ball: {{type: spherical, bodies: [ground, top], location: [0, 0, 0]}}
forces:
  oil:
    type: bushing
    bodies: [ground, top]
    location: [0, 0, 0]
    axes: {{ground: {{quaternion: [1, 0, 0, 0]}}, top: {{quaternion: [1, 0, 0, 0]}}}}
    damping: {{rotation: [{DAMPING}, {DAMPING}, {DAMPING}]}}
"""


def angular_velocity(t):
    """Of the top in its axes: c acts on ω, so that each part dies out on its own, and the part across goes round."""
    about = SPIN[2] * np.exp(-DAMPING * t / ABOUT)
    turned = (ABOUT - ACROSS) / ACROSS * SPIN[2] * ABOUT / DAMPING * (1.0 - np.exp(-DAMPING * t / ABOUT))
    across = (SPIN[0] + 1j * SPIN[1]) * np.exp(-DAMPING * t / ACROSS + 1j * turned)
    return np.stack([across.real, across.imag, about], axis=-1)


def top(text=TOP, **settings):
    return run_scene(read_scene_text(text, "s.yaml", {}, settings))


@needs_kernel
@pytest.mark.parametrize("formulation", ["reduced", full("full")])
def test_a_top_in_oil(formulation):
    """Its angular velocity and what is lost, over half a turn too: nothing there depends on where the frames are."""
    accuracy = {"step": 0.01} if formulation == "full" else {"tolerance": 1e-12}
    done = top(formulation=formulation, integrator="dop853", **accuracy)
    expected = angular_velocity(done["time"])
    np.testing.assert_allclose(done["bodies/angular_velocity"][:, 0], expected, rtol=0, atol=1e-9)
    assert np.linalg.norm(done["forces/coordinate"][:, 3:], axis=1).max() > 3.1
    energy = 0.5 * expected**2 @ [ACROSS, ACROSS, ABOUT]
    np.testing.assert_allclose(done["diagnostics/dissipation"], energy[0] - energy, rtol=0, atol=1e-9 * energy[0])


@needs_kernel
@pytest.mark.parametrize("integrator", implicit_integrators())
def test_orders_of_implicit_steps(integrator):
    errors = []
    for count in (40, 80, 160):
        done = top(integrator=integrator, step=1.0 / count, output_step=1.0, formulation="reduced")
        errors.append(np.abs(done["bodies/angular_velocity"][-1, 0] - angular_velocity(1.0)).max())
    assert np.log2(errors[0] / errors[-1]) / 2 > integrators()[integrator].order - 0.3


#: A weight on an arm of 1 m in thick oil: its own inertia counts for 1e-7 only.
CREEPING = """
mbproj: 1
gravity: [0, 0, -10]
bodies:
  bob: {mass: 1, inertia: [0.1, 0.2, 0.15], position: [0.6, 0, 0.8]}
joints:
  ball: {type: spherical, bodies: [ground, bob], location: [0, 0, 0]}
forces:
  oil:
    type: bushing
    bodies: [ground, bob]
    location: [0, 0, 0]
    axes: {ground: {axis: [1, 2, 1], angle: 2.5 rad}, bob: {quaternion: [1, 0, 0, 0]}}
    damping: {rotation: [1.0e4, 1.0e4, 1.0e4]}
"""


@needs_kernel
@pytest.mark.parametrize("formulation", ["reduced", full("full")])
@pytest.mark.parametrize("integrator", implicit_integrators())
def test_thick_oil_takes_few_steps(integrator, formulation):
    """c θ' = m g l sin θ of the angle from where it hangs: tan(θ/2) dies out with c/(m g l) = 1000 s, c/I = 1e4 1/s."""
    keys = {"integrator": integrator, "formulation": formulation, "duration": 2000.0, "output_step": 2000.0}
    scene = read_scene_text(CREEPING, "s.yaml", {}, {**keys, "tolerance": 1e-7})
    done = run_scene(scene)
    start, end = done["bodies/position"][[0, -1], 0]
    θ = np.arctan2(np.hypot(*end[:2]), -end[2])
    expected = np.tan(0.5 * np.arctan2(np.hypot(*start[:2]), -start[2])) * np.exp(-2.0)
    assert np.tan(0.5 * θ) == pytest.approx(expected, rel=1e-5)
    assert done.report.counters["steps"] < 200
