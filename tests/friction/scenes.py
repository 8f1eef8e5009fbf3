"""A scene with dry friction of every kind, on a body that a weld has merged too."""

SCENE = """\
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
