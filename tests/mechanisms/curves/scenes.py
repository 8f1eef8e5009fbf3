"""Scenes with curves: pins in slots, and profiles that touch."""

from __future__ import annotations

# A cam with its follower, and the settings of its runs.

HEAD = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: {duration}, output_step: {output}, {settings}, formulation: {formulation}}}
"""
#: A follower of 0.5 kg on a spring of 2000 N/m under 60 N, over a cam that turns by 30 rad/s.
CAM = """
curves:
  lift: {lift: {base: 38 mm, rises: [[120 deg, 20 mm, LAW], [60 deg, 20 mm, dwell],
                                     [120 deg, 0 mm, LAW], [60 deg, 0 mm, dwell]]}, roller: 12 mm}
bodies:
  shaft: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}
  valve: {mass: 0.5, inertia: [0.001, 0.001, 0.001], position: [0, 0, 0.06]}
joints:
  A: {type: revolute, bodies: [ground, shaft], location: [0, 0, 0], axis: [0, -1, 0]}
  P: {type: prismatic, bodies: [ground, valve], location: [0, 0, 0.05], axis: [0, 0, 1]}
  K: {type: cam, bodies: [shaft, valve], curve: lift, axis: [0, -1, 0], x_axis: [1, 0, 0],
      locations: [[0, 0, 0], [0, 0, 0.06]]}
forces:
  spring: {type: spring_damper, points: {ground: [0, 0, 0.5], valve: [0, 0, 0.06]}, stiffness: 2000 N/m,
           free_length: 0.48 m}
motions:
  drive: {joint: A, angle: {constant_speed: 30 rad/s}}
"""

#: The pin of 0.5 kg in a closed slot of a rotor that turns freely.
SLOT = """
curves:
  track:
    points: [[0.33, 0], [0.26, 0.117], [0.12, 0.19], [0, 0.2], [-0.12, 0.156], [-0.26, 0.083],
             [-0.33, 0], [-0.26, -0.083], [-0.12, -0.156], [0, -0.2], [0.12, -0.19], [0.26, -0.117]]
    closed: true
bodies:
  rotor: {mass: 2, inertia: [0.05, 0.05, 0.05], position: [0, 0, 0], angular_velocity: [0, -1, 0]}
  pin: {mass: 0.5, inertia: [1.0e-4, 1.0e-4, 1.0e-4], position: [0.33, 0, 0], velocity: [0, 0, 1.8]}
joints:
  A: {type: revolute, bodies: [ground, rotor], location: [0, 0, 0], axis: [0, -1, 0]}
  K: {type: slot, bodies: [rotor, pin], curve: track, locations: [[0, 0, 0], [0.33, 0, 0]], axis: [0, -1, 0],
      x_axis: [1, 0, 0]}
  P: {type: planar, bodies: [ground, pin], location: [0.33, 0, 0], axis: [0, -1, 0], x_axis: [1, 0, 0]}
"""


def scene(body, formulation="auto", duration=0.2, output="10 ms", settings="integrator: dop853, tolerance: 1.0e-11"):
    return HEAD.format(formulation=formulation, duration=duration, output=output, settings=settings) + body


# Scenes with what touches curves: discs, rollers, faces, beads.

#: An eccentric disc that turns freely, and a disc on an arm that rests on it.
DISCS = """
curves: {small: {circle: 40 mm}, large: {circle: 90 mm}}
bodies:
  shaft: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0], angular_velocity: [0, 7, 0]}
  arm: {mass: 0.5, inertia: [0.002, 0.002, 0.002], position: [0.2, 0, 0.13]}
joints:
  A: {type: revolute, bodies: [ground, shaft], location: [0, 0, 0], axis: [0, -1, 0]}
  P: {type: revolute, bodies: [ground, arm], location: [0.3, 0, 0.13], axis: [0, -1, 0]}
  K: {JOINT, locations: [[0, 0, 0.015], [0, 0, 0.145]]}
"""
TOUCH = "type: curve_on_curve, bodies: [shaft, arm], curves: [small, large], axis: [0, -1, 0], x_axis: [1, 0, 0]"
#: A cam that lifts from the start on, under its roller or a disc of the same radius.
ROLLER = (
    CAM.replace("LAW", "cycloidal")
    .replace("x_axis: [1, 0, 0]", "x_axis: [0, 0, 1]")
    .replace("0.06]", "0.05]")
    .replace("roller: 12 mm}", "roller: 12 mm, clockwise: true}")
)
DISC = (
    ROLLER.replace("curves:\n", "curves:\n  disc: {circle: 12 mm}\n")
    .replace("type: cam,", "type: curve_on_curve,")
    .replace("curve: lift", "curves: [lift, disc]")
)
#: A follower of 0.5 kg under a spring of 2000 N/m and 10 N, which meets the cam 13 mm beside its axis and 10 mm below.
FLAT = """
curves:
  lift: {lift: {base: 50 mm, rises: [[120 deg, 20 mm, LAW], [60 deg, 20 mm, dwell],
                                     [120 deg, 0 mm, LAW], [60 deg, 0 mm, dwell]]}, flat: true, clockwise: true}
bodies:
  shaft: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}
  valve: {mass: 0.5, inertia: [0.001, 0.001, 0.001], position: [0, 0, 0.06]}
joints:
  A: {type: revolute, bodies: [ground, shaft], location: [0, 0, 0], axis: [0, -1, 0]}
  P: {type: prismatic, bodies: [ground, valve], location: [0, 0, 0.05], axis: [0, 0, 1]}
  K: {type: flat_follower, bodies: [shaft, valve], curve: lift, axis: [0, -1, 0], x_axis: [0, 0, 1],
      locations: [[0, 0, 0], [0.013, 0, 0.05]], normal: [0, 0, 1]}
forces:
  spring: {type: spring_damper, points: {ground: [0, 0, 0.5], valve: [0, 0, 0.06]}, stiffness: 2000 N/m,
           free_length: 0.445 m}
motions:
  drive: {joint: A, angle: {constant_speed: SPEED rad/s}}
"""
#: A bead of 0.5 kg on a closed wire that is fixed to a rotor about a leaning axis.
WIRE = """
curves:
  wire:
    closed: true
    space_points: [[0.3, 0, 0.02], [0.1, 0.25, -0.03], [-0.2, 0.2, 0.05], [-0.3, -0.1, 0], [0, -0.28, 0.08]]
bodies:
  rotor: {mass: 2, inertia: [0.05, 0.06, 0.07], position: [0, 0, 0], angular_velocity: [0.6, 0, 0.8]}
  bead: {mass: 0.5, inertia: [1.0e-4, 1.0e-4, 1.0e-4], position: [0.3, 0, 0.02], velocity: [0, 1.44, 0.3]}
joints:
  A: {type: revolute, bodies: [ground, rotor], location: [0, 0, 0], axis: [0.6, 0, 0.8]}
  K: {type: space_slot, bodies: [rotor, bead], curve: wire, locations: [[0, 0, 0], [0.3, 0, 0.02]], axis: [0, 0, 1],
      x_axis: [1, 0, 0]}
"""
