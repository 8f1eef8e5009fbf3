"""What every program is asked to compute: the paper's two mechanisms with their references, and chains."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROOT = Path(__file__).parents[2]
GRAVITY = 9.8
#: A bar of the five-bar pendulum and of the chains: m, kg, kg m² along and across.
LENGTH, MASS, ALONG, ACROSS = 1.0, 1.0, 0.01 / 6, 1.01 / 12
#: Links of the chains, and steps timed with each.
CHAIN_STEPS = {5: 200, 20: 200, 100: 100, 500: 20}


@dataclass(frozen=True)
class Mechanism:
    """A mechanism: what runs for `duration` s, the errors asked for (m), and where its reference stands."""

    name: str
    title: str
    scene: Path
    duration: float
    errors: tuple[float, ...]
    file: str
    columns: tuple[str, ...]

    @cached_property
    def reference(self) -> Array:
        """Rows (t, coordinates) of tests/data up to the duration, every half second, without the start."""
        table = np.genfromtxt(ROOT / "tests" / "data" / self.file, delimiter=",", names=True)
        rows = np.column_stack([table[name] for name in ("t", *self.columns)])
        return rows[(rows[:, 0] > 0.0) & (rows[:, 0] <= self.duration)]

    @property
    def times(self) -> Array:
        """The reference's times, s."""
        return self.reference[:, 0]

    @property
    def interval(self) -> float:
        """Between two of the reference's times, s."""
        return float(self.times[0])

    def error(self, points: Array) -> float:
        """The largest distance of points (T, columns) from the reference, m; infinite where they are not finite."""
        distances = np.linalg.norm(points.reshape(len(self.times), -1) - self.reference[:, 1:], axis=1)
        return float(distances.max()) if np.isfinite(distances).all() else np.inf


FIVE_BAR = Mechanism(
    "five_bar",
    "Five-bar pendulum, largest tip error up to 5 s",
    ROOT / "mechanisms" / "five_bar.yaml",
    5.0,
    (1e-3, 1e-5, 1e-7, 1e-9),
    "five_bar.csv",
    ("tip_x", "tip_z"),
)
SLIDER_CRANK = Mechanism(
    "spatial_slider_crank",
    "Spatial slider-crank, largest slider error up to 10 s",
    ROOT / "mechanisms" / "spatial_slider_crank.yaml",
    10.0,
    (1e-3, 1e-4, 1e-5, 1e-7, 1e-9),
    "slider_crank_comA.csv",
    ("slider_x",),
)
MECHANISMS = {mechanism.name: mechanism for mechanism in (FIVE_BAR, SLIDER_CRANK)}


@dataclass(frozen=True)
class Chain:
    """A planar chain of bars of 1 m that starts straight and level from rest, as the five-bar does."""

    links: int

    @property
    def steps(self) -> int:
        """How many steps are timed."""
        return CHAIN_STEPS.get(self.links, max(20, 10_000 // self.links))

    @cached_property
    def highest_frequency(self) -> float:
        """Of small oscillations about the hanging chain, rad/s."""
        n = np.arange(self.links)
        coupling = MASS * LENGTH**2 * (self.links - 0.5 - np.maximum.outer(n, n))
        coupling[n, n] = ACROSS + MASS * LENGTH**2 * (self.links - 0.75 - n)
        stiffness = np.sqrt(MASS * GRAVITY * LENGTH * (self.links - 0.5 - n))
        return float(np.sqrt(np.linalg.eigvalsh(stiffness[:, None] * np.linalg.inv(coupling) * stiffness)[-1]))

    @property
    def step(self) -> float:
        """A tenth of a radian of the highest frequency, s."""
        return 0.1 / self.highest_frequency


class SliderCrank:
    """The spatial slider-crank's numbers at its start (m, kg, kg m², rad/s), as mechanisms/ describes them."""

    PIVOT = np.array([0.0, 0.1, 0.12])
    BALL = np.array([0.0, 0.1, 0.2])
    SLIDER = np.array([0.2, 0.0, 0.0])
    ROD_CENTRE = (BALL + SLIDER) / 2
    #: Columns: along the rod from the ball to the slider; the pin of the universal joint; their normal.
    ROD_AXES = np.array(
        [
            [2 / 3, 0.0, -np.sqrt(5) / 3],
            [-1 / 3, -2 / np.sqrt(5), -2 / (3 * np.sqrt(5))],
            [-2 / 3, 1 / np.sqrt(5), -4 / (3 * np.sqrt(5))],
        ]
    )
    CRANK_LENGTH, ROD_LENGTH, SPEED = 0.08, 0.3, 6.0
    CRANK_MASS, ROD_MASS, SLIDER_MASS = 0.12, 0.5, 2.0
    CRANK_INERTIA = (1e-4, 1e-4, 1e-5)
    ROD_INERTIA = (4e-4, 4e-3, 4e-3)
    SLIDER_INERTIA = (1e-4, 1e-4, 1e-4)

    @classmethod
    def start_velocities(cls) -> tuple[float, float, float]:
        """Of the slider (m/s), and of the universal joint about the slider's x axis and the rod's pin (rad/s)."""
        ball = np.cross([cls.SPEED, 0.0, 0.0], cls.BALL - cls.PIVOT)
        arm = cls.BALL - cls.SLIDER
        x = np.array([1.0, 0.0, 0.0])
        columns = np.column_stack([x, np.cross(x, arm), np.cross(cls.ROD_AXES[:, 1], arm)])
        slider, about_x, about_pin = np.linalg.solve(columns, ball)
        return float(slider), float(about_x), float(about_pin)
