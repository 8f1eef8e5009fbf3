"""Scenes with ropes, and the equations of a swinging Atwood machine."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

G, R = 9.81, 0.1
HEAD = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: {duration}, integrator: {integrator}, tolerance: {tolerance}, output_step: 20 ms,
  formulation: {formulation}}}
"""
#: A weight that slides and one that swings, on the two sides of a wheel that the rope turns.
ATWOOD = """
bodies:
  left: {mass: 1, inertia: [1, 1, 1], position: [-0.1, 0, -1]}
  wheel: {mass: 2, inertia: [0.02, 0.02, 0.02], position: [0, 0, 0]}
  bob: {mass: 0.8, inertia: [1, 1, 1], position: [0.1*cos(0.6) + 0.6*sin(0.6), 0, 0.1*sin(0.6) - 0.6*cos(0.6)]}
joints:
  guide: {type: prismatic, bodies: [ground, left], location: [-0.1, 0, -1], axis: [0, 0, 1]}
  axle: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0]}
  plane: {type: planar, bodies: [ground, bob], location: [0, 0, 0], axis: [0, 1, 0]}
  rope:
    type: rope
    normal: [0, -1, 0]
    path: [{point: left, at: [-0.1, 0, -1]}, {wheel: wheel, radius: 0.1, bends: right}, {point: bob, at: {bob: [0, 0, 0]}}]
"""  # noqa: E501
#: A load on a rope from the ground over a sheave, of which 1 m hangs down at first.
LOAD = """
bodies:
  load: {mass: 2, inertia: [1, 1, 1], position: [0.1, 0, -1]}
joints:
  guide: {type: prismatic, bodies: [ground, load], location: [0.1, 0, -1], axis: [0, 0, 1]}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: ground, at: [-0.1, 0, -0.5]}
      - {sheave: ground, at: [0, 0, 0], radius: 0.1, bends: right}
      - {point: load, at: [0.1, 0, -1]}
"""
#: Lifts the weight of `LOAD` against gravity.
UP = "forces:\n  up: {type: linear_spring_damper, joint: guide, force: 30*sin(10*t)}\n"


def scene(body, formulation="auto", duration=1, integrator="dop853", tolerance="1.0e-12"):
    head = HEAD.format(formulation=formulation, duration=duration, integrator=integrator, tolerance=tolerance)
    return head + body


def swinging(t):
    """l' = w + r a', where the rope runs by w: the heights and the places of the bob, and both tensions."""
    left, bob = 1.0, 0.8
    total = left + bob + 0.02 / R**2

    def slope(_, y):
        length, w, angle, rate, _ = y
        gain = (bob * (G * np.cos(angle) + length * rate**2) - left * G) / total
        stretch = w + R * rate
        return np.array([stretch, gain, rate, -(G * np.sin(angle) + w * rate + stretch * rate) / length, w])

    found = solve_ivp(slope, (0, t[-1]), [0.6, 0, 0.6, 0, -1], "DOP853", rtol=1e-13, atol=1e-14, t_eval=t)
    length, _, angle, rate, height = found.y
    gain = slope(0, found.y)[1]
    bob_at = [R * np.cos(angle) + length * np.sin(angle), R * np.sin(angle) - length * np.cos(angle)]
    return height, bob_at, left * (G + gain), bob * (G * np.cos(angle) + length * rate**2 - gain)
