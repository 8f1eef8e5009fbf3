"""What the forces of a scene change by: of every law its slopes ∂F/∂s and ∂F/∂s', of given forces that their arms and
their axes turn with the body; and what the rates of elements' states change by."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.blocks import Blocks
from mbproj.dynamics.derivatives.row_derivatives import tilde
from mbproj.dynamics.equations.forces import LawState
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.functions.program import COORDINATE, RATE
from mbproj.functions.series import constant_series, run, slope, time_series
from mbproj.model.forces import Forces
from mbproj.model.layout import ElementStates


def law_slopes(forces: Forces, laws: LawState, t: float) -> tuple[Array, Array]:
    """∂F/∂s and ∂F/∂s' of each law, (E,) each; not finite where a function has no slope."""
    found = [-forces.laws.stiffness, -forces.laws.damping]
    for law in np.flatnonzero(forces.laws.program >= 0):
        at = [np.asarray(t), laws.value[law], laws.rate[law]]
        for order, variable in enumerate((COORDINATE, RATE)):
            found[order][law] += slope(forces.programs, int(forces.laws.program[law]), at, variable)
    return found[0], found[1]


def given_derivative(forces: Forces, pose: Pose, t: float) -> Blocks:
    """∂/∂ξ of the given forces and torques on the bodies."""
    given, bodies = forces.on_bodies, len(pose.position) - 1
    time = time_series(np.asarray(t))
    vector = np.array([[float(run(forces.programs, index, [time])[0]) for index in row] for row in given.program])
    vector = vector.reshape(-1, 3)
    carried = (given.turn @ vector[..., None])[..., 0]
    turn = pose.rotation[given.body]
    in_axes = np.where(given.in_body[:, None], carried, (np.swapaxes(turn, -1, -2) @ vector[..., None])[..., 0])
    value = np.zeros((given.size, 6, 6))
    follows, acts = given.in_body, ~given.is_torque
    value[follows & acts, :3, 3:] = -(turn @ tilde(in_axes))[follows & acts]
    value[~follows & acts, 3:, 3:] = (tilde(given.point) @ tilde(in_axes))[~follows & acts]
    value[~follows & ~acts, 3:, 3:] = tilde(in_axes)[~follows & ~acts]
    return Blocks.of(bodies, given.body, given.body, value)


def state_slopes(states: ElementStates, t: float, x: Array) -> Array:
    """f_x (K, K) at t; what has no slope there counts as constant."""
    none, unit = np.zeros(len(x)), np.eye(len(x))
    variables = [constant_series(t + none), *((value + none, own, none) for value, own in zip(x, unit, strict=True))]
    found = np.array([run(states.rates, k, variables)[1] + none for k in range(len(x))])
    return np.nan_to_num(found, nan=0.0, posinf=0.0, neginf=0.0)
