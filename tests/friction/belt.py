"""A block on a moving belt, held by a spring: it sticks and slips, with its times in closed form."""

from __future__ import annotations

import numpy as np

#: Spring N/m, mass kg, sliding and static force N, speed of the belt m/s.
K, M, SLIDES, HOLDS, SPEED = 10.0, 1.0, 2.0, 3.0, 0.2
ω = np.sqrt(K / M)

SCENE = """\
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
SLIPS_AGAIN = AGAIN + 2.0 * (HOLDS - SLIDES) / (K * SPEED)
#: How far the block slides on the belt before it first sticks, and in each slip after.
SLID = float(SPEED * STICKS - FIRST), float(SPEED * SLIPPING + 2.0 * (HOLDS - SLIDES) / K)
