"""The four-bar with a split coupler against Lagrange's equations in its four angles, integrated by SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eig
from scipy.optimize import fsolve

from mbproj.dynamics import NO_CONDITIONS, NO_DRIVE, coordinate_values, pose_of
from mbproj.linear import EquilibriumProblem, assembled_start
from mbproj.linear.equilibrium.find import equilibrium
from mbproj.linear.modes import modes
from mbproj.model import compile_system
from tests.mechanisms.closed_forms import expected, scene
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


@pytest.mark.full
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


def pull(θ: np.ndarray) -> np.ndarray:
    """∂V/∂θ."""
    y, y_θ = gap(θ)
    along = 1j * LENGTHS * np.exp(1j * θ)
    return ((KX * y.real - 1j * KZ * y.imag) * y_θ).real + BENT * KR * (BENT @ θ) + 9.81 * MASS @ along.imag


def test_it_rests_and_rings_as_its_four_angles_say():
    """The modes by differences of the forces, extrapolated, with the rubber's damping."""
    start = np.array([P["start"], P["tilt"], P["tilt"], P["swing"]])
    system = compile_system(SCENE)
    found = equilibrium(system, assembled_start(SCENE, system))
    coordinates = dict(zip(system.names.coordinates, found.reference.motion.expected, strict=True))
    turned = coordinates["A.angle"], coordinates["D.angle"]
    crank, near = start[0] + turned[0], start[1] + turned[0] + coordinates["B.angle"]
    far = start[1] + turned[1] - coordinates["C.angle"]
    θ = fsolve(pull, [crank, near, far, start[3] + turned[1]], xtol=1e-12)
    assert_close(np.array([crank, near, far, start[3] + turned[1]]), θ, 1e-9)
    assert found.stable
    h = 1e-3 * np.eye(4)
    differences = [np.array([pull(θ + k * e) - pull(θ - k * e) for e in h]) / (2e-3 * k) for k in (1, 2, 3)]
    K = 1.5 * differences[0] - 0.6 * differences[1] + 0.1 * differences[2]
    y_θ = gap(θ)[1]
    D = CX * np.outer(y_θ.real, y_θ.real) + CZ * np.outer(y_θ.imag, y_θ.imag) + CR * np.outer(BENT, BENT)
    one, none = np.eye(4), np.zeros((4, 4))
    λ = eig(np.block([[none, one], [-K, -D]]), np.block([[one, none], [none, mass(θ)]]), right=False)
    λ = λ[λ.imag > 0]
    np.testing.assert_allclose(modes(found.reference).eigenvalues, λ[np.argsort(np.abs(λ))], rtol=1e-8)


def test_steps_to_where_the_rubber_has_no_direction_are_not_taken():
    """Its frames would stand half a turn apart: other equilibria are sought from elsewhere."""
    system = compile_system(SCENE)
    start = assembled_start(SCENE, system)
    problem = EquilibriumProblem.of(system, 0.0, start.q, NO_DRIVE, NO_CONDITIONS, start.x)
    here = problem.at(start.q, coordinate_values(system, pose_of(start.q)))
    turns = here.space.N.reshape(system.bodies, 6, -1)[:, 4]
    far = np.linalg.lstsq(turns, np.array([0.0, 3.13, 0.0, 0.0]), rcond=None)[0]
    assert None in [here.after(part * far) for part in np.linspace(0.7, 1.3, 61)]
    assert here.after(0.1 * far) is not None
