"""The motion that is linearised: its accelerations and multipliers, and the imbalance of forces there."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State, coordinate_values
from mbproj.dynamics.derivatives.linear_equations import MotionAtTime, constraint_rows, mass_blocks, tangent_force
from mbproj.dynamics.derivatives.tangent import tangent_velocities
from mbproj.dynamics.derivatives.tangent_space import tangent_lengths, tangent_space
from mbproj.dynamics.equations.equations_of_motion import tangent_mass_matrix
from mbproj.dynamics.equations.forces import law_state
from mbproj.dynamics.equations.kinematics import pose_of, twist_of
from mbproj.dynamics.equations.motions import drive_at
from mbproj.dynamics.rank.right_hand_sides import tangent_gamma
from mbproj.errors import InputError, Problem
from mbproj.linear.bordered import Bordered
from mbproj.linear.independent_rows import independent_rows
from mbproj.linear.resting_contacts import held_at
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


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
