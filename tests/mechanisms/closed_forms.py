"""The exact motion of a mechanism of one degree of freedom from its kinematics and energy alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from tests.mechanisms.running import Run, assert_close

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
