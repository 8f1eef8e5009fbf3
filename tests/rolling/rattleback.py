"""A rattleback: its scene, and equations of motion of its own in its pose and its angular velocity in body axes."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from mbproj.base.arrays import Array
from tests.rolling import scenes

#: Semi-axes and how far the centre of mass is below the centre, in m; moments of inertia in kg m², the mass is 1 kg.
SEMI_AXES, LOW, MOMENTS = np.array([0.2, 0.03, 0.02]), 0.01, np.array([2.0e-4, 1.6e-3, 1.7e-3])
ROLL = 1.0


def rattleback(spin: float, skew: float, **simulation: object) -> str:
    """It stands upright and rolls at `ROLL` about the first axis of its inertia."""
    height = float(SEMI_AXES[2] - LOW)
    moves = f"velocity: [0, {-ROLL * height!r}, 0], angular_velocity: [{ROLL}, 0, {spin!r}]"
    body = f"  celt: {{mass: 1, inertia: {MOMENTS.tolist()}, position: [0, 0, {height!r}], {moves}}}"
    return scenes.scene(body, ellipsoid("celt", "[0, 0, 0.02]", skew, SEMI_AXES.tolist()), **simulation)


def ellipsoid(body: str, centre: str, skew: float, semi_axes: list[float], ground: str = "ground") -> str:
    """Its axes are turned about z by minus `skew`."""
    plane = "plane: {location: [0, 0, 0], normal: [0, 0, 1]}"
    axes = f"axis: [0, 0, 1], x_axis: [cos({skew!r}), -sin({skew!r}), 0], semi_axes: {semi_axes}"
    return f"  E: {{type: rolling_ellipsoid, bodies: [{ground}, {body}], {plane}, centre: {centre}, {axes}}}"


def cross(a: Array, b: Array) -> Array:
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def of_rattleback(t: Array, spin: float, skew: float) -> tuple[Array, Array]:
    """Positions of its centre of mass and angular velocities in body axes, (T, 3) each: m (v' + ω × v + g n) = F and
    J ω' + ω × J ω = ρ × F, with v = -ω × ρ and the contact at ρ."""
    c, s = np.cos(skew), np.sin(skew)
    axes = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    up = np.array([0.0, 0.0, 1.0])
    squares = axes.T @ np.diag(SEMI_AXES**2) @ axes

    def rates(_: float, y: Array) -> Array:
        (w, *xyz), ω = y[3:7] / np.linalg.norm(y[3:7]), y[7:]
        u = np.array(xyz)
        n = 2.0 * (u[2] * u - w * cross(u, up)) + (w * w - u @ u) * up
        n_dot, below = cross(n, ω), squares @ n
        reach = np.sqrt(n @ below)
        ρ = np.array([0.0, 0.0, LOW]) - below / reach
        ρ_dot = -squares @ n_dot / reach + below * (below @ n_dot) / reach**3
        v = -cross(ω, ρ)
        inertia = np.diag(MOMENTS) + (ρ @ ρ) * np.eye(3) - np.outer(ρ, ρ)
        torque = cross(ρ, cross(ω, v) - cross(ω, ρ_dot) + scenes.GRAVITY * n) - cross(ω, MOMENTS * ω)
        turned = v + 2.0 * w * cross(u, v) + 2.0 * cross(u, cross(u, v))
        spun = 0.5 * np.array([-u @ ω, *(w * ω + cross(u, ω))])
        return np.concatenate([turned, spun, np.linalg.solve(inertia, torque)])

    start = [0.0, 0.0, SEMI_AXES[2] - LOW, 1.0, 0.0, 0.0, 0.0, ROLL, 0.0, spin]
    y = solve_ivp(rates, (0.0, t[-1]), start, "DOP853", t, rtol=1e-11, atol=1e-13).y.T
    return y[:, :3], y[:, 7:]
