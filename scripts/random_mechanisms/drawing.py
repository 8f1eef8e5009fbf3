"""Random places, directions and bodies: in space, or in a plane of random normal."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.model.euler_parameters import rotation_matrix


def flow(value: Any) -> str:
    """A value as YAML writes it in a line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {flow(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list | tuple | np.ndarray):
        return "[" + ", ".join(flow(entry) for entry in value) + "]"
    return repr(float(value)) if isinstance(value, float) else str(value)


def short(value: float) -> float:
    """To four digits, so that a scene can be read."""
    return float(f"{value:.4g}")


class Drawing:
    """Draws from a seed; `flat`: at any depth, but for motions in the plane of the first two columns of `turn`."""

    def __init__(self, seed: int, flat: bool) -> None:
        self.rng, self.flat = np.random.default_rng(seed), flat
        #: For what was added to the mechanisms of a seed: the rest of them stays as it was.
        self.added = np.random.default_rng([seed, 1])
        self.turn = np.eye(3)
        if flat and self.rng.uniform() < 0.5:
            quaternion = self.rng.normal(size=4)
            self.turn = rotation_matrix(quaternion / np.linalg.norm(quaternion))

    def number(self, low: float, high: float) -> float:
        """Between two bounds, to four digits."""
        return short(self.rng.uniform(low, high))

    def _global(self, vector: Array) -> list[float]:
        return [float(x) + 0.0 for x in self.turn @ vector]

    def place(self, depth: float | None = None) -> list[float]:
        """A point within 1 m, at this depth in a plane."""
        x, y, z = (self.number(-1, 1) for _ in range(3))
        return self._global(np.array([x, y, z if depth is None else depth]))

    def direction(self) -> list[float]:
        """Of the motion: any, or in the plane."""
        angle = self.rng.uniform(-np.pi, np.pi)
        z = 0.0 if self.flat else self.number(-1, 1)
        return self._global(np.array([short(np.cos(angle)), short(np.sin(angle)), z]))

    def axis(self) -> list[float]:
        """To turn about: any, or the normal."""
        return self._global(np.array([0.0, 0.0, 1.0])) if self.flat else self.direction()

    def normal_to(self, axis: list[float]) -> list[float]:
        """A direction of the motion at right angles to an axis."""
        return [float(x) for x in np.cross(axis, self.direction())]

    def body(self, decade: int) -> dict[str, Any]:
        """Of any pose and motion, a tenth to half a metre in size; its moments obey the triangle inequality."""
        mass = short(10.0**decade * self.rng.uniform(1, 10))
        axis, angle = [self.number(-1, 1) for _ in range(3)], self.number(-3, 3)
        turn = np.linalg.qr(self.rng.normal(size=(3, 3)))[0]
        a, b, c = mass * self.rng.uniform(0.1, 0.5, size=3) ** 2
        J = turn @ np.diag([b + c, a + c, a + b]) @ turn.T
        spin = self.rng.normal() * np.array(self.axis())
        unit = np.array(axis) / np.linalg.norm(axis)
        A = rotation_matrix(np.array([np.cos(angle / 2), *(np.sin(angle / 2) * unit)]))
        return {
            "mass": mass,
            "inertia": [short(J[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))],
            "position": self.place(),
            "orientation": {"axis": axis, "angle": angle},
            "velocity": self.direction(),
            "angular_velocity": [float(x) for x in A.T @ spin],
        }
