"""The four-bar with a split coupler against Lagrange's equations in its four angles, integrated by SciPy."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from tests.mechanisms.expected import expected, scene
from tests.mechanisms.running import assert_close

SCENE = scene("split_coupler")
P = SCENE.parameters
#: Of crank, near half, far half and rocker: mass, and moment of inertia about the y axis.
MASS = np.array([body.mass for body in SCENE.bodies])
INERTIA = np.array([body.inertia[1][1] for body in SCENE.bodies])
#: Way from the ground to each centre of mass, as factors of e^iθ of the four angles; then the gap between the halves.
LENGTHS = np.array(
    [
        [P["crank"] / 2, 0.0, 0.0, 0.0],
        [P["crank"], P["coupler"] / 4, 0.0, 0.0],
        [0.0, 0.0, -P["coupler"] / 4, P["rocker"]],
        [0.0, 0.0, 0.0, P["rocker"] / 2],
    ]
)
GAP = np.array([-P["crank"], -P["coupler"] / 2, -P["coupler"] / 2, P["rocker"]])
BENT = np.array([0.0, -1.0, 1.0, 0.0])
SHARE = np.array([0.0, 0.5, 0.5, 0.0])
KX, KZ, KR = P["along"], P["transverse"], P["bending"]
CX, CZ, CR = 20.0, 10.0, 0.02


def gap(θ: np.ndarray) -> tuple[complex, np.ndarray]:
    """The gap y = x + i z seen from midway between the halves, and ∂y/∂θ."""
    midway = np.exp(-1j * (SHARE @ θ))
    y = midway * (P["frame"] + GAP @ np.exp(1j * θ))
    return y, midway * 1j * GAP * np.exp(1j * θ) - 1j * SHARE * y


def mass(θ: np.ndarray) -> np.ndarray:
    along = LENGTHS * np.exp(1j * θ)
    return np.einsum("b,bk,bl->kl", MASS, along.conj(), along).real + np.diag(INERTIA)


def lagrange(_: float, state: np.ndarray) -> np.ndarray:
    """θ'' from M θ'' = Q, and what the rubber loses, 2 R."""
    θ, rate = state[:4], state[4:8]
    along = 1j * LENGTHS * np.exp(1j * θ)  # ∂r/∂θ of each body
    bias = -(LENGTHS * np.exp(1j * θ)) @ rate**2
    y, y_θ = gap(θ)
    y_dot, bent, bent_dot = y_θ @ rate, BENT @ θ, BENT @ rate
    force = KX * y.real + CX * y_dot.real - 1j * (KZ * y.imag + CZ * y_dot.imag)
    Q = -(force * y_θ).real - BENT * (KR * bent + CR * bent_dot)
    Q -= ((MASS * bias.conj()) @ along).real + 9.81 * MASS @ along.imag
    loss = CX * y_dot.real**2 + CZ * y_dot.imag**2 + CR * bent_dot**2
    return np.concatenate([rate, np.linalg.solve(mass(θ), Q), [loss]])


def test_the_split_coupler_by_lagranges_equations():
    tilt = P["tilt"]
    start = np.array([P["start"], tilt, tilt, P["swing"]])
    state = np.array([*start, *(P[name] for name in ("speed", "coupler_speed", "coupler_speed", "rocker_speed")), 0.0])
    times = np.arange(201) * 0.005
    done = solve_ivp(lagrange, (0.0, times[-1]), state, method="DOP853", rtol=1e-9, atol=1e-12, t_eval=times)
    θ = done.y[:4]
    assert_close(expected("split_coupler", "crank"), θ[0, -1] - start[0], 1e-8)
    assert_close(expected("split_coupler", "rocker"), θ[3, -1] - start[3], 1e-8)
    assert_close(expected("split_coupler", "lost"), done.y[8, -1], 1e-9)
    assert_close(expected("split_coupler", "gap"), np.abs([gap(each)[0] for each in θ.T]).max(), 1e-9)
    assert_close(expected("split_coupler", "bent"), np.abs(BENT @ θ).max(), 1e-8)
