"""Bodies on planes with friction: beams on points, tables on feet, pucks."""

from __future__ import annotations

import numpy as np

from tests.friction.mechanisms import STEPS
from tests.laws import Cone

# A box on feet: more of them than rigid bodies can say the loads of.

IN_PLANE = "P: {type: planar, bodies: [ground, box], location: [0, 0, 0], axis: [0, 1, 0]}"
SCENE = """
mbproj: 1
gravity: {gravity}
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  box: {{mass: 3, inertia: [0.1, 0.15, 0.12], position: [0, 0, 0.25], velocity: {velocity}, angular_velocity: {spin}}}
joints: {{{joint}}}
forces:
{feet}
  push: {{type: force, body: box, location: [0, 0, {height}], axes: global, force: {force}}}
"""
FOOT = """  {name}:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: box, location: [{x}, {y}, 0]}}
    rigid: true
    friction: {friction}
"""
CORNERS = {"a": (0.3, 0.25), "b": (-0.35, 0.25), "c": (-0.35, -0.25), "d": (0.3, -0.25)}


def box(
    places,
    friction,
    *,
    velocity=(0, 0, 0),
    spin=(0, 0, 0),
    push=0,
    force=None,
    height=0.25,
    duration=1.0,
    joint="",
    formulation="auto",
    steps="dop853",
    gravity=(0, 0, -10),
):
    """`friction` of all feet, or of each by its name."""
    of = friction if isinstance(friction, dict) else dict.fromkeys(places, friction)
    feet = (FOOT.format(name=name, x=x, y=y, friction=of[name]) for name, (x, y) in places.items())
    return SCENE.format(
        gravity=list(map(float, gravity)),
        feet="".join(feet),
        velocity=list(map(float, velocity)),
        spin=list(map(float, spin)),
        force=force or f'["{push}*t", 0, 0]',
        height=height,
        duration=duration,
        joint=joint,
        formulation=formulation,
        steps=STEPS[steps],
    )


# Beams on points under them, as rows of contacts.

MASS, INERTIA, WEIGHT, HEIGHT = 3.0, 0.2, 30.0, 0.25


def beam(places, force, arm):
    """B and b of a beam on points under it: rows of the gaps, then of what slides along; pushed at an `arm` above."""
    gaps = np.array([[0.0, 1.0, x] for x in places])
    along = np.array([[1.0, 0.0, HEIGHT] for _ in places])
    rows = np.vstack([gaps, along])
    inverse = np.diag([1.0 / MASS, 1.0 / MASS, 1.0 / INERTIA])
    return rows @ inverse @ rows.T, rows @ inverse @ [force, -WEIGHT, -force * arm]


def feet(count, most, slides=()):
    return [Cone(k, (count + k,), most, slides) for k in range(count)]


# A point that slides on a plane, and falls on it.

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
