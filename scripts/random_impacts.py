"""Random impacts with friction: how many each law of impact refuses, and whether the others keep what an impact must.

    python scripts/random_impacts.py [--count 200] [--seed 0] [--law newton poisson energetic] [--keep FOLDER]

Boxes that fall on corners and edges in the plane and in space, plates on three feet, and double pendulums that land on
their tip with a stop in the knee; masses, poses, speeds, restitutions and coefficients of friction are drawn. Scene
number n of a seed is the same for any count. Of each run that ends it is checked that, within the error of its steps,
the energy never grows, no gap is passed, no stop pushes across a gap, and no impulse pulls. The exit code
is 1 where a check fails by the first law named, or where that refuses more than 1 scene of 100.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.base.errors import SimulationError
from mbproj.base.registry import IMPACT_LAWS

Numbers = NDArray[np.float64]
#: What counts as round-off and errors of steps, of the largest energy, of m, and of N.
NEAR = 1e-6
HEAD = """mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: {duration}, integrator: dop853, tolerance: 1.0e-9, output_step: 0.01, impact_law: {law}}}
"""
FLOOR = "plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}"


@dataclass
class Kept:
    """What is asked of a run."""

    energy: list[float] = field(default_factory=list)
    kinetic: float = 0.0
    gap: float = np.inf
    across: float = 0.0
    impulse: float = np.inf
    impacts: int = 0

    def write(self, block):  # type: ignore[no-untyped-def]
        self.energy += block["diagnostics/total_energy"].tolist()
        self.kinetic = max(self.kinetic, float(block["diagnostics/kinetic_energy"].max()))
        gap, force = block["stops/gap"], block["stops/force"]
        self.gap = min(self.gap, float(gap.min()))
        self.across = max(self.across, float(force[gap > NEAR].max(initial=0.0)))

    def events(self, events):  # type: ignore[no-untyped-def]
        struck = [event for event in events if event.kind in ("impact", "push")]
        self.impacts = len(struck)
        self.impulse = min((event.impulse for event in struck), default=np.inf)

    def faults(self) -> Iterator[str]:
        """What does not hold."""
        scale = max(self.kinetic, np.ptp(self.energy), 1e-3)
        growth = float(np.diff(self.energy).max(initial=0.0))
        if growth > NEAR * scale:
            yield f"the energy grows by {growth:.2g} of {scale:.2g} J"
        if self.gap < -NEAR:
            yield f"a gap is {self.gap:.2g} m"
        if self.across > NEAR:
            yield f"a stop pushes with {self.across:.2g} N across a gap"
        if self.impulse < 0.0:
            yield f"an impulse is {self.impulse:.2g} N s"


def foot(name: str, body: str, at: Numbers, e: float, friction: float) -> str:
    """A rigid stop of a point of a body on the floor."""
    place = ", ".join(f"{x:.6f}" for x in at)
    return (
        f"  {name}: {{type: stop, {FLOOR}, point: {{body: {body}, location: {{{body}: [{place}]}}}}, rigid: true, "
        f"restitution: {e:.4f}, friction: {friction:.4f}}}\n"
    )


def turned(axis: Numbers, angle: float) -> tuple[str, Numbers]:
    """The words of an orientation, and its matrix."""
    unit = axis / np.linalg.norm(axis)
    x, y, z = unit
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    matrix = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    words = ", ".join(f"{float(u)!r}" for u in axis)
    return f"{{axis: [{words}], angle: {angle!r}}}", matrix


def thrown(rng: np.random.Generator, corners: Numbers, sizes: Numbers, turn: tuple[str, Numbers], plane: bool) -> str:
    """A body above the floor, that moves towards it."""
    mass = 10.0 ** rng.uniform(-1, 1)
    words, matrix = turn
    squares = sizes**2
    inertia = mass / 12.0 * (squares.sum() - squares)
    z = float(-(corners @ matrix.T)[:, 2].min()) + rng.uniform(0.0005, 0.1)
    v, w = rng.normal(size=3) * [2.0, 2.0, 1.0], rng.normal(size=3) * 3.0
    if plane:
        v[1] = w[0] = w[2] = 0.0
    v[2] = -abs(v[2])
    moving = f"velocity: {[round(float(u), 6) for u in v]}, angular_velocity: {[round(float(u), 6) for u in w]}"
    inertias = [float(f"{u:.6g}") for u in inertia]
    return (
        f"bodies:\n  body: {{mass: {mass:.6f}, inertia: {inertias}, position: [0, 0, {z:.6f}], "
        f"orientation: {words}, {moving}}}\n"
    )


def box(rng: np.random.Generator) -> str:
    """A box on corners of one restitution; half of them in the plane."""
    plane = rng.random() < 0.5
    sizes = rng.uniform(0.1, 0.6, 3)
    signs = product((-0.5, 0.5), (0.0,) if plane else (-0.5, 0.5), (-0.5, 0.5))
    corners = np.array(list(signs)) * sizes
    flat = rng.random() < 0.3
    angle = 0.0 if flat else float(rng.uniform(-1.5, 1.5))
    axis = np.array([0.0, 1.0, 0.0]) if plane else rng.normal(size=3)
    text = thrown(rng, corners, sizes, turned(axis, angle), plane)
    if plane:
        text += "joints:\n  P: {type: planar, bodies: [ground, body], location: [0, 0, 0], axis: [0, 1, 0]}\n"
    e, friction = rng.choice([0.0, rng.uniform(0.1, 0.95)]), rng.uniform(0.05, 1.2)
    return text + "forces:\n" + "".join(foot(f"c{k}", "body", at, e, friction) for k, at in enumerate(corners))


def plate(rng: np.random.Generator) -> str:
    """A plate on three feet, each with a restitution of its own."""
    around = np.sort(rng.uniform(0.0, 2.0 * np.pi, 3))
    if np.diff(around, append=around[0] + 2.0 * np.pi).max() > 0.9 * np.pi:
        around = np.array([0.1, 2.2, 4.2]) + rng.uniform(-0.3, 0.3, 3)
    radius = rng.uniform(0.15, 0.4)
    feet = np.stack([radius * np.cos(around), radius * np.sin(around), np.full(3, -rng.uniform(0.02, 0.3))], axis=1)
    lean = 0.0 if rng.random() < 0.3 else float(rng.normal() * 0.4)
    text = thrown(rng, feet, np.array([0.5, 0.4, 0.05]), turned(rng.normal(size=3) * [1, 1, 0.2], lean), False)
    same = rng.random() < 0.5
    e, friction = rng.uniform(0.0, 0.9, 3), rng.uniform(0.05, 1.2)
    return (
        text
        + "forces:\n"
        + "".join(foot(f"f{k}", "body", at, e[0] if same else e[k], friction) for k, at in enumerate(feet))
    )


def pendulum(rng: np.random.Generator) -> str:
    """A double pendulum above a floor, on which its tip lands; its knee has a rigid stop at each end of its range."""
    lengths, masses = rng.uniform(0.3, 0.8, 2), 10.0 ** rng.uniform(-1, 1, 2)
    hip = float(rng.uniform(0.5, 0.95)) * float(lengths.sum())
    first = float(rng.uniform(0.2, 1.3))
    low, high = -float(rng.uniform(0.02, 0.6)), float(rng.uniform(0.02, 0.6))
    knee = float(rng.uniform(0.8 * low, 0.8 * high))
    ends = [np.array([0.0, 0.0, hip])]
    for length, angle in zip(lengths, (first, first + knee), strict=True):
        ends.append(ends[-1] + length * np.array([np.cos(angle), 0.0, np.sin(angle)]))
    bodies = "bodies:\n"
    for k, angle in enumerate((first, first + knee)):
        middle, J = 0.5 * (ends[k] + ends[k + 1]), masses[k] * lengths[k] ** 2 / 12.0
        place = [round(float(x), 9) for x in middle]
        bodies += (
            f"  bar{k}: {{mass: {masses[k]:.6f}, inertia: [{J / 50:.8f}, {J:.8f}, {J:.8f}], position: {place}, "
            f"orientation: {{axis: [0, 1, 0], angle: {-angle!r}}}}}\n"
        )
    at = [round(float(x), 9) for x in ends[1]]
    e = rng.choice([0.0, rng.uniform(0.1, 0.9)], 3)
    friction = rng.uniform(0.05, 1.2)
    spins = [round(float(w), 6) for w in rng.normal(size=2) * 2.0]
    tip = np.array([0.5 * lengths[1], 0.0, 0.0])
    return (
        bodies
        + f"""joints:
  hip: {{type: revolute, bodies: [ground, bar0], location: [0, 0, {hip!r}], axis: [0, 1, 0], speed: {spins[0]}}}
  knee:
    type: revolute
    bodies: [bar0, bar1]
    location: {at}
    axis: [0, 1, 0]
    speed: {spins[1]}
    limits: {{angle: {{range: [{-high - 0.0!r}, {-low!r}], rigid: true, restitution: {e[0]:.4f}}}}}
forces:
"""
        + foot("tip", "bar1", tip, e[1], friction)
        + foot("joint", "bar1", -tip, e[2], friction)
    )


KINDS = {"boxes": (box, 1.0), "plates": (plate, 1.0), "pendulums": (pendulum, 2.0)}


def scene(seed: int, number: int, law: str) -> tuple[str, str]:
    """The kind of a scene, and its text."""
    kind = list(KINDS)[number % len(KINDS)]
    make, duration = KINDS[kind]
    return kind, HEAD.format(duration=duration, law=law) + make(np.random.default_rng([seed, number]))


def examine(text: str) -> tuple[str, Kept]:
    """Why a run is refused, or nothing; and what was kept of it."""
    parsed, kept = read_scene_text(text), Kept()
    system = compile_system(parsed)
    try:
        simulate(system, assemble(system, initial_guess(parsed, system)), settings_to_run(parsed), kept)
    except SimulationError as failed:
        return str(failed).splitlines()[0], kept
    return "", kept


def campaign(law: str, seed: int, count: int, folder: Path | None) -> tuple[int, int]:
    """How many scenes a law refuses, and in how many a check fails."""
    refused, wrong, causes, impacts = 0, 0, Counter[str](), 0
    for number in range(count):
        kind, text = scene(seed, number, law)
        why, kept = examine(text)
        impacts += kept.impacts
        faults = [] if why else list(kept.faults())
        refused, wrong = refused + bool(why), wrong + bool(faults)
        for said in [*([why] if why else []), *faults]:
            print(f"  {law} {kind} {number}: {said}", flush=True)
        if why:
            causes[f"{kind}: " + ("energy" if "create" in why else "driven" if "driven" in why else "other")] += 1
        if folder and (why or faults):
            folder.mkdir(parents=True, exist_ok=True)
            (folder / f"{law}_{kind}_{seed}_{number:04}.yaml").write_text(text, encoding="utf-8")
    told = "".join(f"; {cause} {many}" for cause, many in causes.most_common())
    print(f"{law}: {refused} of {count} refused, {wrong} wrong, {impacts} impacts{told}", flush=True)
    return refused, wrong


def main() -> int:
    """Runs each law on the same scenes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--law", nargs="+", choices=IMPACT_LAWS, default=["energetic", "newton", "poisson"])
    parser.add_argument("--keep", type=Path, help="where scenes that are refused or wrong are kept")
    asked = parser.parse_args()
    found = [campaign(law, asked.seed, asked.count, asked.keep) for law in asked.law]
    refused, wrong = found[0]
    return int(wrong > 0 or refused > 0.01 * asked.count)


if __name__ == "__main__":
    sys.exit(main())
