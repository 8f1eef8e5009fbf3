"""A four-bar with ten dimensions, a six-bar, a pendulum: scenes as text."""

from __future__ import annotations

#: Ten dimensions; the marker "tip" is beside the coupler. The crank turns by `turn` in a second.
FOUR_BAR = """\
mbproj: 1
gravity: [0, 0, 0]
parameters:
  {{ax: 0 m, az: 0 m, frame: 0.8 m, tilt: 0 rad, crank: 0.25 m, coupler: 0.7 m, rocker: 0.6 m, px: 0.3 m, pz: 0.2 m,
   start: 0.2 rad, turn: {turn}, leans: {leans}, tips: {tips}}}
bodies:
  a: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [ax, 0, az], orientation: {{axis: [0, -1, 0], angle: start}}}}
  b: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [ax + crank*cos(start), 0, az + crank*sin(start)],
      orientation: {{axis: [0, -1, 0], angle: tips}}}}
  c: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: [ax + frame*cos(tilt), 0, az + frame*sin(tilt)],
      orientation: {{axis: [0, -1, 0], angle: leans}}}}
joints:
  A: {{type: revolute, bodies: [ground, a], location: {{ground: [ax, 0, az], a: [0, 0, 0]}},
      axis: {{ground: [0, -1, 0], a: [0, -1, 0]}}}}
  B: {{type: revolute, bodies: [a, b], location: {{a: [crank, 0, 0], b: [0, 0, 0]}},
      axis: {{a: [0, -1, 0], b: [0, -1, 0]}}}}
  C: {{type: revolute, bodies: [b, c], location: {{b: [coupler, 0, 0], c: [rocker, 0, 0]}},
      axis: {{b: [0, -1, 0], c: [0, -1, 0]}}}}
  D: {{type: revolute, bodies: [ground, c], axis: {{ground: [0, -1, 0], c: [0, -1, 0]}},
      location: {{ground: [ax + frame*cos(tilt), 0, az + frame*sin(tilt)], c: [0, 0, 0]}}}}
motions: {{drive: {{joint: A, angle: turn*t}}}}
markers: {{tip: {{body: b, location: {{b: [px, 0, pz]}}}}}}
simulation: {{duration: 1 s, output_step: 1/24, kinematic: true}}
"""
#: A crank-rocker whose rocker drives a ram along x.
SIX_BAR = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {crank: 0.1 m, coupler: 0.4 m, rocker: 0.3 m, arm: 0.35 m, rod: 0.6 m, ram: 20 kg}
bodies:
  a: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}
  b: {mass: 2, inertia: [0.02, 0.02, 0.02], position: [crank, 0, 0], orientation: {axis: [0, -1, 0], angle: 0.6}}
  c: {mass: 2, inertia: [0.02, 0.02, 0.02], position: [0.4, 0, 0], orientation: {axis: [0, -1, 0], angle: 1.8}}
  d: {mass: 2, inertia: [0.05, 0.05, 0.05], position: [0.4, 0, 0.35]}
  slide: {mass: ram, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0.35]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, -1, 0]}
  B: {type: revolute, bodies: [a, b], location: {a: [crank, 0, 0], b: [0, 0, 0]},
      axis: {a: [0, -1, 0], b: [0, -1, 0]}}
  C: {type: revolute, bodies: [b, c], location: {b: [coupler, 0, 0], c: [rocker, 0, 0]},
      axis: {b: [0, -1, 0], c: [0, -1, 0]}}
  D: {type: revolute, bodies: [ground, c], location: {ground: [0.4, 0, 0], c: [0, 0, 0]},
      axis: {ground: [0, -1, 0], c: [0, -1, 0]}}
  E: {type: revolute, bodies: [c, d], location: {c: [arm, 0, 0], d: [0, 0, 0]},
      axis: {c: [0, -1, 0], d: [0, -1, 0]}}
  F: {type: revolute, bodies: [d, slide], location: {d: [rod, 0, 0], slide: [0, 0, 0]},
      axis: {d: [0, -1, 0], slide: [0, -1, 0]}}
  G: {type: prismatic, bodies: [ground, slide], location: [0, 0, 0.35], axis: [1, 0, 0]}
motions: {drive: {joint: A, angle: 20*t}}
simulation: {duration: 2*pi/20, output_step: 2*pi/20/240, kinematic: true}
expect:
  load: {joint: D, quantity: reaction_force, component: norm, at: largest, below: 1e9, source: to be lowered}
  stroke: {joint: G, quantity: displacement, at: range, below: 10, source: to be kept}
"""
PENDULUM = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {offset: 0.3 m, damping: 0.1 N*m*s, release: 0.7 rad}
bodies:
  lever: {mass: 1.3, inertia: [0.02, 0.02, 0.02], position: [offset*sin(release), 0, -offset*cos(release)],
          orientation: {axis: [0, -1, 0], angle: release}}
joints: {pin: {type: revolute, bodies: [ground, lever], location: [0, 0, 0], axis: [0, -1, 0], angle: release}}
forces: {rubber: {type: torsion_spring_damper, joint: pin, damping: damping}}
simulation: {duration: 2 s, step: 10 ms, output_step: 50 ms}
"""
