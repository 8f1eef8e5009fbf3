"""The motion that is linearised: its accelerations and multipliers, and the imbalance of forces there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.base.arrays import Array, Flags, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, coordinate_values
from mbproj.equations.contacts import Freedom
from mbproj.equations.derivatives import MotionAtTime, constraint_rows, mass_blocks, row_motion, tangent_force
from mbproj.equations.forces import law_state
from mbproj.equations.friction import refuse_shared_loads
from mbproj.equations.gaps import counted_values
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.motions import drive_at
from mbproj.equations.of_motion import tangent_mass_matrix
from mbproj.equations.rank.row_space import tangent_gamma
from mbproj.equations.tangent_space import tangent_lengths, tangent_space, tangent_velocities
from mbproj.linear.bordered import Bordered, along_tangent_space, independent_rows
from mbproj.model.contacts import Contacts, Frictions, in_contact, standing_on_stops
from mbproj.model.system import System
from mbproj.motion.contacts import at_rest, friction_rates

# --- A mechanism for equilibria and small motions ---------------------------------------------------------------------
# Compliant stops are laws, dry friction at rest holds its coordinate, and dry friction that slides is a law. The
# caller treats dry friction at stops.


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
    names, units, sliding = whole.names.forces, whole.names.force_units, sorted(contacts.sliding)
    return replace(
        held,
        names=replace(
            held.names,
            forces=(*names[:laws], *(whole.names.frictions[k] for k in sliding), *names[laws:]),
            force_units=(*units[:laws], *(whole.names.friction_units[k] for k in sliding), *units[laws:]),
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


# --- The motion that is linearised ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Imbalance:
    """The largest force in N and torque in N m on a body that neither constraints nor a steady motion balance.
    `relative`: the larger of both, relative to the largest torque that acts."""

    force: float
    torque: float
    relative: float


@dataclass(frozen=True, eq=False)
class LinearReference:
    """A motion with its multipliers λ (m,) of the joints' rows and then the motions'.

    `turning` (3,): Ω in rad/s of the axes that turn with it. `where`: "start", "equilibrium", "steady", or a time.
    `held`: the dry frictions that hold, each by one of the last rows of the joints."""

    system: System
    motion: MotionAtTime
    multipliers: Array
    imbalance: Imbalance
    where: str
    turning: Array
    held: tuple[str, ...] = ()

    @property
    def moves(self) -> bool:
        """Whether anything moves faster than round-off."""
        return bool(np.abs(self.motion.u).max(initial=0.0) > 0.0)

    @property
    def rests(self) -> bool:
        """Whether neither bodies nor axes move."""
        return not (self.moves or np.any(self.turning))

    @property
    def words(self) -> str:
        """The place of the reference, in words: "at start", "at t = 0.5 s"."""
        return f"at {self.where}" if self.where.isalpha() else f"at t = {self.motion.t:.6g} s"


def reference_at(system: System, state: State, where: str) -> LinearReference:
    """Return the motion through a consistent state, with accelerations and multipliers by the equations of motion."""
    held = held_at(system, state)
    system = held.system
    pose = pose_of(state.q)
    twist, u = twist_of(pose, state.v), tangent_velocities(pose, state.v)
    expected = coordinate_values(system, pose) + 2.0 * np.pi * state.turns
    still = MotionAtTime(state.t, state.q, u, np.zeros_like(u), expected, state.x)
    γ = tangent_gamma(system, pose, twist, drive_at(system, state.t))
    force = tangent_force(system, still)
    solve = _by_bordered if system.bodies > THRESHOLDS.large else _by_tangent_space
    change, multipliers, left = solve(system, still, force, γ)
    motion = MotionAtTime(state.t, state.q, u, change, expected, state.x)
    largest = largest_force(system, still, force)
    return LinearReference(system, motion, multipliers, imbalance(system, left, largest), where, np.zeros(3), held.by)


def refuse_rolling(system: System, what: str) -> None:
    """Raise InputError that names the joint where rows are at velocity level."""
    if system.rolls:
        joint = int(system.joints.owner[np.argmax(system.joints.is_velocity)])
        said = f"joint '{system.names.joints[joint]}' holds velocities: {what} such rows"
        raise InputError(Problem(said, system.joint_places[joint], "`mbproj run` and `mbproj modes` do"))


def _by_tangent_space(system: System, still: MotionAtTime, force: Array, γ: Array) -> tuple[Array, Array, Array]:
    """Return u' (6n,), λ (m,), and the unbalanced forces (6n,), by the tangent space."""
    space = tangent_space(system, constraint_rows(system, still).dense())
    M, lengths = tangent_mass_matrix(system, still.pose), tangent_lengths(system)
    held = space.pseudoinverse @ γ
    free = space.N.T @ (force - M @ held)
    change = held + space.N @ np.linalg.lstsq(space.N.T @ M @ space.N, free, rcond=THRESHOLDS.no_digits)[0]
    multipliers = space.pseudoinverse.T @ (force - M @ change)
    return change, multipliers, space.N @ free / lengths**2


def _by_bordered(system: System, still: MotionAtTime, force: Array, γ: Array) -> tuple[Array, Array, Array]:
    """Return u' (6n,), λ (m,), and the unbalanced forces (6n,) of a large mechanism, by sparse matrices."""
    from scipy.sparse import diags

    lengths, G, pose = tangent_lengths(system), constraint_rows(system, still), still.pose
    rows = independent_rows(system, pose, G)
    change, multipliers = Bordered(system, mass_blocks(system, still).sparse(), G, rows).solve(force, γ)
    left = Bordered(system, diags(lengths**-2), G, rows).solve(force)[0]
    return change, multipliers, left / lengths**2


def largest_force(system: System, motion: MotionAtTime, force: Array) -> float:
    """Return the largest torque, or force times the mechanism's length, in N m. It acts on a body (6n,), or along a
    coordinate: forces on a body may cancel each other."""
    largest = float(np.abs(force * tangent_lengths(system)).max(initial=0.0))
    laws = law_state(motion.instant(system))
    unit = np.where(np.array(system.forces.units) == "m", system.length, 1.0)
    return max(largest, float(np.abs(laws.force * unit).max(initial=0.0)))


def imbalance(system: System, left: Array, largest: float) -> Imbalance:
    """Return the imbalance of the forces `left` (6n,), relative to the largest torque that acts."""
    left = left.reshape(-1, 6)
    sizes = np.linalg.norm(left[:, :3], axis=1).max(initial=0.0), np.linalg.norm(left[:, 3:], axis=1).max(initial=0.0)
    relative = max(float(sizes[0]) * system.length, float(sizes[1])) / max(largest, float(np.finfo(float).tiny))
    return Imbalance(float(sizes[0]), float(sizes[1]), relative)
