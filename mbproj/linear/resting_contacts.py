"""A mechanism for equilibria and small motions: compliant stops are laws, dry friction at rest holds its coordinate,
and dry friction that slides is a law. The caller treats dry friction at stops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State, coordinate_values
from mbproj.dynamics.contact.freedom import Freedom
from mbproj.dynamics.derivatives.linear_equations import MotionAtTime, constraint_rows
from mbproj.dynamics.derivatives.row_derivatives import row_motion
from mbproj.dynamics.derivatives.tangent import tangent_velocities
from mbproj.dynamics.equations.gaps import counted_values
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.friction.shared_loads import refuse_shared_loads
from mbproj.errors import InputError, Problem
from mbproj.integrate.stops.rubbing import at_rest, friction_rates
from mbproj.linear.bordered import along_tangent_space
from mbproj.model.contacts import Contacts, in_contact, standing_on_stops
from mbproj.model.frictions import Frictions
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class RestingContacts:
    """The `system` with its compliant stops as laws and its frictions as rows or laws; `whole`: the system without the
    frictions. `by`: the names of those that hold, each by one of the last rows of the joints."""

    system: System
    whole: System
    by: tuple[str, ...] = ()


def held_at(system: System, state: State, *, resting: bool = False) -> RestingContacts:
    """Return the contacts at a state; with `resting`, its velocities do not count. Raises InputError where a friction
    slides that depends on the load of a bearing."""
    whole = standing_on_stops(system, _soft(system, state))
    frictions = system.frictions
    if frictions is None:
        return RestingContacts(whole, whole)
    rests, of_joints = np.ones(frictions.size, dtype=bool), frictions.stop < 0
    if not resting:
        rests = at_rest(system, state)
    refuse_shared_loads(system, state)
    _refuse_sliding_by_load(system, frictions, rests)
    value = counted_values(frictions.coordinates, frictions.joint_coordinate, pose_of(state.q), state.turns)
    rate = friction_rates(system, state)
    contacts = Contacts(
        stuck={k: float(value[k]) for k in _independent(whole, frictions, state, np.flatnonzero(rests & of_joints))},
        sliding={int(k): float(np.sign(rate[k])) for k in np.flatnonzero(~rests & of_joints)},
    )
    by = tuple(system.names.frictions[k] for k in contacts.stuck)
    return RestingContacts(_with_names(whole, in_contact(whole, contacts), contacts), whole, by)


def _soft(system: System, state: State) -> dict[int, float]:
    """Return the coefficient of damping of each compliant stop, with the mass that it meets at a state where its
    restitution needs one."""
    stops = system.stops
    if stops is None:
        return {}
    soft = np.flatnonzero(~stops.is_rigid).tolist()
    if not stops.resistance[soft].any():
        return {k: stops.pushes_by(k, np.zeros(0)) for k in soft}
    N = Freedom.at(system, state).rows(stops)
    return {k: stops.pushes_by(k, N[k]) for k in soft}


def _refuse_sliding_by_load(system: System, frictions: Frictions, rests: Flags) -> None:
    problems = [
        Problem(
            f"dry friction '{system.names.frictions[k]}' slides here, by the load of its bearing: that has no linear "
            "part here",
            frictions.places[k],
            "take a time at which it sticks, or give a constant torque or force in place of 'coefficient'",
        )
        for k in np.flatnonzero(~rests & (frictions.bearing >= 0))
    ]
    if problems:
        raise InputError(problems)


def _independent(system: System, frictions: Frictions, state: State, among: Integers) -> list[int]:
    """Return the frictions whose coordinates joints, motions and earlier frictions leave free."""
    pose = pose_of(state.q)
    expected = coordinate_values(system, pose) + 2.0 * np.pi * state.turns
    u = tangent_velocities(pose, state.v)
    motion = MotionAtTime(state.t, state.q, u, np.zeros_like(u), expected, state.x)
    scale = np.where(frictions.coordinates.is_length, system.length, 1.0)
    g = row_motion(frictions.coordinates, motion.carried()).G.dense() / scale[:, None]
    rows = along_tangent_space(system, constraint_rows(system, motion), g)
    chosen: list[int] = []
    basis = np.zeros((0, rows.shape[1]))
    for k in among.tolist():
        beyond: Array = rows[k]
        for _ in range(2):  # once is not enough for rows that are almost inside (Björck 1994)
            beyond = beyond - basis.T @ (basis @ beyond)
        size = float(np.linalg.norm(beyond))
        if size > THRESHOLDS.dependent:
            chosen.append(k)
            basis = np.vstack([basis, beyond / size])
    return chosen


def _with_names(whole: System, held: System, contacts: Contacts) -> System:
    """Return the system with names for the laws of sliding frictions."""
    if not contacts.sliding:
        return held
    laws = whole.forces.laws.size
    names, units, own = whole.names.forces, whole.names.force_units, sorted(contacts.sliding)
    return replace(
        held,
        names=replace(
            held.names,
            forces=(*names[:laws], *(whole.names.frictions[k] for k in own), *names[laws:]),
            force_units=(*units[:laws], *(whole.names.friction_units[k] for k in own), *units[laws:]),
        ),
    )


def refuse_loads(system: System, where: str) -> None:
    """Raise InputError where a law depends on the load of a bearing."""
    forces = system.forces
    problems = [
        Problem(f"force '{forces.law_owners[k]}' depends on the load of its bearing: it {where}", hint=LOAD_HINT)
        for k in np.flatnonzero(forces.laws.bearing >= 0)
    ]
    if problems:
        raise InputError(problems)


LOAD_HINT = "give a constant torque or force in place of 'coefficient'"
