"""A point that slides on a plane, and falls on it."""

from __future__ import annotations

from tests.friction.known.mechanisms import STEPS

PUCK = """
mbproj: 1
gravity: {gravity}
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  puck: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, {height}], velocity: {velocity}}}
forces:
  floor:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: puck, location: {{puck: [0, 0, 0]}}}}
    rigid: true
    restitution: {e}
    friction: {friction}
"""


def puck(
    friction, velocity, *, gravity=(0, 0, -10), duration=2.0, height=0, e=0, steps="dop853", formulation="reduced"
):
    return PUCK.format(
        friction=friction,
        velocity=list(map(float, velocity)),
        gravity=list(map(float, gravity)),
        duration=duration,
        height=height,
        e=e,
        steps=STEPS[steps],
        formulation=formulation,
    )
