"""The numbers that the Stewart platform expects, by the platform's own six equations of motion: no joint is in them."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from tests.mechanisms.closed_forms import bare, expected
from tests.mechanisms.running import assert_close

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
