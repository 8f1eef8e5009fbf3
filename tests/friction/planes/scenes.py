"""A box on feet: more of them than rigid bodies can say the loads of."""

from __future__ import annotations

from tests.friction.known.mechanisms import STEPS

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
