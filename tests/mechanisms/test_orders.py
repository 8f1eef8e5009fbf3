"""Every integrator keeps its order, in NumPy and in the kernel, on motions that rotate, translate, and do both."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from mbproj.base.registry import integrators
from tests.crossed import full, where
from tests.integrate.event_scenes import run

HEAD = "mbproj: 1\nsimulation: {duration: 1 s}\n"
SPIN = (
    HEAD
    + """
gravity: [0, 0, 0]
bodies: {b: {mass: 1, inertia: [0.1, 0.12, 0.15], position: [0, 0, 0], angular_velocity: [0, 0, 50]}}
markers: {m: {body: b, location: [1, 0, 0]}}
"""
)
FLYWHEELS = (
    HEAD
    + """
gravity: [0, 0, -9.81]
bodies:
  a: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0], angular_velocity: [0, 0, 20]}
  b: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0]}
joints:
  A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: [0, 0, 1]}
  B: {type: revolute, bodies: [ground, b], location: [1, 0, 0], axis: [0, 1, 0]}
forces:
  ta: {type: torque, body: a, torque: [0, 0, 3], axes: global}
  tb: {type: torque, body: b, torque: [0, 5, 0], axes: global}
markers: {ma: {body: a, location: [1, 0, 0]}, mb: {body: b, location: [2, 0, 0]}}
"""
)
SPRING = (
    HEAD
    + """
gravity: [0, 0, 0]
bodies: {b: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0], velocity: [3, 0, 0]}}
joints: {rail: {type: prismatic, bodies: [ground, b], location: [0, 0, 0], axis: [1, 0, 0]}}
forces: {spring: {type: linear_spring_damper, joint: rail, stiffness: 200}}
markers: {m: {body: b, location: [0, 0, 0]}}
"""
)
#: A pendulum that swings by 2 rad, beside a rotor that a constant torque speeds up.
BESIDE = (
    HEAD
    + """
gravity: [0, 0, -9.81]
bodies:
  bob: {mass: 1, inertia: [1.0e-9, 1.0e-9, 1.0e-9], position: [sin(2), 0, -cos(2)]}
  rotor: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [3, 0, 0], angular_velocity: [0, 20, 0]}
joints:
  pin: {type: revolute, bodies: [ground, bob], location: [0, 0, 0], axis: [0, 1, 0]}
  axle: {type: revolute, bodies: [ground, rotor], location: [3, 0, 0], axis: [0, 1, 0]}
forces: {push: {type: torque, body: rotor, torque: [0, 3, 0], axes: global}}
markers: {bob: {body: bob, location: [sin(2), 0, -cos(2)]}, rim: {body: rotor, location: [4, 0, 0]}}
"""
)


def spun(t: float) -> list[list[float]]:
    return [[np.cos(50 * t), np.sin(50 * t), 0]]


def sped_up(t: float) -> list[list[float]]:
    a, b = 20 * t + 15 * t * t, 25 * t * t
    return [[np.cos(a), np.sin(a), 0], [1 + np.cos(b), 0, -np.sin(b)]]


def swung(t: float) -> list[list[float]]:
    return [[0.3 * np.sin(10 * t), 0, 0]]


def beside(t: float) -> list[list[float]]:
    """The pendulum in Jacobi's functions: sin(θ/2) = k cd(ω t)."""
    k, frequency, turned = np.sin(1.0), np.sqrt(9.81 / (1 + 1e-9)), 20 * t + 15 * t * t
    sn, *_ = ellipj(ellipk(k * k) + frequency * t, k * k)
    angle = 2 * np.arcsin(k * sn)
    return [[np.sin(angle), 0, -np.cos(angle)], [3 + np.cos(turned), 0, -np.sin(turned)]]


#: The scene, what is right, until when, and whether it is plane.
MOTIONS = {
    "turning": (SPIN, spun, 0.1, False),
    "speeding up": (FLYWHEELS, sped_up, 0.25, False),
    "translating": (SPRING, swung, 0.5, True),
    "both": (BESIDE, beside, 0.25, True),
}
METHODS = sorted(set(integrators()) - {"auto"})
#: With the equations in NumPy, hundreds of times slower: one method of each kind, on all that moves at once.
RUNS = [
    *(
        (name, formulation, method)
        for name, (*_, plane) in MOTIONS.items()
        for formulation in ("reduced", *(["planar"] if plane else []))
        for method in METHODS
    ),
    *(("both", "full", method) for method in ("rk4", "dop853", "radau5")),
]
#: Steps that resolve 5 rad: above round-off, and so many that the order shows.
COUNTS = {2: (160, 320), 3: (80, 160), 4: (40, 80), 5: (24, 48), 8: (12, 24)}


def off(text, exact, until: float, steps: int, **options: str) -> float:
    recorder, _ = run(text, duration=repr(until), step=repr(until / steps), output_step=repr(until), **options)
    return float(np.abs(recorder["markers/position"][-1] - exact(until)).max())


@pytest.mark.parametrize(
    ("motion", "formulation", "integrator"),
    where(lambda motion, formulation, method: (motion, formulation) == ("both", "reduced") or method == "rk4", RUNS),
)
def test_orders(motion, formulation, integrator):
    """Or more, where the motion is simple."""
    text, exact, until, _ = MOTIONS[motion]
    order = integrators()[integrator].order
    keys = {"integrator": integrator, "formulation": formulation}
    coarse, fine = (off(text, exact, until, steps, **keys) for steps in COUNTS[order])
    assert fine < 1e-12 or np.log2(coarse / fine) > order - 0.4, (coarse, fine)


@pytest.mark.parametrize("formulation", [full("full"), "reduced"])
def test_radau_on_steady_and_evenly_accelerated_rotation(formulation):
    """Coupled stages are solved when their orientations are, too: accelerations alone are right from the first pass."""
    keys = {"integrator": "radau5", "formulation": formulation}
    assert off(SPIN, spun, 0.4, 100, **keys) < 2e-7
    if formulation == "reduced":
        assert off(FLYWHEELS, sped_up, 0.5, 250, **keys) < 4e-10
