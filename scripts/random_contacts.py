"""Random scenes in which contacts, frictions, rolling and stiff forces stand side by side, by all kinds of steps.

    python scripts/random_contacts.py [--count 60] [--seed 0] [--minutes 10] [--keep FOLDER]

Each scene draws some of these: a chain on pins with dry friction, limits and springs; balls and wheels on a floor with
Stribeck friction; a box on feet that is pushed; a ball that rolls as a joint does; a bushing. It runs by a method that
is drawn, too, full or in fewer coordinates. It is asked that every run ends in a result or in a simulation's error.
`scripts/sanitize_kernel.py` runs them with the sanitizers, which ask more: that no index leaves its list. The scene
that runs is kept in the folder until it has ended. Exit code 1: something else was raised.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path
from time import monotonic

import numpy as np

import mbproj
from mbproj.errors import SimulationError

FLOOR = "plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}"
METHODS = ("radau5", "esdirk4", "auto", "dop853", "rk4")


class Draw:
    """A scene that grows."""

    def __init__(self, seed: int, number: int) -> None:
        self.rng = np.random.default_rng([seed, number])
        self.parts: dict[str, list[str]] = {"bodies": [], "joints": [], "forces": []}
        self.place = 0.0

    def some(self, part: float = 0.5) -> bool:
        """Whether something is in the scene."""
        return bool(self.rng.random() < part)

    def number(self, low: float, high: float) -> float:
        """A number with few digits."""
        return float(f"{self.rng.uniform(low, high):.4g}")

    def add(self, block: str, name: str, words: str) -> None:
        """Adds an entry."""
        self.parts[block].append(f"  {name}: {{{words}}}\n")

    def friction(self) -> str:
        """Coulomb's, with a static part, with Stribeck's."""
        μ = self.number(0.05, 0.6)
        static = f", static: {μ + self.number(0.0, 0.3):.4g}" if self.some() else ""
        stribeck = f", stribeck_speed: {self.number(0.02, 0.5)}" if static and self.some(0.8) else ""
        return f"friction: {{coefficient: {μ}{static}{stribeck}}}"

    def law(self) -> str:
        """A stop that is rigid or, without friction, compliant."""
        if self.some(0.8):
            return f"rigid: true, restitution: {self.number(0.0, 0.8) if self.some() else 0.0}, {self.friction()}"
        return f"stiffness: {self.number(1e3, 1e5)}, restitution: {self.number(0.3, 1.0)}"

    def chain(self) -> None:
        """Bars on pins from the ground, with friction, limits and springs."""
        x, length = self.place, self.number(0.1, 0.4)
        bars = int(self.rng.integers(1, 9))
        for k in range(bars):
            at = f"{x + k * length:.6g}"
            middle = f"{x + (k + 0.5) * length:.6g}"
            self.add("bodies", f"bar{k}", f"mass: 1, inertia: [0.001, 0.01, 0.01], position: [{middle}, 0, 4]")
            limits = (
                f", limits: {{angle: {{range: [-{self.number(0.01, 1.0)}, {self.number(0.01, 1.0)}], rigid: true}}}}"
            )
            joint = f"bodies: [{f'bar{k - 1}' if k else 'ground'}, bar{k}], location: [{at}, 0, 4]"
            tilt = "[0, 1, 0]" if self.some(0.8) else "[0, 1, 0.2]"
            self.add("joints", f"pin{k}", f"type: revolute, {joint}, axis: {tilt}{limits if self.some(0.3) else ''}")
            if self.some(0.4):
                loaded = f"coefficient: {self.number(0.05, 0.3)}, radius: 0.01"
                given = f"torque: {self.number(0.01, 2.0)}"
                self.add(
                    "forces",
                    f"rubs{k}",
                    f"type: friction, joint: pin{k}, coulomb: {{{loaded if self.some() else given}}}",
                )
            if self.some(0.3):
                k_, c = self.number(1.0, 1e4), self.number(0.0, 10.0)
                self.add(
                    "forces", f"spring{k}", f"type: torsion_spring_damper, joint: pin{k}, stiffness: {k_}, damping: {c}"
                )

    def rolls(self, name: str) -> None:
        """A ball, or a wheel that stands or leans, on the floor or just above it."""
        r, x = self.number(0.05, 0.3), self.place
        wheel, up = self.some(), 1e-6 if self.some(0.7) else self.number(1e-4, 0.01)
        lean = self.number(0.0, 0.3) if wheel and self.some(0.3) else 0.0
        z = r * np.cos(lean) + up
        J = self.number(0.2, 0.6) * r * r
        v = [self.number(-2.0, 2.0) for _ in range(2)]
        w = [self.number(-5.0, 5.0) for _ in range(3)]
        self.add(
            "bodies",
            name,
            f"mass: 1, inertia: [{J:.6g}, {J * (1.5 if wheel else 1.0):.6g}, {J:.6g}], position: [{x}, 0, {z:.9g}], "
            f"orientation: {{axis: [1, 0, 0], angle: {lean}}}, velocity: [{v[0]}, {v[1]}, 0], angular_velocity: {w}",
        )
        axis = f", axis: {{{name}: [0, 1, 0]}}" if wheel else ""
        point = f"point: {{body: {name}, location: {{{name}: [0, 0, 0]}}}}, radius: {r}{axis}"
        self.add("forces", f"under_{name}", f"type: stop, {FLOOR}, {point}, {self.law()}")

    def joint_that_rolls(self) -> None:
        """A ball that rolls without slipping: rows at velocity level."""
        r, x = self.number(0.05, 0.3), self.place
        J = 0.4 * r * r
        self.add("bodies", "rolling", f"mass: 1, inertia: [{J:.6g}, {J:.6g}, {J:.6g}], position: [{x}, 2, {r}]")
        plane = "plane: {location: [0, 0, 0], normal: [0, 0, 1]}"
        self.add(
            "joints", "R", f"type: rolling_ball, bodies: [ground, rolling], {plane}, centre: [{x}, 2, {r}], radius: {r}"
        )

    def box(self) -> None:
        """A box on feet that a force pushes."""
        x, feet = self.place, int(self.rng.integers(1, 5))
        self.add("bodies", "box", f"mass: 2, inertia: [0.05, 0.05, 0.06], position: [{x}, -2, 0.1]")
        for k in range(feet):
            at = f"{{box: [{self.number(-0.3, 0.3)}, {self.number(-0.2, 0.2)}, -0.1]}}"
            self.add("forces", f"foot{k}", f"type: stop, {FLOOR}, point: {{body: box, location: {at}}}, {self.law()}")
        push = f'["{self.number(1, 30)}*sin({self.number(1, 60)}*t)", {self.number(-5, 5)}, 0]'
        self.add("forces", "push", f"type: force, body: box, location: [0, 0, 0], axes: global, force: {push}")

    def bushing(self) -> None:
        """A body on a bushing."""
        x = self.place
        self.add(
            "bodies", "held", f"mass: 1, inertia: [0.01, 0.02, 0.03], position: [{x}, 4, 1], velocity: [0.1, 0, 0.2]"
        )
        k = f"stiffness: {{translation: {[self.number(1e2, 1e6) for _ in range(3)]}, rotation: [50, 20, 400]}}"
        self.add("forces", "rubber", f"type: bushing, bodies: [ground, held], location: [{x}, 4, 1], {k}")

    def text(self) -> str:
        """The scene."""
        pieces = [self.chain, self.joint_that_rolls, self.box, self.bushing]
        pieces += [lambda name=f"roll{k}": self.rolls(name) for k in range(3)]  # type: ignore[misc]
        chosen = [piece for piece in pieces if self.some(0.4)] or [self.box]
        for piece in chosen:
            piece()
            self.place += 4.0
        method = METHODS[int(self.rng.integers(len(METHODS)))]
        steps = "step: 1 ms" if method == "rk4" or (self.some(0.2) and method != "auto") else "tolerance: 1e-6"
        form = "full" if self.some(0.15) else "auto"
        head = f"duration: 0.1, {steps}, integrator: {method}, formulation: {form}, output_step: 0.02"
        blocks = "".join(f"{block}:\n{''.join(words)}" for block, words in self.parts.items() if words)
        return f"mbproj: 1\ngravity: [0, 0, -9.81]\nsimulation: {{{head}}}\n{blocks}"


def main() -> int:
    """Runs the scenes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=10.0, help="no more are begun after that time")
    parser.add_argument("--keep", type=Path, default=Path("build/random_contacts"))
    asked = parser.parse_args()
    asked.keep.mkdir(parents=True, exist_ok=True)
    ends: Counter[str] = Counter()
    end = monotonic() + 60.0 * asked.minutes
    for number in range(asked.count):
        if monotonic() > end:
            break
        path = asked.keep / f"{asked.seed}_{number:04}.yaml"
        path.write_text(Draw(asked.seed, number).text(), encoding="utf-8")
        try:
            mbproj.run(path)
            ends["done"] += 1
        except SimulationError as failed:
            ends["refused"] += 1
            print(f"{path.name}: {str(failed).splitlines()[0]}", flush=True)
        except Exception as failed:
            ends["raised"] += 1
            print(f"{path}: {type(failed).__name__}: {failed}", flush=True)
            continue
        path.unlink()
    print(", ".join(f"{count} {what}" for what, count in ends.items()))
    return int(ends["raised"] > 0)


if __name__ == "__main__":
    sys.exit(main())
