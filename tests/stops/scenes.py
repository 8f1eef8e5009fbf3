"""Scenes with stops."""

from __future__ import annotations

# A scene with stops of every kind.

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


# Scenes with stops without friction, which the kernel's loop meets itself.

BALL = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  ball: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 1], velocity: [1, 0, 0]}}
forces:
  floor:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: ball, location: [0, 0, 1]}}
    rigid: true
    restitution: {e}
"""

#: A rod on a hinge, without weight, that turns towards a stop below a point of it.
ROD = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 1, {steps}, formulation: {formulation}}}
bodies:
  rod: {{mass: 3, inertia: [0.01, 0.25, 0.25], position: [0.5, 0, 0]}}
joints:
  hinge: {{type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 0, 1], angle: 0, speed: -2}}
forces:
  rest:
    type: stop
    plane: {{body: ground, location: [0, -0.4, 0], normal: [0, 1, 0]}}
    point: {{body: rod, location: [0.8, 0, 0]}}
    rigid: true
    restitution: 0.5
"""

CRADLE = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 1, {steps}, formulation: {formulation}}}
bodies:
  first: {{mass: 1, inertia: [1, 1, 1], position: [-0.5, 0, 0], velocity: [2, 0, 0]}}
  second: {{mass: 1, inertia: [1, 1, 1], position: [0.1, 0, 0]}}
  third: {{mass: 1, inertia: [1, 1, 1], position: [{third}, 0, 0]}}
forces:
  left:
    type: stop
    points: {{first: [-0.5, 0, 0], second: [0.1, 0, 0]}}
    shortest: 0.1
    rigid: true
    restitution: {e}
  right:
    type: stop
    points: {{second: [0.1, 0, 0], third: [{third}, 0, 0]}}
    shortest: 0.1
    rigid: true
    restitution: {e}
"""

PRESSED = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: 4, {steps}, formulation: {formulation}}}
bodies:
  block: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
joints:
  guide:
    type: prismatic
    bodies: [ground, block]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    limits: {{displacement: {{range: [0, null], rigid: true}}}}
forces:
  lifts: {{type: force, body: block, force: [0, 0, "40 * sin(2 * t)"]}}
"""

BETWEEN_WALLS = """
mbproj: 1
gravity: [0, -10, 0]
simulation: {{duration: 3, {steps}, formulation: {formulation}}}
bodies:
  bob: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, -1, 0]}}
joints:
  pivot:
    type: revolute
    bodies: [ground, bob]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    speed: 1
    limits: {{angle: {{range: [-0.1, 0.1], rigid: true, restitution: {e}}}}}
"""

DRIVEN = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 1, {steps}}}
bodies:
  pusher: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
  block: {{mass: 2, inertia: [1, 1, 1], position: [1, 0, 0]}}
joints:
  slide: {{type: prismatic, bodies: [ground, pusher], location: [0, 0, 0], axis: [1, 0, 0]}}
  guide:
    type: prismatic
    bodies: [ground, block]
    location: [1, 0, 0]
    axis: [1, 0, 0]
    limits: {{displacement: {{range: [null, 0.3], {wall}}}}}
motions:
  drive: {{joint: slide, displacement: "t"}}
forces:
  touch: {{type: stop, points: {{pusher: [0, 0, 0], block: [1, 0, 0]}}, shortest: 0.5, rigid: true, restitution: 0}}
"""

THREE_BALLS = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: 3, {steps}, formulation: {formulation}}}
bodies:
  low: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.4]}}
  middle: {{mass: 0.6, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.65]}}
  high: {{mass: 0.25, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.9]}}
forces:
  floor:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: low, location: [0, 0, 0.4]}}
    rigid: true
    restitution: 0.5
  first:
    {{type: stop, points: {{low: [0, 0, 0.4], middle: [0, 0, 0.65]}}, shortest: 0.1, rigid: true, restitution: 0.5}}
  second:
    {{type: stop, points: {{middle: [0, 0, 0.65], high: [0, 0, 0.9]}}, shortest: 0.1, rigid: true, restitution: 0.5}}
"""

#: A slider-crank whose motor turns it into a stop, where it rests while a bob goes on swinging, until the motor
#: turns back; the crank has a stop of its own, and a spring that is slack beyond a point.
PRESSED_LOOP = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {{duration: 3, {steps}, formulation: {formulation}}}
bodies:
  crank: {{mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.05, 0, 0]}}
  rod: {{mass: 1, inertia: [7.0e-3, 7.0e-3, 7.0e-3], position: [0.25, 0, 0]}}
  slider: {{mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.4, 0, 0]}}
  bob: {{mass: 0.3, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.4, -0.2, 0]}}
joints:
  A:
    type: revolute
    bodies: [ground, crank]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    angle: 60 deg
    limits: {{angle: {{range: [-30 deg, 75 deg], rigid: true, restitution: 0.3}}}}
  B: {{type: revolute, bodies: [crank, rod], location: [0.1, 0, 0], axis: [0, 0, 1]}}
  C: {{type: revolute, bodies: [rod, slider], location: [0.4, 0, 0], axis: [0, 0, 1]}}
  D:
    type: prismatic
    bodies: [ground, slider]
    location: [0.4, 0, 0]
    axis: [1, 0, 0]
    limits: {{displacement: {{range: [null, -0.02], rigid: true, restitution: 0.4}}}}
  P: {{type: revolute, bodies: [slider, bob], location: [0.4, 0, 0], axis: [0, 0, 1], angle: 40 deg, speed: 3}}
forces:
  motor: {{type: torque, body: crank, torque: [0, 0, "-4 * cos(2 * t)"]}}
  band: {{type: linear_spring_damper, joint: D, force: "-30 * max(0, -0.04 - displacement) - displacement_dot"}}
"""

#: A beam falls on three points, whose pushes are not unique while it lies there, and is lifted and let down on a
#: part of them.
BEAM = """
mbproj: 1
gravity: [0, -10, 0]
simulation: {{duration: 1.6, {steps}, formulation: {formulation}}}
bodies:
  beam: {{mass: 2, inertia: [0.1, 0.5, 0.5], position: [0, 0.3, 0]}}
joints:
  plane: {{type: planar, bodies: [ground, beam], location: [0, 0.3, 0], axis: [0, 0, 1]}}
forces:
  left:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 1, 0]}}
    point: {{body: beam, location: [-0.5, 0.3, 0]}}
    rigid: true
    restitution: 0
  middle:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 1, 0]}}
    point: {{body: beam, location: [0.1, 0.3, 0]}}
    rigid: true
    restitution: 0
  right:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 1, 0]}}
    point: {{body: beam, location: [0.5, 0.3, 0]}}
    rigid: true
    restitution: 0
  lift: {{type: force, body: beam, location: [0.2, 0.3, 0], axes: global, force: [0, "30 * sin(4 * t)", 0]}}
"""

#: A ball falls on a buffer and lies on it; what it sees of the mass of the pendulum below a slider changes with the
#: pose. A brake rubs along the slider, and a pin beyond the buffer does not give way.
BUFFERS = """
mbproj: 1
gravity: [0, -10, 0]
simulation: {{duration: 1.4, {steps}, formulation: {formulation}}}
bodies:
  slider: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
  bob: {{mass: 1, inertia: [0.02, 0.02, 0.02], position: [0, -0.5, 0]}}
joints:
  guide:
    type: prismatic
    bodies: [ground, slider]
    location: [0, 0, 0]
    axis: [1, 0, 0]
    displacement: 0
    speed: 3
  pivot:
    type: revolute
    bodies: [slider, bob]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    angle: 30 deg
    limits: {{angle: {{range: [-60 deg, 35 deg], stiffness: 900, damping: 0.4}}}}
forces:
  brake: {{type: friction, joint: guide, coulomb: {{force: 2}}}}
  buffer:
    type: stop
    plane: {{body: ground, location: [0.3, 0, 0], normal: [-1, 0, 0]}}
    point: {{body: slider, location: [0, 0, 0]}}
    stiffness: 2.0e+3
    restitution: 0.5
    exponent: 1.5
  back:
    type: stop
    plane: {{body: ground, location: [-0.02, 0, 0], normal: [1, 0, 0]}}
    point: {{body: slider, location: [0, 0, 0]}}
    stiffness: 3.0e+3
    restitution: 0.8
  pin:
    type: stop
    plane: {{body: ground, location: [0.35, 0, 0], normal: [-1, 0, 0]}}
    point: {{body: slider, location: [0, 0, 0]}}
    rigid: true
    restitution: 0.4
"""

#: A ball that falls on a soft floor, bounces, and lies there.
SOFT_BALL = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: 2, {steps}, formulation: {formulation}}}
bodies:
  ball: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.4], velocity: [1, 0, 0]}}
forces:
  floor:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: ball, location: [0, 0, 0.4]}}
    stiffness: 2.0e+4
    restitution: 0.4
"""
