"""A pendulum whose pivot resists: by a constant torque, or by the force that it bears. By SciPy, swing by swing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from tests.friction.known.mechanisms import STEPS

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
