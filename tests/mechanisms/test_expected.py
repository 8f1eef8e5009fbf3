"""The numbers in the `expect` blocks of mechanisms/*.yaml, against formulas and tables: none is mbproj's own."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.mechanisms.closed_forms import (
    Linkage,
    bare,
    bennett_poses,
    bricard_poses,
    expected,
    physical_angle,
    piston,
    planar_energy,
    planar_pose,
    racket_rates,
    reached_at,
    scene,
    spatial_energy,
    spatial_pose,
)
from tests.mechanisms.closed_forms import energy as hooke_energy
from tests.mechanisms.running import assert_close
from tests.support import DATA, MECHANISMS


def table(name: str, time: float) -> np.void:
    rows = np.genfromtxt(DATA / f"{name}.csv", delimiter=",", names=True)
    (row,) = rows[np.abs(rows["t"] - time) < 1e-12]
    return row


def test_physical_pendulum_by_jacobis_function():
    φ = physical_angle(np.array([5.0]))[0]
    assert_close(expected("physical_pendulum", "end"), [np.sin(φ), 0.0, -np.cos(φ)], 1e-11)


@pytest.mark.parametrize("time", [3, 5])
def test_five_bar_by_its_table(time):
    row = table("five_bar", time)
    assert_close(expected("five_bar", f"tip_at_{time}_s"), [row["tip_x"], 0.0, row["tip_z"]], 1e-14)


@pytest.mark.parametrize("time", [1, 5, 10])
def test_slider_crank_by_its_table(time):
    row = table("slider_crank_comA", time)
    assert_close(expected("spatial_slider_crank", f"slider_at_{time}_s"), row["slider_x"], 1e-14)


def test_spherical_pendulum_by_its_table():
    row = table("spherical_pendulum", 5.0)
    assert_close(expected("spherical_pendulum", "bob"), [row["x_num"], row["y_num"], row["z_exact"]], 1e-12)


def test_free_body_by_jacobis_functions():
    (body,) = scene("free_body").bodies
    for entry, time in (("spin_at_3_s", 3.0), ("spin_at_10_s", 10.0)):
        exact, _ = racket_rates(np.diag(np.array(body.inertia)), body.angular_velocity[:2], np.array([time]))
        assert_close(expected("free_body", entry), exact[0], 1e-9)


def lagrange(t: float, y: np.ndarray) -> np.ndarray:
    """Two uniform bars of 1 m and 1 kg; a, b are their angles from hanging straight down:

    4/3 a'' + 1/2 cos(a - b) b'' = -1/2 sin(a - b) b'² - 3/2 g sin a,
    1/2 cos(a - b) a'' + 1/3 b'' = +1/2 sin(a - b) a'² - 1/2 g sin b.
    """
    a, b, a_dot, b_dot = y
    c, s = np.cos(a - b) / 2, np.sin(a - b) / 2
    force = [-s * b_dot**2 - 1.5 * 9.81 * np.sin(a), s * a_dot**2 - 0.5 * 9.81 * np.sin(b)]
    return np.concatenate([[a_dot, b_dot], np.linalg.solve([[4 / 3, c], [c, 1 / 3]], force)])


def test_double_pendulum_by_lagranges_equations():
    start = [np.radians(120.0)] * 2 + [0.0, 0.0]
    done = solve_ivp(lagrange, (0.0, 5.0), start, method="DOP853", rtol=1e-13, atol=1e-13, t_eval=[2.0, 5.0])
    for entry, (a, b) in zip(("end_at_2_s", "end_at_5_s"), done.y[:2].T, strict=True):
        exact = [np.sin(a) + np.sin(b), 0.0, -np.cos(a) - np.cos(b)]
        assert_close(expected("double_pendulum", entry), exact, 1e-9)


def test_planar_four_bar_by_energy_and_freudenstein():
    known = bare("planar_four_bar")
    start, swing = known.parameters["start"], known.parameters["swing"]
    φ = reached_at(2.0, start + 40.0, start, known.parameters["speed"], *planar_energy(known))
    assert_close(expected("planar_four_bar", "crank"), φ - start, 1e-10)
    assert_close(expected("planar_four_bar", "rocker"), planar_pose(known, φ)[1] - swing, 1e-10)


def test_spatial_four_bar_by_energy_and_its_transmission():
    known = bare("spatial_four_bar")
    φ = reached_at(2.0, 60.0, 0.0, known.parameters["speed"], *spatial_energy(known))
    assert_close(expected("spatial_four_bar", "crank"), φ, 1e-10)
    assert_close(expected("spatial_four_bar", "rocker"), spatial_pose(known, φ)[0] - known.parameters["swing"], 1e-10)


def test_hooke_shaft_by_energy_and_hookes_formula():
    known = bare("hooke_shaft")
    φ = reached_at(2.0, 30.0, 0.0, known.parameters["speed"], *hooke_energy(known))
    assert_close(expected("hooke_shaft", "driving_shaft"), φ, 1e-10)
    assert_close(expected("hooke_shaft", "fork"), np.arctan(np.tan(known.parameters["bend"]) * np.sin(φ)), 1e-10)


def test_every_mechanism_expects_its_joints_closed_and_its_energy_kept():
    for path in MECHANISMS:
        about = {each.quantity: each for each in scene(path.stem).expectations if each.of == "diagnostic"}
        assert about["position_violation"].below <= 2e-13, path
        assert about.keys() & {"energy_drift", "energy_drift_relative"}, path


# The numbers that the Stewart platform expects, by the platform's own six equations of motion: no joint is in them.

KNOWN = bare("stewart_platform")
SIX = range(1, 7)
#: Ends of the legs in the ground and in the platform, and the axes that their universal joints have in the ground.
BASE, TOP = (
    np.array(
        [
            [KNOWN.parameters[radius] * f(KNOWN.parameters[f"{letter}{k}"]) for f in (np.cos, np.sin)] + [0.0]
            for k in SIX
        ]
    )
    for radius, letter in (("base", "b"), ("platform", "p"))
)
AXES = np.array([[-np.sin(KNOWN.parameters[f"z{k}"]), np.cos(KNOWN.parameters[f"z{k}"]), 0.0] for k in SIX])
#: The bodies in the order of `poses`.
BODIES = [
    next(body for body in KNOWN.scene.bodies if body.name == name)
    for name in ("platform", *(f"cylinder{k}" for k in SIX), *(f"piston{k}" for k in SIX))
]
MASS, INERTIA = np.array([body.mass for body in BODIES]), np.array([body.inertia for body in BODIES])


def legs(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The platform's rotation, as Cayley has it of its Rodrigues vector x[3:], and the legs (6, 3); analytic in x."""
    a, b, c = x[3:]
    skew = np.array([[0, -c, b], [c, 0, -a], [-b, a, 0]])
    rotation = np.linalg.solve(np.eye(3) - skew, np.eye(3) + skew)
    return rotation, x[:3] + TOP @ rotation.T - BASE


def poses(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres of mass (13, 3) and rotations (13, 3, 3); the second axis of a leg's universal joint is its body x."""
    rotation, leg = legs(x)
    along = leg / np.sqrt(np.sum(leg * leg, axis=1, keepdims=True))
    second = np.cross(AXES, along)
    second = second / np.sqrt(np.sum(second * second, axis=1, keepdims=True))
    turned = np.stack([second, np.cross(along, second), along], axis=2)
    low, high = KNOWN.parameters["low"], KNOWN.parameters["length"] - KNOWN.parameters["high"]
    centres = np.concatenate([x[None, :3], BASE + low * along, BASE + leg - high * along])
    return centres, np.concatenate([rotation[None], turned, turned])


def rates(x: np.ndarray) -> np.ndarray:
    """v and ω (global axes) of each body for each unit of x', (13, 6, 6): by complex steps."""
    A, columns = poses(x)[1], []
    for unit in np.eye(6):
        r, turned = poses(x + 1e-40j * unit)
        spin = 1e40 * np.einsum("bij,bkj->bik", turned.imag, A)
        columns.append(np.concatenate([1e40 * r.imag, spin[:, [2, 0, 1], [1, 2, 0]]], axis=1))
    return np.stack(columns, axis=2)


def motion(_: float, y: np.ndarray) -> np.ndarray:
    """x'' by d'Alembert's principle: Σ v_xᵀ (m a - m g) + ω_xᵀ (J ω' + ω × J ω) = 0."""
    x, speed, h = y[:6], y[6:], 1e-4
    at, A = rates(x), poses(x)[1]
    bend = (8 * (rates(x + h * speed) - rates(x - h * speed)) - rates(x + 2 * h * speed) + rates(x - 2 * h * speed)) / (
        12 * h
    )
    inertia = A @ INERTIA @ np.swapaxes(A, 1, 2)
    v, ω, bias = at[:, :3], at[:, 3:] @ speed, bend @ speed
    spin = np.einsum("bij,bj->bi", inertia, ω)
    force = MASS[:, None] * (np.array(KNOWN.scene.gravity) - bias[:, :3])
    torque = -np.einsum("bij,bj->bi", inertia, bias[:, 3:]) - np.cross(ω, spin)
    matrix = np.einsum("b,bji,bjk->ik", MASS, v, v) + np.einsum("bji,bjl,blk->ik", at[:, 3:], inertia, at[:, 3:])
    return np.concatenate([speed, np.linalg.solve(matrix, np.einsum("bji,bj->i", at, np.hstack([force, torque])))])


def start() -> np.ndarray:
    """The pose of the scene, and the speeds that make its legs longer as the scene asks for."""
    x = np.array([0.0, 0.0, KNOWN.parameters["height"], 0.0, 0.0, 0.0])
    length = lambda at: np.sqrt(np.sum(legs(at)[1] ** 2, axis=1))  # noqa: E731
    slope = np.stack([1e40 * length(x + 1e-40j * unit).imag for unit in np.eye(6)], axis=1)
    speeds = {joint.name: joint.speed.get("displacement") for joint in KNOWN.scene.joints}
    return np.concatenate([x, np.linalg.solve(slope, [speeds[f"P{k}"] for k in SIX])])


def test_the_platform_by_its_own_equations():
    done = solve_ivp(motion, (0.0, 0.5), start(), method="DOP853", rtol=1e-9, atol=1e-10)
    x = done.y[:6, -1]
    rotation, leg = legs(x)
    assert_close(expected("stewart_platform", "centre"), x[:3], 1e-8)
    assert_close(expected("stewart_platform", "rim"), x[:3] + KNOWN.parameters["platform"] * rotation[:, 0], 1e-8)
    assert_close(expected("stewart_platform", "leg"), np.linalg.norm(leg[3]) - KNOWN.parameters["length"], 1e-8)


# The numbers in the `expect` blocks of redundant linkages and of the massless rod, against closed forms.


def test_bennetts_linkage_by_energy_and_its_relation():
    known = bare("bennett")
    linkage = Linkage(known, lambda u: bennett_poses(known, u))
    start = known.parameters["start"]
    θ = reached_at(2.0, 30.0, start, known.parameters["speed"], linkage.moment, linkage.potential)
    assert_close(expected("bennett", "crank"), θ - start, 1e-10)
    r, A = bennett_poses(known, θ)
    assert_close(expected("bennett", "coupler_point"), (r[1] + A[1] @ [0.0, 0.06, 0.0]).real, 1e-10)


@pytest.mark.full
def test_the_invertible_cube_by_energy_and_its_closed_curve():
    """From the cube, tan(45° + β/2) = √3 sin u = 1, where β' = √3 cos u u'."""
    known = bare("bricard")
    linkage = Linkage(known, lambda u: bricard_poses(known, u))
    start = np.arcsin(np.sqrt(1 / 3))
    speed = known.parameters["speed"] / (np.sqrt(3) * np.cos(start))
    u = reached_at(2.0, 25.0, start, speed, linkage.moment, linkage.potential)
    β = 2 * np.arctan(np.sqrt(3) * np.sin(u)) - np.pi / 2
    assert_close(expected("bricard", "pin"), β, 1e-10)
    assert_close(expected("bricard", "third_pin"), β, 1e-10)
    r, A = bricard_poses(known, u)
    side = known.parameters["side"]
    assert_close(expected("bricard", "far_corner"), (r[2] + A[2] @ [0.0, -side / 2, 0.0]).real, 1e-10)


def test_the_n_four_bar_by_its_equation():
    """φ'' = g (3/2 + 2) / (3/3 + 2) sin φ for N = 2."""
    known = bare("n_four_bar").parameters
    rate = 9.81 * 3.5 / 3.0 / known["length"]
    done = solve_ivp(
        lambda t, y: [y[1], rate * np.sin(y[0])],
        (0.0, 10.0),
        [0.0, known["speed"]],
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
    )
    for entry in ("turned", "last_bar"):
        assert_close(expected("n_four_bar", entry), done.y[0, -1], 1e-9)


def test_the_locomotives_wheels_by_energy():
    known = bare("locomotive").parameters
    m, r = known["rod"], known["pin"]
    moment = lambda θ: 2 * known["wheel"] + 2 * m * r**2  # noqa: E731
    potential = lambda θ: m * 9.81 * r * (np.sin(θ) + np.cos(θ))  # noqa: E731
    θ = reached_at(3.0, 30.0, 0.0, known["speed"], moment, potential)
    for entry in ("rear", "front"):
        assert_close(expected("locomotive", entry), θ, 1e-10)


def test_the_massless_rod_by_energy_and_the_pistons_acceleration():
    """With I = J + m s'², I θ'' = -m s' s'' θ'² - m_c g c cos θ, and the rod pushes with m (s' θ'' + s'' θ'²)."""
    known = bare("massless_coupler")
    p = known.parameters
    moment = lambda θ: p["flywheel"] + p["piston"] * float(piston(known, θ)[1]) ** 2  # noqa: E731
    potential = lambda θ: p["crank_mass"] * 9.81 * p["centre"] * np.sin(θ)  # noqa: E731
    θ = reached_at(2.0, 40.0, p["start"], p["speed"], moment, potential)
    assert_close(expected("massless_coupler", "crank"), θ - p["start"], 1e-10)
    s, slope, bend = piston(known, θ)
    assert_close(expected("massless_coupler", "piston"), s, 1e-11)
    energy = moment(p["start"]) * p["speed"] ** 2 / 2 + potential(p["start"])
    square = 2 * (energy - potential(θ)) / moment(θ)
    weight = p["crank_mass"] * 9.81 * p["centre"] * np.cos(θ)
    push = p["piston"] * (bend * square - slope * (p["piston"] * slope * bend * square + weight) / moment(θ))
    lean = np.arcsin(p["crank"] / p["rod"] * np.sin(θ))
    assert_close(expected("massless_coupler", "crank_pin"), [push, 0.0, -push * np.tan(lean)], 1e-9)
