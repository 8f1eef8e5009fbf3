"""The search for an equilibrium: Newton's method on the tangent space, within a radius in which its model holds.

It minimises the energy, measured by the work of the forces between two poses, because forces of a scene need not have a
potential. So the path leads downhill, past unstable equilibria, unless it begins at one. Where the path does not end,
because forces without a potential act, the residual is minimised.

For steps within a radius see Conn, Gould and Toint 2000, ch. 7.
"""

from __future__ import annotations

from typing import Protocol, TypeVar, final

import numpy as np

from mbproj.base.arrays import Array, cross
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode, MbprojError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.derivatives import MotionAtTime, row_motion
from mbproj.equations.kinematics import attached, slots_of
from mbproj.equations.rank.row_space import direction
from mbproj.equations.tangent_space import TangentSpace, tangent_lengths
from mbproj.linear.equilibrium.balance import (
    AnyBalance,
    EquilibriumBalance,
    EquilibriumProblem,
    Unbalanced,
    displacement_between,
)
from mbproj.model.planar.certain import kind_of
from mbproj.model.system import System

# --- Directions of motion in words ------------------------------------------------------------------------------------
# By the joint coordinates that change most, or by the motion of a body.


#: The most joint coordinates that are named.
MOST = 3


def direction_words(system: System, motion: MotionAtTime, ξ: Array) -> str:
    """Return a virtual displacement (6n,), turns in body axes, in words: "of A.angle, B.angle", or "'rod' shifts along
    -z"."""
    change = row_motion(system.coordinates, motion.carried()).G.times(ξ)
    scaled = np.abs(change) / np.where(system.coordinates.is_length, system.length, 1.0)
    scale = float(np.abs(ξ / tangent_lengths(system)).max(initial=0.0))
    if len(scaled) and scaled.max() > THRESHOLDS.named * scale:
        order = [int(index) for index in np.argsort(-scaled, kind="stable")[:MOST]]
        names = [system.names.coordinates[index] for index in order if scaled[index] > THRESHOLDS.named * scaled.max()]
        return f"of {', '.join(names)}"
    rows = ξ.reshape(-1, 6) / ([system.length] * 3 + [1.0] * 3)
    body = int(np.argmax(np.linalg.norm(rows, axis=1)))
    shift, turn = rows[body, :3], motion.pose.rotation[body] @ rows[body, 3:]
    name = system.names.carriers[body]
    if np.linalg.norm(shift) >= np.linalg.norm(turn):
        return f"in which '{name}' shifts along {direction(shift / np.linalg.norm(shift))}"
    return f"in which '{name}' turns about {direction(turn / np.linalg.norm(turn))}"


def lying_flat(system: System, motion: MotionAtTime) -> str | None:
    """Return the joint at which a wheel rolls that lies flat on its plane; None where all wheels stand."""
    x = attached(motion.pose, *slots_of(system.joints))
    for group in system.joints.groups:
        if kind_of(group.primitive) == "wheel_height":
            vectors = x[group.slots]
            upright = np.linalg.norm(cross(vectors[:, 1], vectors[:, 3]), axis=1)
            if upright.min() < THRESHOLDS.rounded:
                return system.names.joints[system.joints.owner[group.rows[int(np.argmin(upright)), 0]]]
    return None


# --- The search for an equilibrium ------------------------------------------------------------------------------------


class NoEquilibrium(MbprojError):
    """An error where nothing balances the forces. `balance` is the last pose, with its unbalanced forces."""

    exit_code = ExitCode.FAILED

    def __init__(self, message: str, balance: AnyBalance) -> None:
        self.balance = balance
        super().__init__(message)


@dataclass(frozen=True, eq=False)
class Solved:
    """A pose at which the forces balance, and the number of steps to it. `is_lowest`: whether the energy is known to be
    lowest there; where all modes are computed, they decide."""

    balance: AnyBalance
    steps: int
    is_lowest: bool = True


@final
@dataclass(frozen=True)
class Fall:
    """The length of a path, in lengths of the mechanism or rad, along which the unbalanced force has hardly changed."""

    left: float = 0.0
    length: float = 0.0

    def after(self, there: AnyBalance, size: float) -> Fall:
        """Return the path with one more step."""
        left = there.relative * there.largest
        if abs(left - self.left) <= THRESHOLDS.stalled * self.left:
            return Fall(self.left, self.length + size)
        return Fall(left)

    @property
    def is_endless(self) -> bool:
        return self.length >= THRESHOLDS.far_away


class ResidualEquations(Unbalanced, Protocol):
    """Interface of equations whose residual is minimised, by steps that begin with those of bodies."""

    @property
    def space(self) -> TangentSpace:
        """The tangent space of the bodies."""

    @property
    def residual(self) -> Array:
        """The residual."""

    @property
    def stiffness(self) -> tuple[Array, Array]:
        """The derivative by which the residual falls with a step, and the sum of its terms' absolute values."""

    def after(self: AnySteps, step: Array) -> AnySteps | None:
        """Return the equations after a step."""


AnySteps = TypeVar("AnySteps", bound=ResidualEquations)


def solve(problem: EquilibriumProblem, q: Array, expected: Array) -> Solved:
    """Return the equilibrium downhill from a closed pose. Raises NoEquilibrium, in words, where there is none."""
    here = start = problem.at(q, expected)
    radius, steps, fall = THRESHOLDS.long_way, 0, Fall()
    while steps < THRESHOLDS.most_passes and not is_balanced(here):
        steps += 1
        K, sizes = here.stiffness
        step, gain = downhill_of(here, K, sizes, radius)
        there = here.after(step)
        if there is None or not goes_down(here, there, gain):
            if is_nearly_balanced(here) and radius < THRESHOLDS.no_digits:
                break
            radius = 0.25 * min(radius, float(np.linalg.norm(step)))
            if radius < THRESHOLDS.no_digits:
                break
            continue
        fall = fall.after(there, float(np.linalg.norm(step)))
        if fall.is_endless or is_far(there, start):
            raise falls_for_ever(there)
        if np.linalg.norm(step) > 0.8 * radius:
            radius = min(2.0 * radius, THRESHOLDS.largest_radius)
        here = there
    if not is_nearly_balanced(here):
        here, more = by_residual(here)
        steps += more
    if not is_nearly_balanced(here):
        raise falls_for_ever(here)
    return Solved(here, steps)


def downhill_of(here: EquilibriumBalance, K: Array, sizes: Array, radius: float) -> tuple[Array, float]:
    """Return the step and the work that is expected of it."""

    return downhill(here.residual, K, sizes, radius, THRESHOLDS.dependent * here.largest)


def is_balanced(balance: Unbalanced) -> bool:
    """Return whether forces balance to round-off."""
    return balance.is_held or balance.relative <= THRESHOLDS.no_digits


def is_nearly_balanced(balance: Unbalanced) -> bool:
    return balance.is_held or balance.relative <= THRESHOLDS.dependent


def goes_down(here: AnyBalance, there: AnyBalance, gain: float) -> bool:
    """Return whether the forces do the expected work, by the trapezoidal rule. For a step whose work is round-off,
    return whether the residual has decreased."""
    moved = displacement_between(here.motion, there.motion)
    work = 0.5 * float((here.force + there.force) @ moved)
    lost = THRESHOLDS.no_digits * float(np.abs(here.force) @ (np.abs(moved) + here.lengths))
    if gain <= 10.0 * lost:
        return there.relative < here.relative
    return work >= THRESHOLDS.good_step * gain


def is_far(there: AnyBalance, start: AnyBalance) -> bool:
    """Return whether a body has moved by many lengths of the mechanism."""
    shift = there.motion.pose.position - start.motion.pose.position
    return bool(np.abs(shift).max() > THRESHOLDS.far_away * start.problem.reach)


def by_residual(here: AnySteps) -> tuple[AnySteps, int]:
    """Return the result of Levenberg's damped steps that reduce |r|, and their number.

    Damping grows where a step gains nothing. The steps end where damping does not help, as beside an edge, or where
    nothing can balance the rest."""

    damping, steps = 0.0, 0
    while steps < THRESHOLDS.most_passes and not is_balanced(here) and damping < 1.0 / THRESHOLDS.half_digits:
        steps += 1
        K, sizes = here.stiffness
        largest: float = np.maximum(sizes.max(initial=0.0), np.finfo(float).tiny)
        step = towards_balance(here.residual, K, damping * largest)
        size, there = _size(here), here.after(of_limited_length(step, here.space.freedom))
        if there is not None and _size(there) < size:
            here = there
        if _size(here) <= (1.0 - THRESHOLDS.stalled) * size:
            damping = 0.1 * damping if damping > THRESHOLDS.rounding else 0.0
        else:
            damping = max(10.0 * damping, THRESHOLDS.half_digits)
    return here, steps


def of_limited_length(step: Array, freedom: int) -> Array:
    """Return the step, shortened where bodies would move too far. The part of the bodies comes first in a step."""
    most = THRESHOLDS.largest_radius
    return step * (most / max(float(np.linalg.norm(step[:freedom])), most))


def _size(here: ResidualEquations) -> float:
    """Return the size of the residual."""
    return float(np.linalg.norm(here.residual))


def falls_for_ever(balance: AnyBalance) -> NoEquilibrium:
    """Return the error, in words, where nothing balances the forces here."""
    flat = lying_flat(balance.problem.system, balance.motion)
    if flat is not None:
        return NoEquilibrium(
            f"there is no equilibrium: from this start the wheel of joint '{flat}' falls over and lies flat on its "
            "plane, where it no longer rolls on its rim; start it upright, its 'axis' along the plane, or hold its "
            "lean with a spring or a joint; for a motion that goes on alike, ask 'mbproj modes SCENE --at start'",
            balance,
        )
    lengths, unbalanced = balance.lengths, balance.unbalanced
    left = unbalanced / lengths**2
    size = float(np.linalg.norm(unbalanced / lengths)) / balance.problem.system.length
    words = direction_words(balance.problem.system, balance.motion, unbalanced)
    rows = left.reshape(-1, 6)
    body = int(np.argmax(np.linalg.norm(rows / lengths.reshape(-1, 6) ** -1, axis=1)))
    force, torque = (float(np.linalg.norm(part)) for part in (rows[body, :3], rows[body, 3:]))
    stops = balance.problem.system.stops
    rigid = stops is not None and bool(stops.is_rigid.any())
    return NoEquilibrium(
        f"there is no equilibrium: nothing balances {force:.4g} N and {torque:.4g} N m on "
        f"'{balance.problem.system.names.carriers[body]}' along the motion {words} ({size:.3g} N in all); "
        "hold that motion with a joint, a spring or a motion, or balance the force"
        + ("; rigid stops hold nothing here, compliant ones with a 'stiffness' do" if rigid else ""),
        balance,
    )


def downhill(residual: Array, K: Array, sizes: Array, radius: float, floor: float) -> tuple[Array, float]:
    """Return the step within the radius with the largest work of the model rᵀη - ½ ηᵀKη, and that work. Directions
    without stiffness and with a force of at most `floor` do not move."""
    κ, V = np.linalg.eigh(0.5 * (K + K.T))
    r = V.T @ residual
    size = np.einsum("ik,ij,jk->k", np.abs(V), sizes, np.abs(V), optimize=True)
    neutral = (np.abs(κ) <= THRESHOLDS.rounding * size) & (np.abs(r) <= floor)
    κ, r, V = κ[~neutral], r[~neutral], V[:, ~neutral]
    if not len(κ):
        return np.zeros_like(residual), 0.0
    shift = _shift(κ, r, radius)
    parts = r / (κ + shift)
    return V @ parts, float(r @ parts - 0.5 * parts @ (κ * parts))


def _shift(κ: Array, r: Array, radius: float) -> float:
    """Return the smallest μ ≥ 0 with all κ + μ > 0 and |r / (κ + μ)| ≤ radius."""
    least = max(0.0, -float(κ.min()))
    grain = np.finfo(float).eps * max(float(np.abs(κ).max()), np.finfo(float).tiny)

    def length(shift: float) -> float:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            return float(np.linalg.norm(np.where(r == 0.0, 0.0, r / (κ + shift))))

    low = least + grain if κ.min() <= grain else 0.0
    if length(low) <= radius:
        return low
    high = least + float(np.linalg.norm(r)) / radius + grain
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if length(middle) > radius else (low, middle)
    return high


def towards_balance(residual: Array, K: Array, damping: float) -> Array:
    """Return the step that minimises |r - Kη|² + damping² |η|² (Levenberg)."""
    f = len(residual)
    stacked = np.concatenate([K, damping * np.eye(f)])
    right = np.concatenate([residual, np.zeros(f)])
    return np.asarray(np.linalg.lstsq(stacked, right, rcond=None)[0], dtype=float)
