"""Mechanisms with dry friction whose motion is known, and a pendulum with friction in its pivot."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

# Scenes with dry friction of one coordinate, as text with numbers to fill in; and how they are integrated.

#: How runs are made: with error control, with fixed steps, implicitly.
STEPS = {
    "dop853": "integrator: dop853, tolerance: 1.0e-11, output_step: 0.05",
    "dopri5": "integrator: dopri5, tolerance: 1.0e-11, output_step: 0.05",
    "rk4": "integrator: rk4, step: 1.0e-3, output_step: 0.05",
    "esdirk4": "integrator: esdirk4, tolerance: 1.0e-10, output_step: 0.05",
    "radau5": "integrator: radau5, tolerance: 1.0e-10, output_step: 0.05",
}
FORMULATIONS = ("planar", "reduced", "full")

#: A rotor of J = 0.5 kg m² and 2 kg about z with its centre of mass at `centre`, and a friction on its bearing.
ROTOR = """
mbproj: 1
gravity: {gravity}
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  rotor: {{mass: 2, inertia: [0.4, 0.4, 0.5], position: {centre}}}
joints:
  hinge: {{type: revolute, bodies: [ground, rotor], location: [0, 0, 0], axis: [0, 0, 1], speed: {speed}}}
forces:
  load: {{type: torque, body: rotor, torque: [0, 0, "{load}"]}}
  brake: {{type: friction, joint: hinge, coulomb: {coulomb}}}
{more}
"""


def rotor(coulomb, *, speed=30.0, load="0", duration=2.0, steps="dop853", formulation="planar", **others):
    """The text of a rotor with a friction: `more` has further lines of its forces."""
    given = {"gravity": [0, 0, 0], "centre": [0, 0, 0], "more": ""} | others
    return ROTOR.format(
        coulomb=coulomb,
        speed=speed,
        load=load,
        duration=duration,
        steps=STEPS.get(steps, steps),
        formulation=formulation,
        **given,
    )


#: A block that slides on a plane which turns about the start of the block by a given angle.
INCLINE = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  plane: {{mass: 5, inertia: [1, 1, 1], position: [0, 0, 0]}}
  block: {{mass: 3, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
joints:
  hinge: {{type: revolute, bodies: [ground, plane], location: [0, 0, 0], axis: [0, 0, 1]}}
  guide: {{type: prismatic, bodies: [plane, block], location: [0, 0, 0], axis: [1, 0, 0], speed: {speed}}}
motions:
  tilts: {{joint: hinge, angle: "{angle}"}}
forces:
  friction: {{type: friction, joint: guide, coulomb: {coulomb}}}
"""


def incline(angle, coulomb, *, speed=0.0, duration=2.0, steps="dop853", formulation="reduced"):
    """The text of a block on a plane at an angle, a function of time."""
    return INCLINE.format(
        angle=angle,
        coulomb=coulomb,
        speed=speed,
        duration=duration,
        steps=STEPS.get(steps, steps),
        formulation=formulation,
    )


#: A mass that a spring holds back on a belt.
BELT = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  belt: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
  block: {{mass: {m}, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}
joints:
  drum: {{type: prismatic, bodies: [ground, belt], location: [0, 0, 0], axis: [1, 0, 0]}}
  contact: {{type: prismatic, bodies: [belt, block], location: [0, 0, 0], axis: [1, 0, 0], speed: 0}}
motions:
  runs: {{joint: drum, displacement: "{v}*t"}}
forces:
  spring: {{type: spring_damper, points: {{ground: [-9, 0, 0], block: [0, 0, 0]}}, stiffness: {k}}}
  grip: {{type: friction, joint: contact, coulomb: {coulomb}}}
"""


def on_a_belt(belt, coulomb, *, duration, steps="dop853", formulation="planar"):
    """The text of a mass on a belt: `belt` has m, k and v."""
    return BELT.format(
        m=belt.m,
        k=belt.k,
        v=belt.v,
        coulomb=coulomb,
        duration=duration,
        steps=STEPS.get(steps, steps),
        formulation=formulation,
    )


#: A screw of pitch 2πh about the vertical axis with a load on it, and a torque on the load.
SCREW = """
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {{pitch: "2*pi*{h}"}}
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  load: {{mass: {m}, inertia: [{J}, {J}, {J}], position: [0, 0, 0]}}
joints:
  thread:
    type: screw
    bodies: [ground, load]
    location: [0, 0, 0]
    axis: [0, 0, 1]
    pitch: pitch
    speed: {{angle: {speed}}}
forces:
  hand: {{type: torque, body: load, torque: [0, 0, "{torque}"]}}
  friction: {{type: friction, joint: thread, coulomb: {coulomb}}}
"""


def screw(coulomb, *, m, J, h, torque="0", speed=0.0, duration=1.0, steps="dop853", formulation="reduced"):
    """The text of a screw with a load."""
    return SCREW.format(
        coulomb=coulomb,
        m=m,
        J=J,
        h=h,
        torque=torque,
        speed=speed,
        duration=duration,
        steps=STEPS.get(steps, steps),
        formulation=formulation,
    )


#: A block that stands on two corners of a floor.
BLOCK = """
mbproj: 1
gravity: {gravity}
simulation: {{duration: {duration}, {steps}}}
bodies:
  block:
    mass: 3
    inertia: [{inertia}, {inertia}, {inertia}]
    position: [{x}, 0, {z}]
    orientation: {{axis: [0, 1, 0], angle: {tilt}}}
    velocity: {velocity}
joints:
  plane: {{type: planar, bodies: [ground, block], location: [{x}, 0, {z}], axis: [0, 1, 0]}}
forces:
  left:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: block, location: {{block: [-{b}, 0, -{h}]}}}}
    rigid: true
    restitution: {e}
    friction: {friction}
  right:
    type: stop
    plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: block, location: {{block: [{b}, 0, -{h}]}}}}
    rigid: true
    restitution: {e}
    friction: {friction}
"""


def block(friction, tilt, *, R, α, gravity=10.0, velocity=(0, 0, 0), e=0, duration=1.0, above=0.0, steps="dop853"):
    """The text of a block on its right corner, tilted to the right."""
    b, h = R * np.sin(α), R * np.cos(α)
    return BLOCK.format(
        friction=friction,
        tilt=tilt,
        gravity=[0, 0, -gravity],
        velocity=list(velocity),
        e=e,
        duration=duration,
        steps=STEPS[steps],
        inertia=3.0 * R**2 / 3.0,
        b=b,
        h=h,
        x=h * np.sin(tilt) - b * np.cos(tilt),
        z=h * np.cos(tilt) + b * np.sin(tilt) + above,
    )


# A pendulum whose pivot resists: by a constant torque, or by the force that it bears. By SciPy, swing by swing.

MASS, LENGTH, G = 2.0, 0.5, 9.81
#: About the pivot, kg m².
J = 0.1 + MASS * LENGTH**2

TEXT = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {{duration: {duration}, {steps}, formulation: {formulation}}}
bodies:
  bob: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, -0.5, 0]}}
joints:
  pivot: {{type: revolute, bodies: [ground, bob], location: [0, 0, 0], axis: [0, 0, 1], angle: {start}, speed: {speed}}}
forces:
  bearing: {{type: friction, joint: pivot, coulomb: {coulomb}}}
"""


def constant(torque):
    """θ'' where the pivot resists with a torque."""
    return lambda θ, rate, direction: (-MASS * G * LENGTH * np.sin(θ) - direction * torque) / J


def by_the_force(arm):
    """θ'' where it resists with arm |F|: J θ'' + m g l sin θ = -direction arm |F|, |F| = m |(g cos θ + l θ'², g sin θ +
    l θ'')|."""

    def acceleration(θ, rate, direction):
        along, across = G * np.cos(θ) + LENGTH * rate**2, G * np.sin(θ)
        a = -MASS * G * LENGTH * np.sin(θ) / J
        for _ in range(60):  # arm m l < J: a contraction
            a = (-MASS * LENGTH * across - direction * arm * MASS * np.hypot(along, across + LENGTH * a)) / J
        return a

    return acceleration


def swing(
    acceleration: Callable[[float, float, float], float], θ: float, rate: float, duration: float
) -> tuple[np.ndarray, list[float]]:
    """The angle and the rate after a time in which it does not come to rest, and the times of its turns."""
    t, state, turns = 0.0, np.array([θ, rate]), []
    direction = np.sign(rate) if rate else -np.sign(θ)

    def rests(t, y):
        return y[1]

    rests.terminal = True
    while t < duration:
        rests.direction = -direction
        piece = solve_ivp(
            lambda t, y, direction=direction: [y[1], acceleration(y[0], y[1], direction)],
            (t, duration),
            state,
            method="DOP853",
            events=rests,
            rtol=1e-13,
            atol=1e-14,
        )
        t, state = piece.t[-1], piece.y[:, -1]
        if t < duration:
            turns.append(float(t))
            direction = -direction
    return state, turns


def next_amplitude(θ, torque):
    """How far it swings to the other side under a constant torque, below 0 where it does not come past the middle: the
    potential energy lost is torque × way."""
    return brentq(
        lambda other: MASS * G * LENGTH * (np.cos(other) - np.cos(θ)) - torque * (θ + other), -0.999 * θ, θ, xtol=1e-15
    )


def pendulum(coulomb, *, duration, steps="dop853", formulation="planar", start=1.2, speed=0.0):
    return TEXT.format(
        coulomb=coulomb,
        duration=duration,
        steps=STEPS.get(steps, steps),
        formulation=formulation,
        start=start,
        speed=speed,
    )
