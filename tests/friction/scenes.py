"""Scenes with dry friction: one of each law, and a block on a belt."""

from __future__ import annotations

import numpy as np

# A scene with dry friction of every kind, on a body that a weld has merged too.

EVERY_FRICTION = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {grip: 4 N*m}
bodies:
  disc: {mass: 2, inertia: [0.1, 0.2, 0.3], position: [0.1, 0, 0]}
  plate: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.3, 0.2, 0], orientation: {axis: [1, 0, 0], angle: 90 deg}}
  block: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 1], orientation: {axis: [0, 0, 1], angle: 90 deg}}
  rod: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [2, 0, 1]}
  nut: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 1]}
joints:
  weld: {type: fixed, bodies: [disc, plate], location: [0, 0, 0]}
  A: {type: revolute, bodies: [ground, plate], location: [0, 0, 0], axis: [0, 1, 0]}
  D: {type: prismatic, bodies: [ground, block], location: [0, 0, 1], axis: [1, 0, 0]}
  C: {type: cylindrical, bodies: [ground, rod], location: [2, 0, 1], axis: [0, 0, 1]}
  S: {type: screw, bodies: [ground, nut], location: [1, 0, 1], axis: [0, 0, 1], pitch: 3 mm}
forces:
  bearing:
    type: friction
    joint: A
    coulomb:
      coefficient: 0.2
      static: 0.3
      radius: 10 mm
      axial_radius: 8 mm
      bearing_length: 30 mm
      preload: 5 N
  brake: {type: friction, joint: A, coulomb: {torque: grip, static: 5 N*m, stribeck_speed: 0.05 rad/s}}
  guide: {type: friction, joint: D, coulomb: {coefficient: 0.1, regularised: 1e-3 m/s, preload: 2 kN}, coefficient: 3}
  sleeve:
    type: friction
    joint: C
    coefficient: {angle: 0.5}
    coulomb:
      angle: {torque: 1, static: 2, stribeck_speed: 3, regularised: 0.1}
      displacement: {force: 2 N, static: 2.5 N}
  thread: {type: friction, joint: S, coulomb: {coefficient: 0.1, radius: 6 mm, preload: 10 N}}
  collar: {type: friction, joint: S, coulomb: {angle: {coefficient: 0.3, radius: 6 mm, axial_radius: 9 mm}}}
"""


# A block on a moving belt, held by a spring: it sticks and slips, with its times in closed form.

#: Spring N/m, mass kg, sliding and static force N, speed of the belt m/s.
K, M, SLIDES, HOLDS, SPEED = 10.0, 1.0, 2.0, 3.0, 0.2
ω = np.sqrt(K / M)

BELT = """\
mbproj: 1
title: Stick-slip on a belt
gravity: [0, 0, -9.81]
simulation: {duration: 3.5 s, integrator: dop853, tolerance: 1.0e-11, output_step: 0.02 s}
bodies:
  belt: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
  block: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  drive: {type: prismatic, bodies: [ground, belt], location: [0, 0, 0], axis: [1, 0, 0]}
  rub: {type: prismatic, bodies: [belt, block], location: [0, 0, 0], axis: [1, 0, 0]}
motions:
  running: {joint: drive, displacement: 0.2 * t}
forces:
  spring: {type: spring_damper, points: {ground: [-2, 0, 0], block: [0, 0, 0]}, stiffness: 10, free_length: 2}
  grip: {type: friction, joint: rub, coulomb: {force: 2, static: 3}}
expect:
  slides: {friction: grip, quantity: rate, at: 0 s, value: -0.2, absolute: 1.0e-12, source: the start}
  rests: {friction: grip, quantity: state, at: 1 s, value: 0, absolute: 0.5, source: closed form}
  rubs: {friction: grip, quantity: force, at: 2 s, value: 2 N, absolute: 1.0e-12, source: closed form}
"""

#: It first sticks where the spring has let it come up to the belt's speed, and slips where that pulls with 3 N; from
#: then on it slips and sticks in turn.
STICKS = float(np.arcsin(SPEED * K / (SLIDES * ω)) / ω)
FIRST = SLIDES / K * (1.0 - np.cos(ω * STICKS))
SLIPS = float(STICKS + (HOLDS / K - FIRST) / SPEED)
SLIPPING = float(2.0 / ω * (np.pi - np.arctan((HOLDS - SLIDES) * ω / (K * SPEED))))
AGAIN = SLIPS + SLIPPING
#: How far the block slides on the belt before it first sticks, and in each slip after.
SLID = float(SPEED * STICKS - FIRST), float(SPEED * SLIPPING + 2.0 * (HOLDS - SLIDES) / K)
