"""A slider-crank with dry friction in its guide by the force across it: the equations of Newton and Euler of its three
bodies in the plane, integrated by SciPy from one reversal of the slider to the next. They know nothing of mbproj. Its
scene is below."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

from tests.friction.mechanisms import STEPS

R, L, G = 0.1, 0.3, 9.81
MASS = {"crank": 1.0, "rod": 0.6, "slider": 1.5}
INERTIA = {"crank": 0.02, "rod": 6.0e-3}
#: Unknowns: the crank's angular acceleration, the forces of the crank on the rod and of the rod on the slider, the
#: force of the guide across it, and the friction along it.
ACCELERATION, NORMAL, FRICTION = 0, 5, 6


def rod(φ, rate, acceleration):
    """The angle of the rod with its first two derivatives; the guide passes through the pivot."""
    ψ = np.arcsin(-R / L * np.sin(φ))
    first = -R * np.cos(φ) * rate / (L * np.cos(ψ))
    crank = R * (np.cos(φ) * acceleration - np.sin(φ) * rate**2)
    return ψ, first, (-crank + L * np.sin(ψ) * first**2) / (L * np.cos(ψ))


def along(angle, rate, acceleration, length):
    """The acceleration of the end of a turning bar."""
    out, side = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    return length * (acceleration * side - rate**2 * out)


def slider(φ, rate):
    """Where the slider is, and its speed."""
    ψ, turn, _ = rod(φ, rate, 0.0)
    return R * np.cos(φ) + L * np.cos(ψ), -R * np.sin(φ) * rate - L * np.sin(ψ) * turn


def equations(φ, rate):
    """The six equations of the bodies on the seven unknowns."""
    ψ = rod(φ, rate, 0.0)[0]
    pin, half = R * np.array([np.cos(φ), np.sin(φ)]), 0.5 * L * np.array([np.cos(ψ), np.sin(ψ)])

    def inertial(acceleration):
        _, turn, turns = rod(φ, rate, acceleration)
        end = along(φ, rate, acceleration, R)
        centre = end + along(ψ, turn, turns, 0.5 * L)
        point = end + along(ψ, turn, turns, L)
        return np.array(
            [
                INERTIA["crank"] * acceleration,
                *(MASS["rod"] * (centre + np.array([0.0, G]))),
                INERTIA["rod"] * turns,
                MASS["slider"] * point[0],
                MASS["slider"] * G,
            ]
        )

    at_rest, matrix = inertial(0.0), np.zeros((6, 7))
    matrix[:, ACCELERATION] = -(inertial(1.0) - at_rest)
    matrix[0, 1:3] = pin[1], -pin[0]
    matrix[1, [1, 3]] = matrix[2, [2, 4]] = 1.0, -1.0
    matrix[3, 1:5] = half[1], -half[0], half[1], -half[0]
    matrix[4, [3, FRICTION]] = 1.0, 1.0
    matrix[5, [4, NORMAL]] = 1.0, 1.0
    return matrix, at_rest


def solved(φ, rate, direction, μ):
    """The unknowns while the slider slides in this direction: solved for either sign of the force across the guide; one
    of the two finds the sign that it has taken."""
    matrix, right = equations(φ, rate)
    found = []
    for sign in (1.0, -1.0):
        law = np.zeros(7)
        law[[NORMAL, FRICTION]] = μ * direction * sign, 1.0
        unknowns = np.linalg.solve(np.vstack([matrix, law]), [*right, 0.0])
        if unknowns[NORMAL] * sign >= 0.0:
            found.append(unknowns)
    assert len(found) == 1, f"{len(found)} solutions"
    return found[0]


def holds(φ, static):
    """Whether the guide holds the linkage at rest: friction within the static coefficient of the force across."""
    matrix, right = equations(φ, 0.0)
    unknowns = np.linalg.solve(matrix[:, 1:], right)
    return abs(unknowns[FRICTION - 1]) <= static * abs(unknowns[NORMAL - 1])


@dataclass
class Motion:
    """The crank's motion from an angle and a rate: `times` of the slider's reversals, and the time at which the linkage
    comes to rest and stays."""

    φ: float
    rate: float
    μ: float
    static: float
    duration: float
    times: list[float] = field(default_factory=list)
    rests: float = np.inf

    def __post_init__(self):
        t, state, self.pieces = 0.0, [self.φ, self.rate, 0.0], []
        direction = np.sign(slider(self.φ, self.rate)[1])

        def turns(t, y):
            return slider(y[0], y[1])[1]

        turns.terminal = True
        while t < self.duration:
            turns.direction = -direction
            piece = solve_ivp(
                lambda t, y, direction=direction: self.derivative(y, direction),
                (t, self.duration),
                state,
                method="DOP853",
                events=turns,
                rtol=1e-12,
                atol=1e-13,
                dense_output=True,
            )
            self.pieces.append((t, piece.sol))
            t, state = piece.t[-1], piece.y[:, -1]
            if t >= self.duration:
                break
            self.times.append(t)
            if abs(state[1]) < 1e-9 and holds(state[0], self.static):
                self.rests = t
                break
            direction = -direction

    def derivative(self, y, direction):
        """Of the angle, the rate and what friction has taken."""
        unknowns = solved(y[0], y[1], direction, self.μ)
        return [y[1], unknowns[ACCELERATION], -unknowns[FRICTION] * slider(y[0], y[1])[1]]

    def __call__(self, t):
        """The angle, the rate and the friction's loss at a time."""
        t = min(t, self.rests)
        return next(piece(t) for begins, piece in reversed(self.pieces) if begins <= t)


def energy(φ, rate):
    """Kinetic and potential energy, J."""
    ψ, turn, _ = rod(φ, rate, 0.0)
    centre = R * rate * np.array([-np.sin(φ), np.cos(φ)]) + 0.5 * L * turn * np.array([-np.sin(ψ), np.cos(ψ)])
    kinetic = INERTIA["crank"] * rate**2 + INERTIA["rod"] * turn**2 + MASS["rod"] * centre @ centre
    kinetic += MASS["slider"] * slider(φ, rate)[1] ** 2
    return 0.5 * kinetic + MASS["rod"] * G * 0.5 * R * np.sin(φ)


START = 1.0
ψ = rod(START, 0.0, 0.0)[0]
PIN = R * np.array([np.cos(START), np.sin(START)])
END = slider(START, 0.0)[0]
CENTRE = 0.5 * (PIN + np.array([END, 0.0]))
#: A ball and a universal joint hold the rod in the plane, so that no row is redundant.
PINS = f"""
  B: {{type: spherical, bodies: [crank, rod], location: [{PIN[0]}, {PIN[1]}, 0]}}
  C:
    type: universal
    bodies: [rod, slider]
    location: [{END}, 0, 0]
    axes: [[{-np.sin(ψ)}, {np.cos(ψ)}, 0], [0, 0, 1]]
"""
TEXT = f"""
mbproj: 1
gravity: [0, {-G}, 0]
simulation: {{{{duration: {{duration}}, {{steps}}, formulation: {{formulation}}}}}}
bodies:
  crank: {{{{mass: 1, inertia: [0.02, 0.02, 0.02], position: [0, 0, 0]}}}}
  rod:
    mass: {MASS["rod"]}
    inertia: [6.0e-3, 6.0e-3, 6.0e-3]
    position: [{CENTRE[0]}, {CENTRE[1]}, 0]
  slider: {{{{mass: {MASS["slider"]}, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [{END}, 0, 0]}}}}
joints:
  A: {{{{type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1], speed: {{rate}}}}}}
  D: {{{{type: prismatic, bodies: [ground, slider], location: [{END}, 0, 0], axis: [1, 0, 0]}}}}
{{pins}}
forces:
  guide: {{{{type: friction, joint: D, coulomb: {{{{coefficient: {{μ}}, static: {{static}}}}}}}}}}
"""


def linkage(rate, μ, static, duration, formulation, steps="dop853"):
    pins = PINS.strip("\n")
    return TEXT.format(
        rate=rate, μ=μ, static=static, duration=duration, formulation=formulation, pins=pins, steps=STEPS[steps]
    )
