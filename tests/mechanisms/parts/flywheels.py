"""Scenes with reflected inertias that several tests share."""

from __future__ import annotations

HEAD = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {inertia: 0.7, start: 40 deg, arm: 0.5, mass: 2, own: 0.3}
simulation: {duration: 1.2, step: 2 ms, output_step: 40 ms}
"""
PENDULUM = (
    HEAD
    + """
bodies:
  bar: {mass: mass, inertia: [0.1, own, 0.3], position: [arm * sin(start), 0, -arm * cos(start)],
        orientation: {axis: [0, 1, 0], angle: -start}}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, -1, 0], angle: 0,
        reflected_inertia: inertia}
"""
)
#: A floating tree with everything that has a coordinate.
FLOATING = (
    HEAD.replace("-9.81", "0")
    + """
bodies:
  a: {mass: 2, inertia: [0.2, 0.3, 0.4], position: [0, 0, 0], angular_velocity: [0.3, -0.2, 0.5]}
  b: {mass: 1, inertia: [0.1, 0.1, 0.05], position: [0.6, 0.1, 0]}
  c: {mass: 1.5, inertia: [0.2, 0.1, 0.15], position: [0, 0.7, 0.2]}
  d: {mass: 0.5, inertia: [0.02, 0.03, 0.02], position: [0.9, 0.3, 0.4]}
joints:
  hand: {type: universal, bodies: [a, b], location: [0.3, 0, 0], axes: [[0, 1, 0], [0, 0, 1]],
         reflected_inertia: {angle_1: 0.4, angle_2: 0.1}, speed: {angle_1: 2, angle_2: -1}}
  rod: {type: cylindrical, bodies: [a, c], location: [0, 0.3, 0.1], axis: [0.2, 1, 0],
        reflected_inertia: {angle: 0.05, displacement: 3}, speed: {angle: 3, displacement: 0.4}}
  desk: {type: planar, bodies: [b, d], location: [0.8, 0.2, 0.2], axis: [1, 0, 1],
         reflected_inertia: {displacement_x: 0.7, displacement_y: 0.7, angle: 0.02},
        speed: {displacement_y: 0.3, angle: 2}}
"""
)
