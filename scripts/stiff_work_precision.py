"""Stiff mechanisms: error against work of implicit and explicit integrators, over dials of stiffness.

    python scripts/stiff_work_precision.py [--case NAME ...] [--tolerances 1e-4 1e-6] [--dials 1e6 1e8] [--until 0.2]

The cases: a four-bar whose coupler is held together by a bushing, the flyball governor with a stiff spring and damper,
a chain whose links stiff torsion springs hold in line, and a mass that sticks and slips on a belt by a regularised law
of friction. The error is the largest of all coordinates at ten times. The reference is radau5 at a tenth of the
tightest tolerance; how far esdirk4 is from it there says how certain it is.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from time import process_time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.observe.recorded import Block, Observation
from mbproj.errors import SimulationError
from mbproj.integrate import simulate
from mbproj.scene import read_scene, read_scene_text
from mbproj.scene.records import Scene, Settings
from mbproj.studies.measure.mechanism import Mechanism

MECHANISMS = Path(__file__).parents[1] / "mechanisms"
INTEGRATORS = ("esdirk4", "radau5", "dop853")
SAMPLES = 10


def four_bar(k: float) -> Scene:
    """Of 1e5 N/m as it is written."""
    return read_scene(MECHANISMS / "split_coupler.yaml", {"softness": str(1e5 / k)})


def governor(k: float) -> Scene:
    """With a damper in proportion."""
    return read_scene(MECHANISMS / "governor.yaml", {"stiffness": str(k), "damping": str(1e-3 * k)})


def chain(k: float, links: int = 4) -> Scene:
    """Links of 0.2 m and 0.1 kg from a pin, with torsion springs of k N m/rad and dampers of k/1000 between them."""
    inertia = "[1.0e-5, 3.4e-4, 3.4e-4]"
    bodies = [f"  b{i}: {{mass: 0.1, inertia: {inertia}, position: [{0.2 * i + 0.1}, 0, 0]}}" for i in range(links)]
    pin = "type: revolute, location: [{x}, 0, 0], axis: [0, 1, 0]"
    names = ["ground", *(f"b{i}" for i in range(links))]
    joints = [f"  J{i}: {{{pin.format(x=0.2 * i)}, bodies: [{names[i]}, b{i}]}}" for i in range(links)]
    law = f"type: torsion_spring_damper, stiffness: {k}, damping: {1e-3 * k}"
    forces = [f"  k{i}: {{{law}, joint: J{i}}}" for i in range(1, links)]
    parts = ["mbproj: 1\ngravity: [0, 0, -9.81]\nbodies:", *bodies, "joints:", *joints, "forces:", *forces]
    return read_scene_text("\n".join(parts) + "\n")


def belt(k: float) -> Scene:
    """A mass of 1 kg on a spring of 100 N/m, which a belt of 0.1 m/s carries away; k, in N s/m, is the slope of the law
    of friction."""
    law = f"-100*displacement - 5*tanh((displacement_dot - 0.1)*{k / 5.0})"
    return read_scene_text(
        "mbproj: 1\ngravity: [0, 0, 0]\n"
        "bodies: {mass: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}\n"
        "joints: {rail: {type: prismatic, bodies: [ground, mass], location: [0, 0, 0], axis: [1, 0, 0]}}\n"
        f'forces: {{friction: {{type: linear_spring_damper, joint: rail, force: "{law}"}}}}\n'
    )


CASES: dict[str, Callable[[float], Scene]] = {
    "four-bar": four_bar,
    "governor": governor,
    "chain": chain,
    "belt": belt,
}


@dataclass(frozen=True, eq=False)
class Outcome:
    """Coordinates at the samples, (T, 7n), and what they cost; `closure`: the largest of |C| and |C'|."""

    q: Array
    steps: int
    rejected: int
    evaluations: int
    closure: float
    seconds: float


class _Coordinates:
    """A recorder of q."""

    def __init__(self) -> None:
        self.blocks: list[Array] = []

    def write(self, block: Block) -> None:
        """Takes T samples."""
        assert isinstance(block, Observation)
        self.blocks.append(block.samples.q)


def run(scene: Scene, until: float, integrator: str, tolerance: float) -> Outcome:
    """A run with error control. Raises SimulationError where it stops."""
    mechanism, recorder = Mechanism.of(scene), _Coordinates()
    settings = Settings(duration=until, output_step=until / SAMPLES, integrator=integrator, tolerance=tolerance)
    began = process_time()
    report = simulate(mechanism.system, mechanism.state, settings, recorder)
    seconds, counts = process_time() - began, report.counters
    closure = max(report.position_violation.value, report.velocity_violation.value)
    q = np.concatenate(recorder.blocks)
    return Outcome(q, counts["steps"], counts["rejected_steps"], counts["evaluations"], closure, seconds)


def table(case: str, k: float, until: float, tolerances: list[float]) -> Iterator[str]:
    """The rows of a case."""
    scene, tight = CASES[case](k), 0.1 * min(tolerances)
    reference, check = (run(scene, until, name, tight) for name in ("radau5", "esdirk4"))
    yield f"{case}, {k:.0e}: the reference is certain to {np.abs(reference.q - check.q).max():.1e}"
    for name in INTEGRATORS:
        for tolerance in tolerances:
            try:
                found = run(scene, until, name, tolerance)
            except SimulationError as stopped:
                yield f"  {name:8} {tolerance:7.0e}  {stopped}"
                continue
            error = np.abs(found.q - reference.q).max()
            yield (
                f"  {name:8} {tolerance:7.0e}  error {error:8.1e}  steps {found.steps:7,} "
                f"rejected {found.rejected:5,}  evaluations {found.evaluations:9,}  closed {found.closure:.0e}  "
                f"{found.seconds:7.2f} s"
            )


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--tolerances", nargs="+", type=float, default=[1e-4, 1e-6])
    parser.add_argument("--dials", nargs="+", type=float, default=[1e4, 1e6, 1e8, 1e10])
    parser.add_argument("--until", type=float, default=0.2)
    options = parser.parse_args()
    for case in options.case:
        for k in options.dials:
            for line in table(case, k, options.until, options.tolerances):
                print(line, flush=True)


if __name__ == "__main__":
    main()
