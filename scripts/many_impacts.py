"""Many impacts in one run: whether joints stay closed, whether the energy stays, and what an impact costs.

    python scripts/many_impacts.py [--impacts N] [--cycles N]

A pendulum swings between two rigid walls with restitution 1, with error control, in the plane and in space. Then boxes
with friction are pushed to and fro on one foot and on four: they slip and stick twice in each cycle.
"""

from __future__ import annotations

import argparse
import sys
from time import process_time

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
PUSHED = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: {duration}, integrator: dop853, tolerance: 1.0e-9, output_step: 1, formulation: reduced}}
bodies:
  box: {{mass: 3, inertia: [0.1, 0.15, 0.12], position: [0, 0, 0]}}
forces:
{feet}
  push: {{type: force, body: box, location: [0, 0, 0], axes: global, force: ["14*sin(6*t)", 0, 0]}}
"""
FOOT = """  {name}:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: box, location: [{x}, {y}, 0]}}
    rigid: true
    friction: {{coefficient: 0.3, static: 0.4}}
"""
FEET = {
    "one foot": {"a": (0.0, 0.0)},
    "four feet": {"a": (0.3, 0.25), "b": (-0.35, 0.25), "c": (-0.35, -0.25), "d": (0.3, -0.25)},
}
#: Between two impacts, about, s.
BETWEEN = 0.1009


class Kept:
    """What is asked of the run."""

    def __init__(self) -> None:
        self.energy: list[float] = []
        self.open = 0.0
        self.impacts = 0
        self.instants = self.steps = 0

    def write(self, block):  # type: ignore[no-untyped-def]
        self.energy += block["diagnostics/total_energy"].tolist()
        self.steps = int(block["diagnostics/steps"][-1])
        self.open = max(self.open, float(block["joints/violation"].max(initial=0.0)))

    def events(self, events):  # type: ignore[no-untyped-def]
        self.impacts = sum(event.kind == "impact" for event in events)
        self.instants = len({event.time for event in events})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--impacts", type=int, default=100_000)
    parser.add_argument("--cycles", type=int, default=300)
    given = parser.parse_args()
    duration = BETWEEN * given.impacts
    for form in ("planar", "reduced"):
        seconds, kept, _ = timed(SCENE.format(duration=duration, output=duration / 1000, form=form))
        drift = np.abs(np.array(kept.energy) - kept.energy[0]).max() / 2.0
        print(
            f"{form:8s} {kept.impacts} impacts, {1e3 * seconds / kept.impacts:.2f} ms each; the joint is open by "
            f"{kept.open:.1e} m at most, the energy drifts by {drift:.1e} of itself"
        )
    for name, feet in FEET.items():
        rubs(name, feet, given.cycles)
    return 0


def timed(text: str) -> tuple[float, Kept, int]:
    """Processor seconds of a run, what it kept, and its steps."""
    scene = read_scene_text(text)
    system, kept = compile_system(scene), Kept()
    start = assemble(system, initial_guess(scene, system))
    began = process_time()
    simulate(system, start, settings_to_run(scene), kept)
    return process_time() - began, kept, kept.steps


def rubs(name: str, feet: dict[str, tuple[float, float]], cycles: int) -> None:
    """What an instant costs at which a box on feet slips or sticks, with the steps between two of them."""
    places = "".join(FOOT.format(name=foot, x=x, y=y) for foot, (x, y) in feet.items())
    found = [timed(PUSHED.format(duration=cycles * np.pi / 3.0 * part, feet=places)) for part in (0.5, 1.0)]
    (first, few, some), (seconds, kept, steps) = found
    more = kept.instants - few.instants
    print(
        f"{name:9s} {kept.instants} instants, {1e6 * (seconds - first) / more:.0f} µs each with the "
        f"{(steps - some) / more:.1f} steps before it"
    )


if __name__ == "__main__":
    sys.exit(main())
