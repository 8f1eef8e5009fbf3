"""A scene with stops of every kind."""

from __future__ import annotations

#: A door whose angle is 40°, a block 0.3 m up a slide, and a ball in free flight 1 m above the block.
SCENE = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {softness: 2e5 N/mm^1.5}
simulation: {duration: 1, step: 1 ms}
bodies:
  block: {mass: 3, inertia: [1, 1, 1], position: [2, 0, 0], orientation: {axis: [1, 0, 0], angle: 50 deg}}
  door: {mass: 2, inertia: [1, 1, 1], position: [0.5, 0, 0]}
  ball: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 1.3], orientation: {axis: [0, 1, 0], angle: 90 deg}}
  plate: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0.1]}
joints:
  weld: {type: fixed, bodies: [block, plate], location: [2, 0, 0]}
  hinge:
    type: revolute
    bodies: [ground, door]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    angle: 40 deg
    limits: {angle: {range: [-30 deg, 95 deg], stiffness: 4 N*m/rad^1.5, exponent: 3/2, restitution: 0.4}}
  rail:
    type: cylindrical
    bodies: [ground, block]
    location: [2, 0, 0]
    axis: [0, 0, 1]
    displacement: 0.3
    angle: 0
    limits: {displacement: {range: [null, 0.5], rigid: true}, angle: {range: [-7, null], stiffness: 2, damping: 3}}
forces:
  rope: {type: stop, points: {ground: [2, 0, 5], ball: [2, 0, 1.3]}, longest: 5 m, stiffness: softness, exponent: 1.5}
  gap: {type: stop, bodies: [ball, door], locations: {ball: [0, 0, 0], door: [0, 0, 0]}, shortest: 10 cm, longest: 4,
    rigid: true, restitution: 0.5}
  lid:
    type: stop
    plane: {body: plate, location: {plate: [0, 0, 0.05]}, normal: {plate: [0, 0, 2]}}
    point: {body: ball, location: {ball: [0.25, 0, 0]}}
    radius: 0.1
    stiffness: 7
"""


def resting_on_a_stop(mass: float, simulation: str, more: str = "") -> str:
    """A mass on a rail that stands up, which begins where it rests, pressed into a soft stop of 900 N/m."""
    return f"""\
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: 0.2 s, start: equilibrium, {simulation}}}
bodies: {{b: {{mass: {mass}, inertia: [1, 1, 1], position: [0, 0, 1]}}}}
joints:
  rail:
    type: prismatic
    bodies: [ground, b]
    location: [0, 0, 1]
    axis: [0, 0, 1]
    limits: {{displacement: {{range: [0, null], stiffness: 900}}}}
{more}"""
