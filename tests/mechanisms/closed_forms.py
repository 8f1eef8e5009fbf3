"""Closed forms of the motion of shipped mechanisms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipj, ellipk

from mbproj import Scene, read_scene
from tests.mechanisms.running import Run, assert_close
from tests.support import ROOT

# The exact motion of a mechanism of one degree of freedom from its kinematics and energy alone.

#: Of the coordinate: effective moment of inertia I, and potential energy V.
Of = Callable[[float], float]
#: Centres of mass (n, 3) and rotation matrices (n, 3, 3) of the bodies, analytic in the coordinate.
Poses = Callable[[complex], tuple[np.ndarray, np.ndarray]]
#: Points on a circle about 0, for derivatives by Cauchy's formula: to 1e-12 where poses are analytic within 0.6.
CIRCLE = 0.1 * np.exp(2j * np.pi * np.arange(16) / 16)


def time_to_reach(angle: float, start: float, speed: float, moment: Of, potential: Of) -> float:
    """The time at which the coordinate gets from `start`, at `speed` > 0, to `angle` without stopping:

    ½ I(φ) φ'² + V(φ) = E, so t = ∫ dφ / φ'.
    """
    energy = 0.5 * moment(start) * speed**2 + potential(start)
    rate = lambda φ: (2.0 * (energy - potential(φ)) / moment(φ)) ** 0.5  # noqa: E731
    return float(quad(lambda φ: 1.0 / rate(φ), start, angle, epsabs=1e-13, epsrel=1e-13, limit=200)[0])


@dataclass(frozen=True)
class Linkage:
    """A run of a mechanism, the poses of whose bodies are known as functions of one coordinate u."""

    done: Run
    poses: Poses

    def rates(self, u: float) -> np.ndarray:
        """r' and ω (global axes) of each body for u' = 1, (n, 6): by a complex step, exact to round-off."""
        r, A = self.poses(u + 1e-40j)
        Ω = np.einsum("bij,bkj->bik", 1e40 * A.imag, A.real)
        return np.concatenate([1e40 * r.imag, Ω[:, [2, 0, 1], [1, 2, 0]]], axis=1)

    def bends(self, u: float) -> np.ndarray:
        """The derivative of `rates`, (n, 6)."""
        around = [self.poses(u + z) for z in CIRCLE]
        r, A = (2.0 * np.tensordot(CIRCLE**-2.0, [pose[k] for pose in around], 1).real / 16 for k in (0, 1))
        Ω = np.einsum("bij,bkj->bik", A, self.poses(u)[1].real)
        return np.concatenate([r, 0.5 * (Ω - np.swapaxes(Ω, 1, 2))[:, [2, 0, 1], [1, 2, 0]]], axis=1)

    def momenta(self, u: float) -> np.ndarray:
        """Momentum and spin (global axes) of each body for u' = 1, (n, 6)."""
        A, rates = self.poses(u)[1].real, self.rates(u)
        spin = [a @ np.array(b.inertia) @ a.T @ w for a, b, w in zip(A, self.bodies, rates[:, 3:], strict=True)]
        return np.concatenate([self.mass[:, None] * rates[:, :3], spin], axis=1)

    def moment(self, u: float) -> float:
        return float(np.sum(self.momenta(u) * self.rates(u)))

    def potential(self, u: float) -> float:
        return float(-self.mass @ self.poses(u)[0].real @ np.array(self.done.scene.gravity))

    def acceleration(self, u: float, speed: float) -> float:
        """u'' = (-½ I' u'² - V') / I, where ½ I' = Σ (m r'·r'' + Jω·ω'), as the term of dJ is normal to ω."""
        slope = np.sum(self.momenta(u) * self.bends(u)) * speed**2
        weight = self.mass @ self.rates(u)[:, :3] @ np.array(self.done.scene.gravity)
        return float((weight - slope) / self.moment(u))

    @property
    def bodies(self):
        return self.done.scene.bodies

    @property
    def mass(self) -> np.ndarray:
        return np.array([body.mass for body in self.bodies])

    def assert_poses(self, u: np.ndarray, tolerance: float) -> None:
        """The recorded poses are those of the recorded coordinate."""
        exact = [self.poses(each) for each in u]
        assert_close(self.done["bodies/position"], [r for r, _ in exact], tolerance)
        for k, body in enumerate(self.bodies):
            assert_close(self.done.rotation(body.name), [A[k] for _, A in exact], tolerance)

    def assert_velocities(self, u: np.ndarray, speed: np.ndarray, tolerance: float) -> None:
        exact = np.array([self.rates(each) * rate for each, rate in zip(u, speed, strict=True)])
        assert_close(self.done["bodies/velocity"], exact[..., :3], tolerance)
        for k, body in enumerate(self.bodies):
            assert_close(self.turned("bodies/angular_velocity", body.name), exact[:, k, 3:], tolerance)

    def assert_accelerations(self, u: np.ndarray, speed: np.ndarray, tolerance: float) -> None:
        """Those of the equation of motion in u, from the recorded u and u'."""
        exact = np.array(
            [self.bends(at) * v**2 + self.rates(at) * self.acceleration(at, v) for at, v in zip(u, speed, strict=True)]
        )
        assert_close(self.done["bodies/acceleration"], exact[..., :3], tolerance)
        for k, body in enumerate(self.bodies):
            assert_close(self.turned("bodies/angular_acceleration", body.name), exact[:, k, 3:], tolerance)

    def assert_times(self, u: np.ndarray, speed: float, tolerance: float, every: int = 5) -> None:
        """The coordinate goes one way, and is where its energy has it at every recorded time."""
        rows = np.arange(every, len(u), every)
        times = [time_to_reach(u[row], u[0], speed, self.moment, self.potential) for row in rows]
        assert_close(times, self.done["time"][rows], tolerance)

    def turned(self, path: str, body: str) -> np.ndarray:
        """A vector in body axes, (T, 3), in global axes."""
        return np.einsum("tij,tj->ti", self.done.rotation(body), self.done.column(path, body))


def reached_at(time: float, most: float, start: float, speed: float, moment: Of, potential: Of) -> float:
    """The coordinate at a time, which is below `most`: `time_to_reach` solved for the angle."""
    return float(brentq(lambda φ: time_to_reach(φ, start, speed, moment, potential) - time, start, most, xtol=1e-13))


# Values that the shipped mechanisms expect, and what formulas take of a run without one.


@cache
def scene(name: str) -> Scene:
    return read_scene(ROOT / "mechanisms" / f"{name}.yaml")


def expected(name: str, entry: str) -> np.ndarray:
    """The value of an expectation (k,)."""
    (found,) = (each for each in scene(name).expectations if each.name == entry)
    assert found.value is not None
    return np.array(found.value)


def bare(name: str) -> SimpleNamespace:
    """What the formulas of other tests take of a run: its scene and parameters."""
    return SimpleNamespace(scene=scene(name), parameters=scene(name).parameters)


# Poses and energies of the planar and the spatial four-bar in closed form, by the crank's angle.


def planar_pose(done: Run, φ: float):
    """Angles of coupler and rocker by the intersection of two circles, and their rates for φ' = 1."""
    a, b, c, d = (done.parameters[name] for name in ("crank", "coupler", "rocker", "frame"))
    diagonal = d - a * np.exp(1j * φ)
    ψ = np.angle(diagonal) + np.arccos((b * b + abs(diagonal) ** 2 - c * c) / (2 * b * abs(diagonal)))
    χ = np.angle(b * np.exp(1j * ψ) - diagonal)
    # a e^iφ + b ψ' e^iψ = c χ' e^iχ, each part without the other unknown
    return ψ, χ, a * np.sin(φ - χ) / (b * np.sin(χ - ψ)), a * np.sin(φ - ψ) / (c * np.sin(χ - ψ))


def planar_energy(done: Run) -> tuple[Of, Of]:
    """Moment of inertia on the crank, and potential energy, of the crank's angle φ."""
    a, b, c = (done.parameters[name] for name in ("crank", "coupler", "rocker"))
    crank, coupler, rocker = done.scene.bodies

    def moment(φ: float) -> float:
        ψ, _, ψ_rate, χ_rate = planar_pose(done, φ)
        velocity = a * np.exp(1j * φ) + b / 2 * ψ_rate * np.exp(1j * ψ)
        turning = crank.inertia[1][1] + coupler.inertia[1][1] * ψ_rate**2 + rocker.inertia[1][1] * χ_rate**2
        return turning + crank.mass * a**2 / 4 + coupler.mass * abs(velocity) ** 2 + rocker.mass * (c / 2 * χ_rate) ** 2

    def potential(φ: float) -> float:
        ψ, χ, _, _ = planar_pose(done, φ)
        heights = a / 2 * np.sin(φ), a * np.sin(φ) + b / 2 * np.sin(ψ), c / 2 * np.sin(χ)
        return 9.81 * sum(m * z for m, z in zip((crank.mass, coupler.mass, rocker.mass), heights, strict=True))

    return moment, potential


def spatial_pose(done: Run, φ: float):
    """Ends B, C of the rod and their velocities for φ' = 1, with 2cx sin χ - 2ac sin φ cos χ = k."""
    a, b, c, x, y = (done.parameters[name] for name in ("crank", "coupler", "rocker", "x", "y"))
    k = b * b - c * c - x * x - y * y - a * a + 2 * a * y * np.cos(φ)
    p, q = 2 * c * x, -2 * a * c * np.sin(φ)
    χ = np.arctan2(p, q) - np.arccos(k / np.hypot(p, q))
    B, C = a * np.array([0.0, np.cos(φ), np.sin(φ)]), np.array([x + c * np.sin(χ), y, c * np.cos(χ)])
    B_dot, C_χ = a * np.array([0.0, -np.sin(φ), np.cos(φ)]), c * np.array([np.cos(χ), 0.0, -np.sin(χ)])
    χ_rate = (C - B) @ B_dot / ((C - B) @ C_χ)
    return χ, B, C, B_dot, C_χ * χ_rate, χ_rate


def spatial_energy(done: Run) -> tuple[Of, Of]:
    """Moment of inertia on the crank, and potential energy, of the crank's angle φ. The idle spin does no work on the
    rest: its energy is constant, and the gyroscopic moment is normal to ω."""
    a, b, c = (done.parameters[name] for name in ("crank", "coupler", "rocker"))
    crank, rod, rocker = done.scene.bodies

    def moment(φ: float) -> float:
        *_, B_dot, C_dot, χ_rate = spatial_pose(done, φ)
        tilting = np.sum((C_dot - B_dot) ** 2) / b**2
        turning = crank.inertia[0][0] + rod.inertia[1][1] * tilting + rocker.inertia[1][1] * χ_rate**2
        moving = rod.mass * np.sum((B_dot + C_dot) ** 2) / 4 + rocker.mass * (c / 2 * χ_rate) ** 2
        return turning + crank.mass * a**2 / 4 + moving

    def potential(φ: float) -> float:
        _, B, C, *_ = spatial_pose(done, φ)
        return 9.81 / 2 * (crank.mass * B[2] + rod.mass * (B[2] + C[2]) + rocker.mass * C[2])

    return moment, potential


# A free body's angular velocity by Jacobi's elliptic functions.


def racket_rates(moments, start, t):
    """ω (T, 3) in body axes for A < B < C and ω(0) = (p, q, 0) with L² < 2EB: ω = (a dn, b sn, c cn)(n t + K | m).

    n² = (B - A)(2EC - L²)/(ABC), m = (C - B)(L² - 2EA)/((B - A)(2EC - L²)): Landau's solution, A and C exchanged.
    """
    A, B, C = moments
    energy2 = A * start[0] ** 2 + B * start[1] ** 2
    momentum2 = (A * start[0]) ** 2 + (B * start[1]) ** 2
    n = np.sqrt((B - A) * (energy2 * C - momentum2) / (A * B * C))
    m = (C - B) * (momentum2 - energy2 * A) / ((B - A) * (energy2 * C - momentum2))
    sn, cn, dn, _ = ellipj(n * t + ellipk(m), m)
    a = np.sqrt((energy2 * C - momentum2) / (A * (C - A)))
    b = np.sqrt((momentum2 - energy2 * A) / (B * (B - A)))
    c = np.sqrt((momentum2 - energy2 * A) / (C * (C - A)))
    return np.stack([a * dn, b * sn, c * cn], axis=-1), 2.0 * ellipk(m) / n


# The transmission and the energy of a shaft with Hooke's joint.


def ratio(done: Run, φ1):
    """ω2 / ω1."""
    β = done.parameters["bend"]
    return np.cos(β) / (1.0 - np.sin(β) ** 2 * np.cos(φ1) ** 2)


def energy(done: Run) -> tuple[Of, Of]:
    """Moment of inertia on the driving shaft, of its angle, and no potential energy."""
    driving, driven, _ = done.scene.bodies
    return lambda φ1: driving.inertia[0][0] + driven.inertia[0][0] * ratio(done, φ1) ** 2, lambda φ1: 0.0


# A parallelogram that turns through its singular poses; without gravity its motion is even.

#: A parallelogram without gravity turns evenly; φ is counted from the line of all bars. CLOSURE is the joint C.
PARALLELOGRAM = """
mbproj: 1
gravity: [0, 0, 0]
parameters: {crank: 0.2 m, coupler: 0.5 m, start: -1, speed: 1, x: crank*cos(start), z: crank*sin(start)}
simulation: {duration: 2, step: 0.05}
bodies:
  left: {mass: 1, inertia: [0.01, 0.02, 0.02], position: [x/2, 0, z/2], orientation: {axis: [0, -1, 0], angle: start}}
  right:
    mass: 2
    inertia: [0.01, 0.03, 0.03]
    position: [coupler + x/2, 0, z/2]
    orientation: {axis: [0, -1, 0], angle: start}
  coupler: {mass: 0.5, inertia: [0.01, 0.02, 0.02], position: [coupler/2 + x, 0, z]}
joints:
  A: {type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, -1, 0], speed: speed}
  B: {type: revolute, bodies: [left, coupler], location: [x, 0, z], axis: [0, -1, 0]}
  C: {type: CLOSURE, bodies: [right, coupler], location: [coupler + x, 0, z], axis: [0, -1, 0]}
  D: {type: revolute, bodies: [ground, right], location: [coupler, 0, 0], axis: [0, -1, 0]}
"""


# The large swing of a bar by Jacobi's elliptic functions.


def physical_angle(t: np.ndarray) -> np.ndarray:
    """sin(φ/2) = k sn(K + ω t | k²) for a bar of 1 m released at 120°: ω² = m g a / (J + m a²) = 3 g / 2."""
    return swinging(np.radians(120.0), np.sqrt(1.5 * 9.81), t)[0]


# Poses of Bennett's linkage and of Bricard's ring in closed form.


def turn(axis: str, angle: complex) -> np.ndarray:
    """The rotation about a coordinate axis, analytic in the angle."""
    k = "xyz".index(axis)
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.zeros((3, 3), dtype=complex)
    matrix[k, k] = 1.0
    i, j = (k + 1) % 3, (k + 2) % 3
    matrix[i, i], matrix[j, j], matrix[i, j], matrix[j, i] = c, c, -s, s
    return matrix


def bennett_ratio(done: Run) -> float:
    alpha, beta = done.parameters["alpha"], done.parameters["beta"]
    return np.sin((alpha + beta) / 2) / np.sin((beta - alpha) / 2)


def bennett_poses(done: Run, theta: complex) -> tuple[np.ndarray, np.ndarray]:
    """By Denavit & Hartenberg's frames from both ends of the frame, with θ2 of the closed relation."""
    p = done.parameters
    a, b, alpha, beta = (p[name] for name in ("short", "long", "alpha", "beta"))
    half = theta / 2  # θ2/2 = atan2(k cos θ1/2, sin θ1/2), free of poles: cos and sin of θ2 are rational in these
    x, y = np.sin(half), bennett_ratio(done) * np.cos(half)
    cosine, sine = (x * x - y * y) / (x * x + y * y), 2 * x * y / (x * x + y * y)
    next_turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
    crank = turn("z", theta)
    coupler = crank @ turn("x", alpha) @ next_turn
    rocker = turn("x", -beta) @ next_turn
    centres = a / 2 * crank[:, 0], a * crank[:, 0] + b / 2 * coupler[:, 0], [-b, 0, 0] - a / 2 * rocker[:, 0]
    return np.array(centres), np.array([crank, coupler, rocker])


def bricard_poses(done: Run, u: complex) -> tuple[np.ndarray, np.ndarray]:
    """The chain of five bars, pin after pin."""
    x = np.sqrt(3) * np.sin(u)
    beta = 2 * np.arctan(x) - np.pi / 2
    alpha = 2 * np.arctan(np.sqrt(3) * np.cos(u) / np.sqrt(1 + x * x)) - np.pi / 2
    corner, rotation, centres, rotations = np.array([1.0, 1.0, 0.0]), np.eye(3), [], []
    for axis, angle, bar in zip("zyxzy", (beta, alpha, beta, alpha, beta), BARS, strict=True):
        rotation = rotation @ turn(axis, angle)
        centres.append(corner + rotation @ bar / 2)
        rotations.append(rotation)
        corner = corner + rotation @ bar
    return done.parameters["side"] * np.array(centres), np.array(rotations)


#: Along the bars at the start, for a cube of side 1.
BARS = np.array([[-1.0, 0, 0], [0, 0, 1], [0, -1, 0], [1, 0, 0], [0, 0, -1]])


# A slider-crank's piston by the crank's angle.


def piston(done: Run, θ: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """s = r cos θ + sqrt(l² - r² sin² θ) and its first two derivatives."""
    r, l = done.parameters["crank"], done.parameters["rod"]
    sine, cosine = np.sin(θ), np.cos(θ)
    root = np.sqrt(l**2 - r**2 * sine**2)
    slope = -(r**2) * sine * cosine / root
    return r * cosine + root, -r * sine + slope, -r * cosine - r**2 * (cosine**2 - sine**2) / root - slope**2 / root


# A pendulum that swings wide, by Jacobi's elliptic functions.


def swinging(amplitude: float, frequency: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """φ and φ' of a pendulum that starts from rest at this amplitude; `frequency` is that of small swings."""
    k = np.sin(amplitude / 2)
    quarter = ellipk(k * k)
    sn, cn, dn, _ = ellipj(quarter + frequency * t, k * k)
    return 2 * np.arcsin(k * sn), 2 * k * frequency * cn * dn / np.sqrt(1 - (k * sn) ** 2)
