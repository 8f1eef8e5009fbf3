"""The linear model: states are displacements and speeds along the tangent space, and value and rate of each motion that
is an input, whose second derivative the input is.

With ξ = N η + B w, where B w is the smallest displacement that motions ask for,

    NᵀMN η'' + NᵀDN η' + NᵀKN η = NᵀF u - NᵀM B w'' - NᵀD B w' - NᵀK B w,      δλ = (G⁺)ᵀ (F u - M ξ'' - D ξ' - K ξ).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Place, Problem, placed_at
from mbproj.linear.modes import refuse_kinks
from mbproj.linear.reduction import Projected, projected
from mbproj.linear.reference import Reference
from mbproj.linear.state_space.inputs import Inputs, inputs_named
from mbproj.linear.state_space.outputs import Outputs, outputs_named
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class LinearModel:
    """x' = A x + B u, y = C x + D u, of small changes from the reference. Names and units of x, u and y."""

    reference: Reference
    A: Array
    B: Array
    C: Array
    D: Array
    states: tuple[str, ...]
    state_units: tuple[str, ...]
    inputs: tuple[str, ...]
    input_units: tuple[str, ...]
    outputs: tuple[str, ...]
    output_units: tuple[str, ...]

    @property
    def matrices(self) -> tuple[Array, Array, Array, Array]:
        """A, B, C, D, as `scipy.signal.StateSpace(*model.matrices)` and python-control's `ss` take them."""
        return self.A, self.B, self.C, self.D


def linear_model(reference: Reference, inputs: Sequence[str], outputs: Sequence[str]) -> LinearModel:
    """The model at a reference that does not turn its tangent space. Raises InputError for names that there are not,
    and where the mechanism moves, is too large, or has motions without mass."""
    system = reference.system
    if system.bodies > THRESHOLDS.dense_modes:
        said = (
            f"linear models are made for up to {THRESHOLDS.dense_modes} bodies, and this mechanism has {system.bodies}"
        )
        raise InputError(Problem(said, hint="`mbproj modes` finds the slowest modes of more"))
    refuse_kinks(reference)
    with placed_at(Place("--inputs")):
        u = inputs_named(reference, inputs)
    with placed_at(Place("--outputs")):
        y = outputs_named(reference, outputs)
    here = projected(reference)
    if np.abs(here.N_dot).max(initial=0.0) > THRESHOLDS.linear_round_off * np.abs(here.space.N).max(initial=1.0):
        said = "the mechanism moves here, so that its linear model changes with time"
        raise InputError(Problem(said, hint="linearise where it rests: --at equilibrium"))
    if np.linalg.svd(here.reduced.weighs, compute_uv=False).min(initial=1.0) <= THRESHOLDS.dependent:
        said = "a motion moves no mass: it has no state of its own, which this linear model would need"
        raise InputError(Problem(said, hint="give what moves some mass; `mbproj modes` needs none"))
    return _assembled(reference, here, u, y)


def _assembled(reference: Reference, here: Projected, u: Inputs, y: Outputs) -> LinearModel:
    system = reference.system
    N, pseudoinverse = here.space.N, here.space.pseudoinverse
    M, D, K = (part.dense() for part in (here.equations.M, here.equations.D, here.equations.K))
    to_body = _to_body(reference)
    force = to_body.T @ u.force
    driven = [int(motion) for motion in u.motion if motion >= 0]
    B_w = pseudoinverse[:, [system.joints.size + motion for motion in driven]]
    f, k, p = N.shape[1], len(driven), len(u.names)
    w_ddot = np.zeros((k, p))
    w_ddot[np.arange(k), np.flatnonzero(u.motion >= 0)] = 1.0
    # ξ'', ξ' and ξ by x = (η, w, η', w') and u.
    ξ = np.concatenate([N, B_w, np.zeros_like(N), np.zeros_like(B_w)], axis=1)
    ξ_dot = np.concatenate([np.zeros_like(N), np.zeros_like(B_w), N, B_w], axis=1)
    mass = N.T @ M @ N
    of_x = -np.linalg.solve(mass, N.T @ (K @ ξ + D @ ξ_dot))
    of_u = np.linalg.solve(mass, N.T @ (force - M @ B_w @ w_ddot))
    half = f + k
    A, B = np.zeros((2 * half, 2 * half)), np.zeros((2 * half, p))
    A[:half, half:] = np.eye(half)
    A[half : half + f], B[half : half + f] = of_x, of_u
    B[half + f :] = w_ddot
    λ_x = pseudoinverse.T @ -(M @ N @ of_x + D @ ξ_dot + K @ ξ)
    λ_u = pseudoinverse.T @ (force - M @ (N @ of_u + B_w @ w_ddot))
    joints = slice(0, system.joints.size)
    C = y.of_displacement @ to_body @ ξ + y.of_rate @ to_body @ ξ_dot + y.of_multiplier @ λ_x[joints]
    names = [*(f"displacement_{i + 1}" for i in range(f)), *(system.names.motions[motion] for motion in driven)]
    units = [*["1"] * f, *(system.names.motion_units[motion] for motion in driven)]
    return LinearModel(
        reference,
        A,
        B,
        C,
        y.of_multiplier @ λ_u[joints],
        (*names, *(f"{name}_speed" for name in names)),
        (*units, *("1/s" if unit == "1" else f"{unit}/s" for unit in units)),
        u.names,
        u.units,
        y.names,
        y.units,
    )


def _to_body(reference: Reference) -> Array:
    """Virtual displacements in body axes from those in global axes, (6n, 6n)."""
    n = reference.system.bodies
    found, every = np.zeros((n, 6, n, 6)), np.arange(n)
    found[every, :3, every, :3] = np.eye(3)
    found[every, 3:, every, 3:] = np.swapaxes(reference.motion.pose.rotation[:-1], -1, -2)
    return found.reshape(6 * n, 6 * n)
