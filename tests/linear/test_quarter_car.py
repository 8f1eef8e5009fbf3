"""The quarter car against its loop closure, solved by SciPy: static deflection, and both modes, from the energies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

from mbproj.equations.assembly.compiled import compile_system
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.equilibrium.start import assembled_start
from mbproj.linear.modes import modes
from tests.mechanisms.closed_forms import expected, scene
from tests.mechanisms.running import assert_close

G = 9.81
MASS = {"body": 300.0, "lower": 5.0, "upper": 3.0, "upright": 38.0, "rod": 0.8}
#: At the pose of the scene: points on both arms' axes, directions of the axes, and what the arms carry.
LOWER, LOWER_AXIS = np.array([0, 0.4, 0.2175]), np.array([0.3, 0, 0.005])
UPPER, UPPER_AXIS = np.array([0, 0.45, 0.4925]), np.array([0.24, 0.01, 0.015])
LOWER_BALL, UPPER_BALL = np.array([0.005, 0.7, 0.2]), np.array([-0.01, 0.66, 0.48])
INNER, OUTER = np.array([0.13, 0.42, 0.245]), np.array([0.125, 0.68, 0.235])
HUB, LOWER_MASS, UPPER_MASS = np.array([0, 0.75, 0.3]), np.array([0, 0.52, 0.212]), np.array([-0.005, 0.54, 0.487])
COIL_TOP, COIL_FOOT = np.array([0, 0.48, 0.68]), np.array([0, 0.6, 0.21])
ALONG = (OUTER - INNER) / np.linalg.norm(OUTER - INNER)
INERTIA = {
    "lower": np.diag([0.05, 0.04, 0.09]),
    "upper": np.diag([0.02, 0.015, 0.03]),
    "upright": np.diag([0.8, 1.3, 0.8]),
    "rod": 0.8 / 12 * (3 * 0.008**2 + np.sum((OUTER - INNER) ** 2)) * (np.eye(3) - np.outer(ALONG, ALONG))
    + 0.4 * 0.008**2 * np.outer(ALONG, ALONG),
}


class Closed:
    """Where everything is at a height z of the body and an angle of the lower arm, by the closure of the loops."""

    def __init__(self, coordinates):
        self.z, angle = coordinates
        self.up = np.array([0.0, 0.0, self.z])
        self.lower = turn(LOWER_AXIS, angle)
        self.low = self.up + LOWER + self.lower @ (LOWER_BALL - LOWER)
        guess = [angle, *(self.up + OUTER + [0, 0, 0.28 * np.sin(angle)])]
        solution, _, _status, said = fsolve(self._open, guess, full_output=True, xtol=1e-15)
        assert np.abs(self._open(solution)).max() < 1e-13, said
        self.upper, self.outer = turn(UPPER_AXIS, solution[0]), solution[1:]
        self.high = self._high(solution[0])
        self.upright = axes(self.low, self.high, self.outer) @ axes(LOWER_BALL, UPPER_BALL, OUTER).T
        self.hub = self.low + self.upright @ (HUB - LOWER_BALL)
        self.rod = self._rod(self.outer - self.up - INNER) @ self._rod(OUTER - INNER).T

    @staticmethod
    def _rod(way):
        """Axes of the rod along this way: the joint's pin in it, (0, cos φ, sin φ), keeps its angle from the way."""
        direction = way / length(way)
        φ = np.arctan2(direction[2], direction[1]) + np.arccos(ALONG[2] / np.hypot(direction[1], direction[2]))
        return axes(np.zeros(3), direction, np.array([0.0, np.cos(φ), np.sin(φ)]))

    def _high(self, angle):
        return self.up + UPPER + turn(UPPER_AXIS, angle) @ (UPPER_BALL - UPPER)

    def _open(self, unknown):
        """The upright and the tie rod keep their lengths."""
        high, outer = self._high(unknown[0]), unknown[1:]
        return [
            length(high - self.low) - length(UPPER_BALL - LOWER_BALL),
            length(outer - self.low) - length(OUTER - LOWER_BALL),
            length(outer - high) - length(OUTER - UPPER_BALL),
            length(outer - self.up - INNER) - length(OUTER - INNER),
        ]

    @property
    def points(self):
        """Centres of mass of the body, both arms, the upright and the rod."""
        lower = self.up + LOWER + self.lower @ (LOWER_MASS - LOWER)
        upper = self.up + UPPER + self.upper @ (UPPER_MASS - UPPER)
        return np.array([self.up, lower, upper, self.hub, 0.5 * (self.up + INNER + self.outer)])

    @property
    def coil(self):
        return length(self.up + COIL_TOP - self.up - LOWER - self.lower @ (COIL_FOOT - LOWER))

    @property
    def energy(self):
        tyre = length(self.hub - [0, 0.75, 0])
        stored = 40e3 * (self.coil - 0.575) ** 2 + 200e3 * (tyre - 0.315) ** 2
        return G * np.array(list(MASS.values())) @ self.points[:, 2] + 0.5 * stored


def length(vector):
    return float(np.sqrt(vector @ vector))


def turn(axis, angle):
    return Rotation.from_rotvec(angle * axis / length(axis)).as_matrix()


def axes(first, second, third):
    """Orthonormal axes of three points of a body."""
    x = (second - first) / length(second - first)
    z = np.cross(x, third - first)
    return np.array([x, np.cross(z / length(z), x), z / length(z)]).T


def slope(function, at, direction, h=2e-3):
    """∂/∂direction by differences extrapolated to the order h⁶."""
    found = [(function(at + k * h * direction) - function(at - k * h * direction)) / (2 * k * h) for k in (1, 2, 3)]
    return 1.5 * found[0] - 0.6 * found[1] + 0.1 * found[2]


def gradient(at):
    return np.array([slope(lambda x: Closed(x).energy, at, unit) for unit in np.eye(2)])


def mass_and_damping(at):
    """Of the quadratic forms T and R in the coordinates' rates."""
    here = Closed(at)
    M = np.zeros((2, 2))
    points = [slope(lambda x: Closed(x).points, at, unit) for unit in np.eye(2)]
    coil = np.array([slope(lambda x: Closed(x).coil, at, unit) for unit in np.eye(2)])
    for i, v in enumerate(points):
        for j, w in enumerate(points):
            M[i, j] = sum(m * v[k] @ w[k] for k, m in enumerate(MASS.values()))
    for name, J in INERTIA.items():
        A = getattr(here, name)
        ω = []
        for unit in np.eye(2):
            spin = A.T @ slope(lambda x, name=name: getattr(Closed(x), name), at, unit)
            ω.append(np.array([spin[2, 1], spin[0, 2], spin[1, 0]]))
        M += np.array(ω) @ J @ np.array(ω).T
    return M, 3000.0 * np.outer(coil, coil)


@pytest.fixture(scope="module")
def static():
    found = fsolve(gradient, [-0.04, 0.1], xtol=1e-13)
    assert np.abs(gradient(found)).max() < 1e-6
    return found


@pytest.fixture(scope="module")
def rests():
    read = scene("quarter_car")
    system = compile_system(read)
    return equilibrium(system, assembled_start(read, system))


def test_it_sinks_as_its_energy_says(static, rests):
    """In metres and radians; and so its scene expects."""
    names = rests.reference.system.names.coordinates
    found = dict(zip(names, rests.reference.motion.expected, strict=True))
    assert_close(found["body.displacement"], static[0], 1e-9)
    assert_close(found["lower.angle"], static[1], 1e-9)
    assert rests.stable
    assert_close(expected("quarter_car", "sinks"), static[0], 1e-11)
    assert_close(expected("quarter_car", "lower_wishbone"), static[1], 1e-11)
    assert_close(expected("quarter_car", "lost"), Closed(np.zeros(2)).energy - Closed(static).energy, 1e-6)


def test_it_rides_and_its_wheel_hops_as_both_energies_say(static, rests):
    K = np.array([slope(gradient, static, unit) for unit in np.eye(2)])
    M, D = mass_and_damping(static)
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    λ = np.linalg.eigvals(A)
    λ = np.sort_complex(λ[λ.imag > 0])[::-1]
    found = modes(rests.reference)
    np.testing.assert_allclose(found.eigenvalues, λ, rtol=1e-8)
    np.testing.assert_allclose(found.frequencies, [1.1597, 11.216], rtol=1e-4)
    body, hop = (dict(zip(found.kinetic_names, shares, strict=True)) for shares in found.kinetic)
    assert body["body"] > 0.95
    assert hop["upright"] > 0.9
