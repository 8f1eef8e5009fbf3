"""Scenes with a force of every kind, and their joint coordinates by the constraints alone."""

from __future__ import annotations

import numpy as np

from mbproj.equations.kinematics import attached, pose_of, slots_of

HEAD = """\
mbproj: 1
gravity: [0.3, -0.2, -9.8]
simulation: {duration: 0.1, step: 0.01}
bodies:
  a: {mass: 1, inertia: [1, 2, 2.5], position: [0.1, 0.2, 0.3], orientation: {quaternion: [3, 1, -2, 0.5]}}
  b: {mass: 2, inertia: [1, 1.5, 1.2], position: [1, -0.5, 0.4], orientation: {quaternion: [1, 1, 0.3, -1]}}
joints:
  R: {type: revolute, bodies: [a, b], location: [0.4, 0, 0.1], axis: [1, 2, -1]}
  C: {type: cylindrical, bodies: [ground, a], location: [0, 1, 0], axis: [0, 1, 1]}
forces:
"""


FORCES = """\
  ab: {type: spring_damper, points: {a: [0, 0, 1], b: [1, 1, 0]}, stiffness: 30, damping: 2, free_length: 0.7}
  ga: {type: spring_damper, bodies: [ground, a], locations: {ground: [0, 0, -2], a: [1, 0, 1]}, force: sin(t)/l - l_dot}
  tr: {type: torsion_spring_damper, joint: R, stiffness: 5, damping: 0.3, free_angle: 20 deg}
  tc: {type: torsion_spring_damper, joint: C, torque: 4*sin(angle) - angle_dot*t}
  lc: {type: linear_spring_damper, joint: C, stiffness: 11, free_displacement: -3 mm}
  fc: {type: friction, joint: C, coefficient: {angle: 0.4, displacement: 7}}
"""


#: One that couples its coordinates, between frames that lean against each other, and one on the ground.
BUSHINGS = """\
  bu:
    type: bushing
    bodies: [a, b]
    location: {a: [0.2, 0.1, -0.1], b: [-0.3, 0.2, 0.1]}
    axes: {a: {quaternion: [3, -1, 2, -0.5]}, b: {quaternion: [1, -1, -0.5, 1.4]}}
    stiffness: {translation: [[90, 20, 0], [20, 70, 5], [0, 5, 60]], rotation: [[9, 1, 0], [1, 8, 2], [0, 2, 7]]}
    damping: {translation: [1, 0.5, 2], rotation: [[0.4, 0.1, 0], [0.1, 0.3, 0], [0, 0, 0.2]]}
    preload: {translation: [1, -2, 3], rotation: [0.1, 0.3, -0.2]}
  bg: {type: bushing, bodies: [b, ground], location: [0.9, -0.4, 0.5], stiffness: {rotation: [3, 2, 4]}}
"""


#: Against translation and rotation; two free bodies with a bushing between them.
K_X = np.array([[90.0, 20.0, 0.0], [20.0, 70.0, 5.0], [0.0, 5.0, 60.0]])
K_R = np.array([[9.0, 1.0, 0.0], [1.0, 8.0, 2.0], [0.0, 2.0, 7.0]])
PAIR = f"""\
mbproj: 1
gravity: [0, 0, 0]
bodies:
  a: {{mass: 1, inertia: [0.1, 0.2, 0.25], position: [0.1, 0.2, 0.3], orientation: {{quaternion: [3, 1, -2, 0.5]}}}}
  b: {{mass: 2, inertia: [0.1, 0.15, 0.12], position: [0.3, -0.1, 0.4], orientation: {{quaternion: [1, 1, 0.3, -1]}}}}
forces:
  bush:
    type: bushing
    bodies: [a, b]
    location: [0.2, 0.1, 0.3]
    axes: {{euler: [0.3, 0.2, 0.1], sequence: xyz}}
    stiffness: {{translation: {K_X.tolist()}, rotation: {K_R.tolist()}}}
    damping: {{translation: [1, 0.5, 2], rotation: [0.4, 0, 0.2]}}
    preload: {{translation: [1, -2, 3], rotation: [0.1, 0.3, -0.2]}}
"""


ON_BODIES = """\
  fa: {type: force, body: a, location: [1, 2, 3], force: [1, -2*t, 3]}
  fb: {type: force, body: b, location: {b: [0.1, 0.2, 0.3]}, force: [t, 0, 3], axes: body}
  fo: {type: force, body: b, force: [5, 0, 3]}
  ta: {type: torque, body: a, torque: [0.1, t**2, 3]}
  tb: {type: torque, body: b, torque: [1, 0, 2], axes: body}
"""


def reference(system, q):
    """Joint coordinates whose turns are those of the start."""
    return system.coordinates.value(attached(pose_of(q), *slots_of(system.coordinates)))
