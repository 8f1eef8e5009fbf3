"""Many impacts in one run: whether joints stay closed, whether the energy stays, and what an impact costs.

    python scripts/many_impacts.py [--impacts N]

A pendulum swings between two rigid walls with restitution 1, with error control, in the plane and in space.
"""

from __future__ import annotations

import argparse
import sys
from time import perf_counter

import numpy as np

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate

SCENE = """
mbproj: 1
gravity: [0, -10, 0]
simulation: {{duration: {duration}, integrator: dop853, tolerance: 1.0e-12, output_step: {output}, formulation: {form}}}
bodies:
  bob: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, -1, 0]}}
joints:
  pivot:
    type: revolute
    bodies: [ground, bob]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    speed: 2
    limits: {{angle: {{range: [-0.1, 0.1], rigid: true, restitution: 1}}}}
"""
#: Between two impacts, about, s.
BETWEEN = 0.1009


class Kept:
    """What is asked of the run."""

    def __init__(self) -> None:
        self.energy: list[float] = []
        self.open = 0.0
        self.impacts = 0

    def write(self, block):  # type: ignore[no-untyped-def]
        self.energy += block["diagnostics/total_energy"].tolist()
        self.open = max(self.open, float(block["joints/violation"].max()))

    def events(self, events):  # type: ignore[no-untyped-def]
        self.impacts = sum(event.kind == "impact" for event in events)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--impacts", type=int, default=100_000)
    given = parser.parse_args()
    duration = BETWEEN * given.impacts
    for form in ("planar", "reduced"):
        scene = read_scene_text(SCENE.format(duration=duration, output=duration / 1000, form=form))
        system, kept = compile_system(scene), Kept()
        start = assemble(system, initial_guess(scene, system))
        began = perf_counter()
        simulate(system, start, settings_to_run(scene), kept)
        seconds = perf_counter() - began
        drift = np.abs(np.array(kept.energy) - kept.energy[0]).max() / 2.0
        print(
            f"{form:8s} {kept.impacts} impacts, {1e3 * seconds / kept.impacts:.2f} ms each; the joint is open by "
            f"{kept.open:.1e} m at most, the energy drifts by {drift:.1e} of itself"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
