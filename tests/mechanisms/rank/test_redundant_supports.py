"""What engineers draw, and what holds a body more often than it need: supports, frames, and an inline engine."""

from __future__ import annotations

from itertools import product
from math import comb

import numpy as np
import pytest
from scipy.special import binom, ellipj, ellipkinc

from mbproj.base.errors import InputError
from mbproj.base.registry import PROJECTIONS, integrators
from mbproj.scene.scene import read_scene_text
from tests.crossed import some, where
from tests.mechanisms.closed_forms import piston, swinging, time_to_reach
from tests.mechanisms.running import BRIEF, TIGHT, Run, assert_close, run, run_scene, run_text
from tests.support import ROOT

# What engineers draw, and what holds a body more often than it need: a door on two hinges, a table on four legs, planar
# loops of revolutes, side rods of a locomotive. The motion is unique, and so are some of the reactions.

COMPILED = [name for name, entry in PROJECTIONS.items() if entry.compiled]


#: A door that leans by 20°: its hinge line is x = z tan 20°, y = 0.
DOOR = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {lean: 20 deg, width: 0.8 m, low: 0.2 m, high: 1.8 m, start: 50 deg, mass: 30 kg, own: mass*width**2/12}
simulation: {duration: 2, step: 2 ms, output_step: 40 ms}
bodies:
  door:
    mass: mass
    inertia: [10 + own, 10, own]
    position:
      - sin(lean) + width/2 * cos(lean) * cos(start)
      - width/2 * sin(start)
      - cos(lean) - width/2 * sin(lean) * cos(start)
    orientation: {euler: [lean, start, 0], sequence: yzx}
joints:
  low: {type: revolute, bodies: [ground, door], location: [low*sin(lean), 0, low*cos(lean)], axis: AXIS, angle: 0 rad}
  high: {type: revolute, bodies: [ground, door], location: [high*sin(lean), 0, high*cos(lean)], axis: AXIS, speed: 0}
""".replace("AXIS", "[sin(lean), 0, cos(lean)]")


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", BRIEF))
def test_a_door_on_two_hinges_swings_as_a_pendulum(formulation):
    """(J + m a²) φ'' = -m g a sin(lean) sin φ, with a half the width and J about the door's own upright."""
    done = run_text(DOOR, **BRIEF[formulation], formulation=formulation)
    p = done.parameters
    arm, mass = p["width"] / 2, p["mass"]
    frequency = np.sqrt(mass * 9.81 * arm * np.sin(p["lean"]) / (p["own"] + mass * arm**2))
    φ, speed = swinging(p["start"], frequency, done["time"])
    for hinge in ("low", "high"):
        assert_close(p["start"] + done.column("joints/coordinate", f"{hinge}.angle"), φ, 1e-10)
        assert_close(done.column("joints/speed", f"{hinge}.angle"), speed, 1e-10)
    assert done.report.position_violation.value <= 2e-13


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", BRIEF))
def test_two_hinges_bear_the_door_together(formulation):
    """Their forces and torques balance its momentum, whichever share each of them has; both share alike along the axis,
    in the smallest reactions."""
    done = run_text(DOOR, **BRIEF[formulation], formulation=formulation)
    p, mass = done.parameters, done.parameters["mass"]
    force = sum(done.column("joints/reaction_force", hinge) for hinge in ("low", "high"))
    weight = mass * np.array([0.0, 0.0, -9.81])
    assert_close(force, mass * done.column("bodies/acceleration", "door") - weight, 1e-9)
    axis = np.array([np.sin(p["lean"]), 0.0, np.cos(p["lean"])])
    centre = done.column("bodies/position", "door")
    torque = sum(
        done.column("joints/reaction_torque", hinge)
        + np.cross(p[hinge] * axis - centre, done.column("joints/reaction_force", hinge))
        for hinge in ("low", "high")
    )
    A, inertia = done.rotation("door"), np.array(done.scene.bodies[0].inertia)
    ω, ω_dot = (done.column(f"bodies/{what}", "door") for what in ("angular_velocity", "angular_acceleration"))
    rate = ω_dot @ inertia + np.cross(ω, ω @ inertia)
    assert_close(torque, np.einsum("tij,tj->ti", A, rate), 1e-9)
    along = [done.column("joints/reaction_force", hinge) @ axis for hinge in ("low", "high")]
    assert_close(along[0], along[1], 1e-9)
    assert_close(along[0], mass * 9.81 * np.cos(p["lean"]) / 2, 1e-9)


def test_hinges_out_of_line_are_contradictory():
    """Two hinges on parallel lines 1 mm apart lock the door, and it stays where it is; on lines that do not close it is
    refused."""
    apart = DOOR.replace("location: [high*sin(lean), 0,", "location: [high*sin(lean), 1 mm,")
    locked = run_text(apart, duration=0.1, formulation="reduced")
    assert locked.report.degrees_of_freedom == 0
    assert_close(locked["bodies/position"], locked["bodies/position"][0], 1e-12)
    open_by = (
        "location: {ground: [high*sin(lean), 1 mm, high*cos(lean)], door: [-width/2, 0, high - 1]}, "
        "axis: {ground: [sin(lean), 0, cos(lean)], door: [0, 0, 1]}"
    )
    wrong = DOOR.replace("location: [high*sin(lean), 0, high*cos(lean)], axis: [sin(lean), 0, cos(lean)]", open_by)
    assert wrong != DOOR
    with pytest.raises(InputError, match=r"joint '(low|high)'"):
        run_text(wrong, duration=0.1)


#: A table that slides on ice, with its mass out of the middle.
TABLE = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {a: 0.6 m, b: 0.4 m, x: 0.2 m, y: -0.1 m, height: 0.7 m}
simulation: {duration: 1, step: 10 ms}
bodies:
  table: {mass: 20, inertia: [1, 2, 3], position: [0, 0, height], velocity: [1, 0.5, 0], angular_velocity: [0, 0, 2]}
joints:
  leg1: {type: point_in_plane, bodies: [ground, table], location: [a - x, b - y, 0], axis: [0, 0, 1]}
  leg2: {type: point_in_plane, bodies: [ground, table], location: [-a - x, b - y, 0], axis: [0, 0, 1]}
  leg3: {type: point_in_plane, bodies: [ground, table], location: [-a - x, -b - y, 0], axis: [0, 0, 1]}
  leg4: {type: point_in_plane, bodies: [ground, table], location: [a - x, -b - y, 0], axis: [0, 0, 1]}
"""


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", BRIEF))
def test_a_table_on_four_legs_slides_straight_and_turns_evenly(formulation):
    done = run_text(TABLE, formulation=formulation)
    t = done["time"]
    straight = np.stack([t, 0.5 * t, 0 * t + done.parameters["height"]], axis=1)
    assert_close(done.column("bodies/position", "table"), straight, 1e-12)
    A = done.rotation("table")
    assert_close(A[:, :2, 0], np.stack([np.cos(2 * t), np.sin(2 * t)], axis=1), 1e-9)
    assert done.report.degrees_of_freedom == 3


@pytest.mark.parametrize("formulation", BRIEF)
def test_four_legs_bear_the_smallest_forces_of_those_that_balance(formulation):
    """m g (1 + x x_k / a² + y y_k / b²) / 4 with legs at (x_k, y_k) = (± a, ± b) from the middle: without the pattern
    (1, -1, 1, -1), which balances nothing."""
    done = run_text(TABLE, formulation=formulation, duration=0.1)
    p = done.parameters
    exact = [
        20 * 9.81 / 4 * (1 + sx * p["x"] / p["a"] + sy * p["y"] / p["b"])
        for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1))
    ]
    force = np.stack([done.column("joints/reaction_force", f"leg{k}") for k in (1, 2, 3, 4)], axis=1)
    assert_close(force[..., 2], exact, 1e-9)
    assert_close(force[..., :2], 0.0, 1e-9)


#: The crank-rocker of the gallery as a loop of four revolutes.
REVOLUTES = (ROOT / "mechanisms" / "planar_four_bar.yaml").read_text(encoding="utf-8")
for old, new in {
    "B: {type: spherical, ": "B: {type: revolute, axis: [0, -1, 0], ",
    "type: universal": "type: revolute",
    "axes: [[-sin(tilt), 0, cos(tilt)], [0, 1, 0]]": "axis: [0, -1, 0]",
}.items():
    REVOLUTES = REVOLUTES.replace(old, new)


@pytest.fixture(scope="module")
def regular() -> Run:
    return run("planar_four_bar", **TIGHT, duration=0.5, output_step=0.02)


@pytest.mark.parametrize("formulation", where(lambda name: name != "full", BRIEF))
def test_four_revolutes_move_as_the_regular_loop_does(regular, formulation):
    """The same poses, speeds, accelerations and, in the plane, reactions."""
    settings = {**BRIEF[formulation], "output_step": 0.02, "duration": 0.5 if formulation != "full" else 0.1}
    if formulation == "full":
        settings["step"] = "5 ms"
    done = run_text(REVOLUTES, **settings, formulation=formulation)
    assert [joint.type for joint in done.scene.joints] == ["revolute"] * 4
    for path, tolerance in (("position", 1e-11), ("velocity", 1e-9), ("acceleration", 1e-7)):
        assert_close(done[f"bodies/{path}"], regular[f"bodies/{path}"][: len(done["time"])], tolerance)
    force = regular["joints/reaction_force"][: len(done["time"])]
    assert_close(done["joints/reaction_force"][..., [0, 2]], force[..., [0, 2]], 1e-7)


@pytest.mark.parametrize(
    ("method", "formulation"),
    [*some(product(PROJECTIONS, ["full"]), 3), *product(COMPILED, ["reduced", "planar"])],
)
def test_every_method_closes_the_redundant_rows(method, formulation):
    """Freudenstein's equation, to what the method leaves open."""
    if (method, formulation) == ("popm", "full"):
        with pytest.raises(InputError, match="'popm' needs a positive definite mass matrix"):
            run_text(REVOLUTES, duration=0.01, step="1 ms", projection=method, formulation=formulation)
        return
    duration = 0.1 if formulation != "full" else 0.02
    done = run_text(
        REVOLUTES,
        duration=duration,
        step="0.5 ms",
        integrator="rk4",
        output_step="2 ms",
        projection=method,
        formulation=formulation,
    )
    a, b, c, d = (done.parameters[name] for name in ("crank", "coupler", "rocker", "frame"))
    φ = done.parameters["start"] + done.column("joints/coordinate", "A.angle")
    χ = done.parameters["swing"] + done.column("joints/coordinate", "D.angle")
    k3 = (a * a - b * b + c * c + d * d) / (2 * a * c)
    closes = PROJECTIONS[method].corrects
    assert_close(d / a * np.cos(χ) - d / c * np.cos(φ) + k3, np.cos(φ - χ), 5e-12 if closes else 1e-8)
    assert done.report.position_violation.value <= (2e-13 if closes else 1e-8)
    assert done.report.energy_drift_relative < 1e-8


@pytest.mark.parametrize("formulation", ["reduced", "planar"])
def test_coupled_wheels_turn_alike_through_every_dead_centre(formulation):
    """As one pendulum that goes over, by Jacobi's am: (2 J + 2 m r²) θ'' = -√2 m g r cos(θ + 45°)."""
    done = run("locomotive", **TIGHT, output_step=0.02, formulation=formulation)
    rear, front = (done.column("joints/coordinate", f"{axle}_axle.angle") for axle in ("rear", "front"))
    assert rear[-1] > 4 * np.pi
    assert_close(front, rear, 1e-12)
    for rod in ("near_rod", "far_rod"):
        assert_close(done.rotation(rod), np.eye(3), 1e-12)
    assert_close(rear, over_the_top(done), 1e-9)
    assert done.report.energy_drift_relative < 1e-11


def over_the_top(done: Run) -> np.ndarray:
    """θ at the recorded times: with ψ = θ + 135° from the lowest pose, ψ'' = -ω0² sin ψ, and the energy for going
    round, ψ = 2 am(u0 + ω0 t / k, k²)."""
    p = done.parameters
    moment = 2 * p["wheel"] + 2 * p["rod"] * p["pin"] ** 2
    frequency = np.sqrt(np.sqrt(2) * p["rod"] * 9.81 * p["pin"] / moment)
    begin = np.radians(135.0)
    k = 2 * frequency / np.hypot(p["speed"], 2 * frequency * np.sin(begin / 2))
    return 2 * ellipj(ellipkinc(begin / 2, k * k) + frequency / k * done["time"], k * k)[3] - begin


@pytest.mark.parametrize("integrator", list(integrators()))
def test_every_integrator_takes_the_wheels_through_their_dead_centres(integrator):
    """With steps of 0.01 to 0.1 of a radian and phases that put one of the dead centres on a stage, or near it."""
    for step in ("2 ms", "(pi/200/6) s", "17 ms"):
        settings = {"step": step, "output_step": step, "duration": "1.7 s"}
        done = run("locomotive", integrator=integrator, formulation="planar", **settings)
        rear, front = (done.column("joints/coordinate", f"{axle}_axle.angle") for axle in ("rear", "front"))
        assert_close(front, rear, 1e-12)
        assert done.report.position_violation.value <= 2e-13


# The four-cylinder inline engine against the closed formulas of slider-cranks and of engine balancing.

PISTONS = [f"piston{k}" for k in (1, 2, 3, 4)]
#: Throws 2 and 3 are opposite to 1 and 4.
THROWS = np.array([0.0, np.pi, np.pi, 0.0])
GRAVITY = 9.81
FREE = (
    (ROOT / "mechanisms" / "inline_four.yaml")
    .read_text(encoding="utf-8")
    .replace("motions:\n  drive: {joint: main, angle: {constant_speed: speed}}\n", "")
)


@pytest.fixture(scope="module")
def driven() -> Run:
    """One turn at constant speed, in 120 steps."""
    return run("inline_four", step="(1/3) ms", duration="40 ms")


def angle(done: Run) -> np.ndarray:
    return done.parameters["start"] + done.parameters["speed"] * done["time"]


def points(done: Run) -> tuple[float, float]:
    """What a rod puts on the crank pin and on the piston pin, by its centre of mass."""
    p = done.parameters
    at_piston = p["rod_mass"] * p["rod_centre"] / p["rod"]
    return p["rod_mass"] - at_piston, at_piston


def reciprocating(done: Run) -> float:
    """m: a piston and its part of the rod."""
    return done.parameters["piston_mass"] + points(done)[1]


def ground_force(done: Run) -> np.ndarray:
    """The force on the ground (T, 3), from the reactions of all joints that bear on it."""
    joints = ["main", *(f"bore{k}" for k in (1, 2, 3, 4))]
    return -sum(done.column("joints/reaction_force", joint) for joint in joints)


def weight(done: Run) -> float:
    return GRAVITY * sum(body.mass for body in done.scene.bodies)


def series(ratio: float, order: int) -> float:
    """The coefficient a of cos(order θ) in -z'' / (r ω²), for an even order: from the binomial series of
    sqrt(1 - λ² sin² θ), in which sin^2k θ has cos 2jθ with 2 (-1)^j C(2k, k - j) / 4^k."""
    j = order // 2
    terms = (binom(0.5, k) * (-(ratio**2)) ** k * 2 * (-1) ** j * comb(2 * k, k - j) / 4**k for k in range(j, 40))
    return order**2 * sum(terms) / ratio


def harmonics(done: Run, values: np.ndarray) -> np.ndarray:
    """The coefficients a_k of Σ a_k cos kθ + b_k sin kθ as a_k - i b_k, from one turn in equal steps."""
    turned = 2.0 / (len(values) - 1) * np.fft.rfft(values[:-1])
    return turned * np.exp(-1j * np.arange(len(turned)) * done.parameters["start"])


def test_pistons_move_as_the_closed_formula_has_it(driven):
    speed = driven.parameters["speed"]
    for name, throw in zip(PISTONS, THROWS, strict=True):
        z, slope, bend = piston(driven, angle(driven) + throw)
        assert_close(driven.column("bodies/position", name)[:, 2], z, 1e-13)
        assert_close(driven.column("bodies/velocity", name)[:, 2], speed * slope, 1e-11)
        assert_close(driven.column("bodies/acceleration", name)[:, 2], speed**2 * bend, 1e-8)
        assert_close(driven.column("bodies/position", name)[:, 1], 0.0, 1e-13)
    assert driven.report.degrees_of_freedom == 0


def test_the_ground_feels_the_exact_inertia_forces(driven):
    """Weight and Σ -m z''; nothing across and nothing along the engine, and the rotating masses are balanced."""
    inertia = (
        -reciprocating(driven)
        * driven.parameters["speed"] ** 2
        * sum(piston(driven, angle(driven) + throw)[2] for throw in THROWS)
    )
    force = ground_force(driven)
    assert_close(force[:, 2] + weight(driven), inertia, 1e-7)
    assert_close(force[:, :2], 0.0, 1e-7)


def test_orders_of_balancing(driven):
    """The first order cancels; the second is 4 m r ω² (λ + λ³/4 + ..), the fourth follows; there are no odd ones."""
    p = driven.parameters
    ratio, scale = p["crank"] / p["rod"], 4.0 * reciprocating(driven) * p["crank"] * p["speed"] ** 2
    found = harmonics(driven, ground_force(driven)[:, 2]) / scale
    assert_close(np.abs(found[1:9:2]), 0.0, 1e-10)
    for order in (2, 4, 6):
        assert_close(found[order], series(ratio, order), 1e-10)
    assert found[2].real == pytest.approx(ratio + ratio**3 / 4 + 15 * ratio**5 / 128, rel=1e-4)
    assert found[4].real == pytest.approx(-(ratio**3) / 4 - 3 * ratio**5 / 16, rel=2e-2)
    single = harmonics(driven, driven.column("bodies/acceleration", "piston1")[:, 2]) / (p["crank"] * p["speed"] ** 2)
    assert_close(single[1], -1.0, 1e-10)


def test_the_driving_torque(driven):
    """Inertia and weight of the reciprocating masses at their lever dz/dθ; mostly -z'' z' of the second order."""
    p, m = driven.parameters, reciprocating(driven)
    torque = sum(
        m * (p["speed"] ** 2 * bend + GRAVITY) * slope
        for _, slope, bend in (piston(driven, angle(driven) + throw) for throw in THROWS)
    )
    assert_close(driven["motions/force"][:, 0], torque, 1e-7)
    second = harmonics(driven, driven["motions/force"][:, 0])[2] / (2.0 * m * p["crank"] ** 2 * p["speed"] ** 2)
    assert second.imag == pytest.approx(-1.0, rel=0.03)


def test_a_rod_of_another_moment_takes_another_torque_and_the_same_force(driven):
    """ΔJ ψ'' dψ/dθ for each rod, which leans by sin ψ = -λ sin θ."""
    p, extra = driven.parameters, 5.0e-4
    done = run("inline_four", {"rod_moment": p["rod_moment"] + extra}, step="(1/3) ms", duration="40 ms")
    assert_close(ground_force(done)[:, 2], ground_force(driven)[:, 2], 1e-7)
    theta, ratio = angle(done)[:, None] + THROWS, p["crank"] / p["rod"]
    root = np.sqrt(1.0 - ratio**2 * np.sin(theta) ** 2)
    slope = -ratio * np.cos(theta) / root
    bend = ratio * np.sin(theta) * (1.0 - ratio**2) / root**3
    torque = extra * p["speed"] ** 2 * np.sum(slope * bend, axis=1)
    assert_close(done["motions/force"][:, 0] - driven["motions/force"][:, 0], torque, 1e-7)
    assert np.abs(torque).max() > 1.0


@pytest.mark.parametrize("method", [name for name in PROJECTIONS if name not in ("popm", "gpopm")])
def test_every_method_drives_the_engine(method):
    done = run("inline_four", projection=method, duration="4 ms")
    z = piston(done, angle(done))[0]
    assert_close(done.column("bodies/position", "piston1")[:, 2], z, 4e-13 if PROJECTIONS[method].corrects else 1e-8)


def effective(done: Run, theta: float) -> tuple[float, float]:
    """Of the whole engine at θ: moment of inertia about the crank axis, and potential energy."""
    states = [piston(done, np.array(theta + throw)) for throw in THROWS]
    m, at_crank = reciprocating(done), points(done)[0]
    moment = done.parameters["flywheel"] + 4.0 * at_crank * done.parameters["crank"] ** 2
    moment += m * sum(float(slope) ** 2 for _, slope, _ in states)
    return moment, GRAVITY * m * sum(float(z) for z, _, _ in states)


def test_the_free_engine_turns_as_its_energy_says():
    """½ I(θ) θ'² + V(θ) stays; the time to an angle is a quadrature of that; the flywheel keeps it even."""
    options = {"integrator": "dop853", "tolerance": "1e-11", "duration": "50 ms", "output_step": "1 ms"}
    done = run_scene(read_scene_text(FREE, "free.yaml", {}, options))
    start, begin = done.parameters["start"], done.parameters["speed"]
    theta = start + done.column("joints/coordinate", "main.angle")
    speed = done.column("joints/speed", "main.angle")
    assert done.report.degrees_of_freedom == 1
    assert done.report.energy_drift_relative < 1e-10
    states = [effective(done, float(each)) for each in theta]
    energy = np.array([0.5 * moment * w**2 + v for (moment, v), w in zip(states, speed, strict=True)])
    assert_close(energy / energy[0], 1.0, 1e-10)
    moment, potential = (lambda at, k=k: effective(done, at)[k] for k in (0, 1))
    for row in (10, 50):
        assert time_to_reach(theta[row], start, begin, moment, potential) == pytest.approx(done["time"][row], abs=1e-10)
    assert 0.005 < np.ptp(speed) / begin < 0.05
