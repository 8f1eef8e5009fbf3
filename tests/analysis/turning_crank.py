"""A slider-crank whose crank turns at a constant speed, and where its piston is in closed form."""

from __future__ import annotations

import numpy as np

#: A slider-crank in the plane: crank r = 0.1 m, rod l = 0.3 m, at θ = 0 stretched out along x.
R, L, SPEED = 0.1, 0.3, 7.0
SCENE = f"""
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 1, step: 0.01}}
bodies:
  crank: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [{R / 2}, 0, 0]}}
  rod: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [{R + L / 2}, 0, 0]}}
  piston: {{mass: 1, inertia: [0.1, 0.1, 0.1], position: [{R + L}, 0, 0]}}
joints:
  main: {{type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1]}}
  pin: {{type: revolute, bodies: [crank, rod], location: [{R}, 0, 0], axis: [0, 0, 1]}}
  wrist: {{type: point_on_line, bodies: [piston, rod], location: [{R + L}, 0, 0], axis: [0, 0, 1]}}
  bore: {{type: prismatic, bodies: [ground, piston], location: [{R + L}, 0, 0], axis: [1, 0, 0]}}
motions: {{drive: {{joint: main, angle: {{constant_speed: {SPEED} rad/s}}}}}}
markers:
  pin: {{body: crank, location: {{crank: [{R / 2}, 0, 0]}}}}
  wrist: {{body: piston, location: {{piston: [0, 0, 0]}}}}
  across: {{body: piston, location: {{piston: [0, 1, 0]}}}}
expect:
"""


def place(θ):
    """Of the piston from where it is at θ = 0, and its slope."""
    root = np.sqrt(L**2 - (R * np.sin(θ)) ** 2)
    return float(R * np.cos(θ) + root - R - L), float(-R * np.sin(θ) - R**2 * np.sin(θ) * np.cos(θ) / root)
