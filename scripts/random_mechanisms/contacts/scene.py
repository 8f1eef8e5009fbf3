"""What the families draw of: loads, frictions, settings, a direction of the whole scene; and the text of a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import sin
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.model.euler_parameters import rotation_matrix

from ..drawing import flow, short
from .independent import Law, Solution

GRAVITY = 9.81
#: Integrators with their settings; each scene has one of them.
INTEGRATORS = {
    "dop853": {"tolerance": 1e-9},
    "radau5": {"tolerance": 1e-8},
    "esdirk4": {"tolerance": 1e-7},
    "auto": {"tolerance": 1e-8},
    "rk4": {"step": 1e-3},
}
OUTPUT_STEP = 0.01


@dataclass(frozen=True)
class Watched:
    """What is compared: a dataset, the name of its column, and the direction of a vector in it."""

    dataset: str
    item: str
    direction: tuple[float, ...] = ()
    label: str = ""

    def __str__(self) -> str:
        return self.label or f"{self.dataset} of '{self.item}'"


@dataclass(frozen=True)
class Case:
    """A scene, its independent solution at given times, and what is compared."""

    family: str
    text: str
    settings: dict[str, Any]
    solve: Callable[[Array], Solution]
    watched: tuple[Watched, ...]
    #: Frictions, by the name of their stop.
    laws: dict[str, Law]

    @property
    def integrator(self) -> str:
        return str(self.settings["integrator"])

    @property
    def duration(self) -> float:
        return float(self.settings["duration"])


@dataclass(frozen=True)
class Load:
    """a + b t + c sin(w t + p), in N or N m."""

    a: float
    b: float = 0.0
    c: float = 0.0
    w: float = 0.0
    p: float = 0.0

    def __call__(self, t: float) -> float:
        return self.a + self.b * t + self.c * sin(self.w * t + self.p)

    def __str__(self) -> str:
        return f"({self.a!r} + {self.b!r}*t + {self.c!r}*sin({self.w!r}*t + {self.p!r}))"


class Draw:
    """Draws from a seed, and turns the scene: half of the scenes stand upright, the others anyhow."""

    def __init__(self, family: str, seed: int) -> None:
        self.rng = np.random.default_rng([seed, *family.encode()])
        self.name = f"{family} {seed}"
        #: The power of ten of the least of Stribeck's speeds, m/s: what fixed steps pass in some of them, not in one.
        self.finest = -2.0
        self.turn = np.eye(3)
        if self.chance(0.5):
            quaternion = self.rng.normal(size=4)
            self.turn = rotation_matrix(quaternion / np.linalg.norm(quaternion))

    def number(self, low: float, high: float) -> float:
        return short(self.rng.uniform(low, high))

    def decades(self, low: float, high: float) -> float:
        """10 to a power between the two."""
        return short(10.0 ** self.rng.uniform(low, high))

    def chance(self, part: float) -> bool:
        return bool(self.rng.uniform() < part)

    def pick(self, *of: Any) -> Any:
        return of[int(self.rng.integers(len(of)))]

    def load(self, scale: float, begins: float = 1.0) -> Load:
        """Of this size in its course; `begins` bounds the value at the start, over the size."""
        c, p = scale * self.number(-1, 1), self.number(-3, 3)
        begin = scale * begins * self.number(-1, 1) - c * sin(p)
        return Load(short(begin), short(scale * self.number(-3, 3)), short(c), self.number(3, 20), p)

    def law(self, plain: bool = False) -> Law:
        """A friction; `plain`: as much sliding as sticking."""
        mu = self.number(0.1, 0.7)
        if plain or self.chance(0.4):
            return Law(mu, mu)
        return Law(mu, short(mu * self.rng.uniform(1.05, 1.6)), self.pick(0.0, self.decades(self.finest, 0)))

    def to_global(self, *vector: float) -> list[float]:
        """Of the scene's own axes: x and y along the floor, z up."""
        return [float(x) + 0.0 for x in self.turn @ np.array(vector, dtype=float)]

    def watch(self, dataset: str, item: str, *direction: float) -> Watched:
        label = f"{dataset} of '{item}' along {flow(direction)}"
        return Watched(dataset, item, tuple(self.to_global(*direction)), label)

    def components(self, *loads: object) -> list[str]:
        """Expressions of a vector with these components along the scene's axes, each a load or a number."""
        return [" + ".join(f"{row[k]!r}*{loads[k]}" for k in range(3) if row[k]) for row in self.turn.tolist()]

    def stop(self, body: str, point: list[float], law: Law | None, **keys: Any) -> dict[str, Any]:
        """A rigid stop of a point on the floor z = 0; with `on` the body that has the floor."""
        floor = {"body": keys.pop("on", "ground"), "location": [0.0] * 3, "normal": self.to_global(0, 0, 1)}
        rigid = {} if "stiffness" in keys else {"rigid": "true"}
        rubs = {} if law is None else {"friction": law.keys()}
        found = {"type": "stop", "plane": floor, "point": {"body": body, "location": self.to_global(*point)}}
        return found | rigid | rubs | keys

    def settings(self, duration: float) -> dict[str, Any]:
        name = self.pick(*INTEGRATORS)
        self.finest = -1.0 if "step" in INTEGRATORS[name] else -2.0
        formulation = self.pick(*["auto"] * 16, *["reduced"] * 3, "full")
        if formulation == "full":  # NumPy evaluates it: a hundred times as long
            duration *= 0.2
        return {
            "duration": short(duration),
            "output_step": OUTPUT_STEP,
            "integrator": name,
            **INTEGRATORS[name],
            "formulation": formulation,
        }


def scene_text(draw: Draw, settings: dict[str, Any], gravity: list[float], **blocks: Mapping[str, Any]) -> str:
    """YAML of a scene, with an entry of a block in each line."""
    text = f"mbproj: 1\ntitle: Random {draw.name}\ngravity: {flow(gravity)}\nsimulation: {flow(settings)}\n"
    for block, entries in blocks.items():
        if entries:
            text += f"{block}:\n" + "".join(f"  {name}: {flow(entry)}\n" for name, entry in entries.items())
    return text


def times(duration: float) -> Array:
    """Of the samples."""
    return OUTPUT_STEP * np.arange(int(duration / OUTPUT_STEP + 1e-6) + 1, dtype=float)
