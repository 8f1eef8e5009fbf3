"""Scenes in which bodies roll, and a rattleback with equations of its own."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

import mbproj
from mbproj.base.arrays import Array

# Bodies that roll, slide on an edge, or turn on a wheel: scenes with closed forms or references.

#: A coin of 0.3 m rolls on a circle of its centre of 1 m, its axis 75 degrees from upright: Ω and spin in rad/s, N, N.
RADIUS, TILT, PRECESSION, SPIN = 0.3, np.radians(75.0), 1.31529459542149, -4.72473860928712
FRICTION = 1.72999987274498
GRAVITY = 9.81


def scene(bodies: str, joints: str, rest: str = "", *, gravity: str = "[0, 0, -9.81]", **simulation: object) -> str:
    """A scene of these lines."""
    settings = {"duration": "1 s", "output_step": "0.1 s", "tolerance": 1e-10, "integrator": "dop853"} | simulation
    settings = {key: value for key, value in settings.items() if value is not None}
    lines = ", ".join(f"{key}: {value}" for key, value in settings.items())
    return f"mbproj: 1\ngravity: {gravity}\nsimulation: {{{lines}}}\nbodies:\n{bodies}\njoints:\n{joints}\n{rest}"


def wheel(body: str, centre: str, axis: str, radius: float, ground: str = "ground") -> str:
    """A wheel on the plane z = 0 of a body."""
    plane = "plane: {location: [0, 0, 0], normal: [0, 0, 1]}"
    where = f"centre: {centre}, axis: {axis}, radius: {radius!r}"
    return f"  W_{body}: {{type: rolling_wheel, bodies: [{ground}, {body}], {plane}, {where}}}"


def coin(**simulation: object) -> str:
    """The coin at its steady motion."""
    S, C = float(np.sin(TILT)), float(np.cos(TILT))
    omega = f"[{-PRECESSION * S!r}, 0, {PRECESSION * C + SPIN!r}]"
    at = f"position: [1, 0, {RADIUS * S!r}], orientation: {{axis: [0, 1, 0], angle: {float(TILT)!r}}}"
    moves = f"velocity: [0, {PRECESSION!r}, 0], angular_velocity: {omega}"
    body = f"  coin: {{mass: 1, inertia: [0.0225, 0.0225, 0.045], {at}, {moves}}}"
    return scene(body, wheel("coin", f"[1, 0, {RADIUS * S!r}]", f"[{S!r}, 0, {C!r}]", RADIUS), **simulation)


def wobbling(state: np.ndarray, **simulation: object) -> str:
    """The coin from a state (13,) of positions, Euler parameters, velocities and angular velocities in body axes."""
    r, Λ, v, ω = (", ".join(map(repr, map(float, part))) for part in np.split(state, [3, 7, 10]))
    w, x, y, z = state[3:7] / np.linalg.norm(state[3:7])
    axis = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)]
    at = f"position: [{r}], orientation: {{quaternion: [{Λ}]}}, velocity: [{v}], angular_velocity: [{ω}]"
    body = f"  coin: {{mass: 1, inertia: [0.0225, 0.0225, 0.045], {at}}}"
    return scene(body, wheel("coin", f"[{r}]", str([float(part) for part in axis]), RADIUS), **simulation)


def turntable(speed: float = 3.0, radius: float = 0.1, **simulation: object) -> str:
    """A ball on a table that a motion turns: its centre moves on a circle at 2/7 of the table's speed."""
    x, y, vx, vy = 0.5, 0.1, 0.5, -0.2
    at = f"[{x}, {y}, {radius!r}]"
    omega = f"[{(speed * x - vy) / radius!r}, {(speed * y + vx) / radius!r}, 0]"
    bodies = (
        "  table: {mass: 5, inertia: [1, 1, 2], position: [0, 0, 0]}\n"
        f"  ball: {{mass: 1, shape: {{sphere: {radius!r}}}, position: {at}, velocity: [{vx}, {vy}, 0], "
        f"angular_velocity: {omega}}}"
    )
    plane = "plane: {location: [0, 0, 0], normal: [0, 0, 1]}"
    joints = (
        "  pin: {type: revolute, bodies: [ground, table], location: [0, 0, 0], axis: [0, 0, 1]}\n"
        f"  B: {{type: rolling_ball, bodies: [table, ball], {plane}, centre: {at}, radius: {radius!r}}}"
    )
    return scene(bodies, joints, f"motions:\n  turn: {{joint: pin, angle: {speed!r} * t}}", **simulation)


def on_turntable(t: np.ndarray, speed: float = 3.0) -> np.ndarray:
    """Where its ball is, (..., 2)."""
    Ω, v, r = 2.0 / 7.0 * speed, 0.5 - 0.2j, 0.5 + 0.1j
    z = r + v * (np.exp(1j * Ω * t) - 1.0) / (1j * Ω)
    return np.stack([z.real, z.imag], axis=-1)


def sleigh(arm: float = 0.2, **simulation: object) -> str:
    """Chaplygin's sleigh: an edge behind the centre of mass on a plane; it moves at v along itself and turns at ω."""
    v, ω = -0.5, 3.0
    moves = f"velocity: [{v}, {ω * arm!r}, 0], angular_velocity: [0, 0, {ω}]"
    bodies = f"  sleigh: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [{arm!r}, 0, 0], {moves}}}"
    joints = (
        "  slides: {type: planar, bodies: [ground, sleigh], location: [0, 0, 0], axis: [0, 0, 1]}\n"
        "  edge: {type: knife_edge, bodies: [ground, sleigh], location: [0, 0, 0], axis: [0, 1, 0]}"
    )
    return scene(bodies, joints, gravity="[0, 0, 0]", **simulation)


def of_sleigh(t: np.ndarray, arm: float = 0.2) -> tuple[np.ndarray, np.ndarray]:
    """The speed at its edge and the angle: v = c tanh s, ω = c/κ sech s, κ² = J/m + a² (Neimark and Fufaev 1972)."""
    κ, v, ω = np.sqrt(0.05 + arm**2), -0.5, 3.0
    c = np.hypot(v, κ * ω)
    s0 = np.arctanh(v / c)
    s = s0 + arm * c / κ**2 * t
    return c * np.tanh(s), κ / arm * (np.arctan(np.sinh(s)) - np.arctan(np.sinh(s0)))


def car(left: float, right: float, **simulation: object) -> str:
    """Four wheels of 0.3 m on revolutes of a car 1 m long and wide, its front wheels steered by these angles in rad."""
    bodies = "  car: {mass: 100, inertia: [5, 10, 10], position: [0.5, 0, 0.4], velocity: [2, 0, 0]}\n"
    joints = ""
    for name, x, y, angle in (("rl", 0, 0.5, 0.0), ("rr", 0, -0.5, 0.0), ("fl", 1, 0.5, left), ("fr", 1, -0.5, right)):
        at, axis = f"[{x}, {y}, 0.3]", f"[{float(-np.sin(angle))!r}, {float(np.cos(angle))!r}, 0]"
        turn = f"orientation: {{axis: [0, 0, 1], angle: {angle!r}}}"
        bodies += f"  {name}: {{mass: 10, inertia: [0.2, 0.4, 0.2], position: {at}, {turn}}}\n"
        joints += f"  {name}: {{type: revolute, bodies: [car, {name}], location: {at}, axis: {axis}}}\n"
        joints += f"{wheel(name, at, axis, 0.3)}\n"
    return scene(bodies, joints, **simulation)


def trailer(**simulation: object) -> str:
    """A trailer on a plane, its wheel and hub without mass."""
    moves = "velocity: [1, 0, 0], angular_velocity: [0, 0, 0.5]"
    bodies = (
        f"  trailer: {{mass: 20, inertia: [0.5, 1, 1], position: [0.2, 0, 0.3], {moves}}}\n"
        "  hub: {mass: 0, inertia: [0, 0, 0], position: [0, 0, 0.3]}"
    )
    joints = (
        "  A: {type: planar, bodies: [ground, trailer], location: [0.2, 0, 0.3], axis: [0, 0, 1]}\n"
        "  pin: {type: revolute, bodies: [trailer, hub], location: [0, 0, 0.3], axis: [0, 1, 0]}\n"
        + wheel("hub", "[0, 0, 0.3]", "[0, 1, 0]", 0.3)
    )
    return scene(bodies, joints, **simulation)


# A rattleback: its scene, and equations of motion of its own in its pose and its angular velocity in body axes.

#: Semi-axes and how far the centre of mass is below the centre, in m; moments of inertia in kg m², the mass is 1 kg.
SEMI_AXES, LOW, MOMENTS = np.array([0.2, 0.03, 0.02]), 0.01, np.array([2.0e-4, 1.6e-3, 1.7e-3])
ROLL = 1.0


def rattleback(spin: float, skew: float, **simulation: object) -> str:
    """It stands upright and rolls at `ROLL` about the first axis of its inertia."""
    height = float(SEMI_AXES[2] - LOW)
    moves = f"velocity: [0, {-ROLL * height!r}, 0], angular_velocity: [{ROLL}, 0, {spin!r}]"
    body = f"  celt: {{mass: 1, inertia: {MOMENTS.tolist()}, position: [0, 0, {height!r}], {moves}}}"
    return scene(body, ellipsoid("celt", "[0, 0, 0.02]", skew, SEMI_AXES.tolist()), **simulation)


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
        torque = cross(ρ, cross(ω, v) - cross(ω, ρ_dot) + GRAVITY * n) - cross(ω, MOMENTS * ω)
        turned = v + 2.0 * w * cross(u, v) + 2.0 * cross(u, cross(u, v))
        spun = 0.5 * np.array([-u @ ω, *(w * ω + cross(u, ω))])
        return np.concatenate([turned, spun, np.linalg.solve(inertia, torque)])

    start = [0.0, 0.0, SEMI_AXES[2] - LOW, 1.0, 0.0, 0.0, 0.0, ROLL, 0.0, spin]
    y = solve_ivp(rates, (0.0, t[-1]), start, "DOP853", t, rtol=1e-11, atol=1e-13).y.T
    return y[:, :3], y[:, 7:]


def run(text: str, **settings: object) -> mbproj.Results:
    return mbproj.run(mbproj.read_scene_text(text), **settings)
