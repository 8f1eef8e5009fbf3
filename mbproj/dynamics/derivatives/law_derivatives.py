"""Derivatives of the forces of laws, of given forces, and of the rates of elements' states.

A law has slopes ∂F/∂s, ∂F/∂s' and slopes by the channels that it names. A given force changes because its arm and its
axes turn with the body."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dynamics.blocks import Blocks, Rows
from mbproj.dynamics.derivatives.row_derivatives import tilde
from mbproj.dynamics.equations.forces import LawState, given_components, law_coordinates
from mbproj.dynamics.equations.instant import Instant
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.functions.program import CHANNELS, COORDINATE, RATE
from mbproj.functions.program_set import ProgramSet
from mbproj.functions.series import slope, slopes
from mbproj.model.forces import Forces


def law_slopes(instant: Instant, laws: LawState) -> tuple[Array, Array]:
    """Return ∂F/∂s and ∂F/∂s' of each law, (E,) each; not finite where a function has no slope."""
    forces = instant.system.forces
    by_variable = [-forces.laws.stiffness, -forces.laws.damping]
    for law in np.flatnonzero(forces.laws.program >= 0):
        at = instant.values(laws.value[law], laws.rate[law])
        for order, variable in enumerate((COORDINATE, RATE)):
            by_variable[order][law] += slope(forces.programs, int(forces.laws.program[law]), at, variable)
    return by_variable[0], by_variable[1]


def channel_slopes(instant: Instant) -> tuple[Array, Array]:
    """Return the derivatives by channels: of forces, (E + 3G, c), and of the rates x' of elements' states, (K, c).

    Forces are those of the E laws, and then the three components of each of G given forces. Without a slope a function
    counts as constant. The slope by a law's own coordinate, which is no channel, is in `law_slopes`."""
    forces, programs, rates = instant.system.forces, instant.system.programs, _rates_by_channels(instant)
    value, rate = law_coordinates(instant)
    of_laws = np.zeros((forces.laws.size, rates.shape[1]))
    for law in np.flatnonzero(forces.laws.program >= 0).tolist():
        of_laws[law] = slopes_by_channels(
            programs, int(forces.laws.program[law]), instant.values(value[law], rate[law])
        )
    given = [slopes_by_channels(programs, each, instant.values()) for each in forces.on_bodies.program.ravel().tolist()]
    all_slopes = np.concatenate([of_laws, np.array(given).reshape(-1, rates.shape[1])])
    return tuple(np.nan_to_num(part, nan=0.0, posinf=0.0, neginf=0.0) for part in (all_slopes, rates))  # type: ignore[return-value]


def state_slopes(instant: Instant) -> Array:
    """Return f_x (K, K) of x' = f; where it has no slope a function counts as constant."""
    channels, slopes = instant.system.channels, _rates_by_channels(instant)
    matrix = np.zeros((len(slopes), len(slopes)))
    known = np.nan_to_num(slopes[:, channels.is_state], nan=0.0, posinf=0.0, neginf=0.0)
    matrix[:, channels.index[channels.is_state]] = known
    return matrix


def _rates_by_channels(instant: Instant) -> Array:
    """Return ∂x'/∂channel, (K, c)."""
    first, at = instant.system.first_rate, instant.values()
    rows = [slopes_by_channels(instant.system.programs, first + row, at) for row in range(instant.x.shape[-1])]
    return np.array(rows, dtype=float).reshape(len(rows), len(at) - CHANNELS)


def slopes_by_channels(programs: ProgramSet, program: int, at: list[Numbers]) -> Array:
    """Return the slopes of a program by each channel, (c,), at values of all variables; 0 for a channel it does not
    name."""
    by_channels, named = np.zeros(len(at) - CHANNELS), programs.channels(program)
    by_channels[named - CHANNELS] = slopes(programs, program, at, named)
    return by_channels


def given_rows(forces: Forces, pose: Pose) -> Rows:
    """Return the generalised force of a unit of each of the three components of each given force and torque, (3W,
    6n)."""
    given, turn = forces.on_bodies, pose.rotation[forces.on_bodies.body]
    unit = np.where(given.in_body[:, None, None], np.swapaxes(given.turn, -1, -2), turn)  # (W, 3, 3) in body axes
    value = np.concatenate([np.zeros_like(unit), unit], axis=-1)
    moment, acts = np.cross(given.point[:, None, :], unit), ~given.is_torque
    value[acts] = np.concatenate([unit @ np.swapaxes(turn, -1, -2), moment], axis=-1)[acts]
    count = 3 * given.size
    return Rows.of(count, len(pose.position) - 1, np.arange(count), np.repeat(given.body, 3), value.reshape(-1, 6))


def given_derivative(instant: Instant) -> Blocks:
    """Return the derivative by ξ of the given forces and torques on the bodies, without the part through channels."""
    given, pose, vector = instant.system.forces.on_bodies, instant.pose, given_components(instant)
    bodies = len(pose.position) - 1
    carried = (given.turn @ vector[..., None])[..., 0]
    turn = pose.rotation[given.body]
    in_axes = np.where(given.in_body[:, None], carried, (np.swapaxes(turn, -1, -2) @ vector[..., None])[..., 0])
    value = np.zeros((given.size, 6, 6))
    follows, acts = given.in_body, ~given.is_torque
    value[follows & acts, :3, 3:] = -(turn @ tilde(in_axes))[follows & acts]
    value[~follows & acts, 3:, 3:] = (tilde(given.point) @ tilde(in_axes))[~follows & acts]
    value[~follows & ~acts, 3:, 3:] = tilde(in_axes)[~follows & ~acts]
    return Blocks.of(bodies, given.body, given.body, value)
