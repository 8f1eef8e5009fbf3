"""A parallelogram that turns through its singular poses; without gravity its motion is even."""

from __future__ import annotations

#: A parallelogram without gravity turns evenly; φ is counted from the line of all bars. CLOSURE is the joint C.
PARALLELOGRAM = """
mbproj: 1
gravity: [0, 0, 0]
parameters: {crank: 0.2 m, coupler: 0.5 m, start: -1, speed: 1, x: crank*cos(start), z: crank*sin(start)}
simulation: {duration: 2, step: 0.05}
bodies:
  left: {mass: 1, inertia: [0.01, 0.02, 0.02], position: [x/2, 0, z/2], orientation: {axis: [0, -1, 0], angle: start}}
  right:
    mass: 2
    inertia: [0.01, 0.03, 0.03]
    position: [coupler + x/2, 0, z/2]
    orientation: {axis: [0, -1, 0], angle: start}
  coupler: {mass: 0.5, inertia: [0.01, 0.02, 0.02], position: [coupler/2 + x, 0, z]}
joints:
  A: {type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, -1, 0], speed: speed}
  B: {type: revolute, bodies: [left, coupler], location: [x, 0, z], axis: [0, -1, 0]}
  C: {type: CLOSURE, bodies: [right, coupler], location: [coupler + x, 0, z], axis: [0, -1, 0]}
  D: {type: revolute, bodies: [ground, right], location: [coupler, 0, 0], axis: [0, -1, 0]}
"""
