"""Runs with events of contacts, whose cost is counted: in the plane and in space."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate

HEAD = """
mbproj: 1
gravity: [0, -10, 0]
simulation:
  {{duration: {duration}, integrator: dop853, tolerance: 1.0e-9, output_step: {duration}, formulation: {form}}}
"""
BALL = """
bodies:
  ball: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 1, 0]}
joints:
  flight:
    type: prismatic
    bodies: [ground, ball]
    location: [0, 1, 0]
    axis: [0, 1, 0]
    displacement: 1
    limits: {displacement: {range: [0, null], rigid: true, restitution: 1}}
"""
STICK_SLIP = """
bodies:
  belt: {mass: 3, inertia: [0.01, 0.3, 0.3], position: [0, 0, 0]}
  block: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0.05, 0]}
joints:
  drum: {type: prismatic, bodies: [ground, belt], location: [0, 0, 0], axis: [1, 0, 0]}
  contact: {type: prismatic, bodies: [belt, block], location: [0, 0.05, 0], axis: [1, 0, 0], speed: 0}
motions:
  belt: {joint: drum, displacement: 0.1 * t}
forces:
  spring: {type: spring_damper, points: {ground: [-0.25, 0.05, 0], block: [0, 0.05, 0]}, stiffness: 300}
  grip: {type: friction, joint: contact, coulomb: {force: 6, static: 9}}
"""
#: No row is redundant in space, so that the load of the guide is unique.
SLIDER_CRANK = """
bodies:
  crank: {mass: 1, inertia: [0.01, 0.01, 0.02], position: [0.1, 0, 0]}
  rod: {mass: 1, inertia: [0.01, 0.02, 0.02], position: [0.4, 0, 0]}
  block: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [0.6, 0, 0]}
joints:
  pin: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1]}
  knee: {type: spherical, bodies: [crank, rod], location: [0.2, 0, 0]}
  wrist: {type: universal, bodies: [rod, block], location: [0.6, 0, 0], axes: [[0, 0, 1], [0, 1, 0]]}
  guide: {type: prismatic, bodies: [ground, block], location: [0.6, 0, 0], axis: [1, 0, 0]}
motions:
  drive: {joint: pin, angle: 6 * t}
"""
#: In the plane friction by the load of the guide is unknown, as it depends on forces out of the plane.
BY_FORCE = SLIDER_CRANK + "forces: {rubbing: {type: friction, joint: guide, coulomb: {force: 4}}}"
BY_LOAD = SLIDER_CRANK + "forces: {rubbing: {type: friction, joint: guide, coulomb: {coefficient: 0.2}}}"
#: A scene, its formulation, and the duration of about ten events, s.
SCENES = {
    "a bouncing ball in the plane": (BALL, "planar", 10.0),
    "a bouncing ball in space": (BALL, "reduced", 10.0),
    "stick-slip in the plane": (STICK_SLIP, "planar", 3.0),
    "stick-slip in space": (STICK_SLIP, "reduced", 3.0),
    "a slider-crank's guide in the plane": (BY_FORCE, "planar", 5.0),
    "a slider-crank's guide in space": (BY_LOAD, "reduced", 5.0),
}


class Kept:
    """The instants of events, and the last counts."""

    def __init__(self) -> None:
        self.counts: dict[str, int] = {}

    def write(self, block: Any) -> None:
        names = ("steps", "evaluations", "projections", "rejected_steps")
        self.counts |= {name: int(block[f"diagnostics/{name}"][-1]) for name in names if f"diagnostics/{name}" in block}

    def events(self, events: Sequence[Any]) -> None:
        self.counts["events"] = len({event.time for event in events})


def run_events(name: str, times: int) -> dict[str, int]:
    """Run a scene so many times as long; how many events it had, and what it did."""
    text, form, duration = SCENES[name]
    scene = read_scene_text(HEAD.format(duration=times * duration, form=form) + text)
    system, kept = compile_system(scene), Kept()
    simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), kept)
    return kept.counts
