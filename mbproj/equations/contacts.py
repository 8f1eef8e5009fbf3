"""The pose nearest to one that is beyond stops at which all stops are respected, if there is one."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers, total
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, SimulationError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, coordinate_values, nearest, scaled_residual, scaled_rows
from mbproj.equations.assembly.gauss_newton import gauss_newton, set_rows
from mbproj.equations.blocks import Rows, stacked
from mbproj.equations.constraints import tangent_jacobian
from mbproj.equations.gaps import gaps, stop_sizes
from mbproj.equations.kinematics import Pose, Twist, pose_of, twist_of
from mbproj.equations.motions import drive_at
from mbproj.equations.of_motion import tangent_mass_matrix
from mbproj.equations.tangent_space import tangent_space
from mbproj.equations.turning import near, turns_of
from mbproj.functions.kinks import look_times
from mbproj.functions.series import run, time_series
from mbproj.model.channels import Motions
from mbproj.model.contacts import Stops
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import Conditions, System

# --- The forces and energies of compliant stops -----------------------------------------------------------------------


def pressing(stops: Stops, by: Array, gap: Numbers, rate: Numbers) -> Numbers:
    """Return the forces of compliant stops at these gaps (..., S) and rates, in N or N m; 0 for rigid ones. `by` (S,)
    are their coefficients of damping, `Stops.pushes_by`."""
    δ = np.maximum(-gap, 0.0)
    elastic, damped = _stiffness(stops) * δ**stops.exponent, np.isnan(stops.restitution)
    speed = np.sqrt(rate**2 + by * δ ** (stops.exponent + 1.0) + np.finfo(float).tiny)
    part = np.where(damped, by, stops.resistance / speed) * rate
    return np.asarray(np.where(δ > 0.0, elastic * np.maximum(1.0 - part, 0.0), 0.0))


def stored_energy(stops: Stops, gap: Numbers) -> Numbers:
    """Return the energy stored in compliant stops, Σ k δᵖ⁺¹ / (p + 1), shape (...), in J."""
    δ, p = np.maximum(-gap, 0.0), stops.exponent
    return total(_stiffness(stops) * δ ** (p + 1.0) / (p + 1.0))


def _stiffness(stops: Stops) -> Array:
    """Return k of compliant stops, 0 of rigid ones, (S,)."""
    return np.where(stops.is_rigid, 0.0, stops.stiffness)


# --- The nearest pose at which all stops are respected ----------------------------------------------------------------


NO_CONDITIONS = Conditions(np.zeros(0, dtype=np.intp), np.zeros(0))


def nearest_inside(system: System, state: State) -> tuple[Array, Array]:
    """Return a pose q at which the joints close and no stop is passed, searched from the pose of a state, and its gaps
    (S,). A gap below 0 belongs to a stop that could not be respected."""
    system = system.at_positions
    stops, drive, none = system.stops, drive_at(system, state.t), NO_CONDITIONS
    assert stops is not None
    sizes = stop_sizes(system)
    start = coordinate_values(system, pose_of(state.q)) + 2.0 * np.pi * state.turns

    def gap(pose: Pose) -> Array:
        return np.asarray(gaps(stops, pose, _turns(system, pose, start)))

    def residual(pose: Pose) -> Array:
        passed = np.minimum(gap(pose), 0.0) / sizes
        return np.concatenate([scaled_residual(system, pose, none, drive), passed])

    def rows(pose: Pose) -> Rows:
        factor = np.where(gap(pose) < 0.0, stops.side / sizes, 0.0)
        passed = set_rows(system, stops.coordinates, pose).scaled(factor)
        return stacked(system.bodies, [scaled_rows(system, pose, none), passed])

    between, _ = gauss_newton(system, state.q, residual, rows, THRESHOLDS.assembled)
    q, _ = nearest(system, between, none, drive, THRESHOLDS.assembled)  # joints have priority
    return q, gap(pose_of(q))


def _turns(system: System, pose: Pose, start: Array) -> Integers:
    """Return whole turns (nc,) of the joints' coordinates at a pose near one where the coordinates were `start`."""
    angles = coordinate_values(system, pose)
    return turns_of(system, near(system, angles, start), angles)


# --- Motions beyond stops ---------------------------------------------------------------------------------------------
# Refuses motions that drive a coordinate beyond its rigid stop, which is known before the run.


HINT = "end the motion inside, widen the range, or let the stop give way with 'stiffness'"
#: The number of halvings of the interval in which a motion passes a stop.
HALVINGS = 60


def refuse_driven_beyond(system: System, start: float, end: float) -> None:
    """Raise InputError where a motion drives its coordinate beyond a rigid stop before `end`."""
    if system.stops is None:
        return
    problems = _first_passages(system, system.motions, system.stops, start, end)
    if problems:
        raise InputError(list(problems))


@lru_cache(maxsize=256)
def _first_passages(system: System, motions: Motions, stops: Stops, start: float, end: float) -> tuple[Problem, ...]:
    """Return the first passage of each stop. The result is cached: studies run one mechanism many times."""
    return tuple(
        problem
        for stop in np.flatnonzero(stops.is_rigid)
        for number in np.flatnonzero(motions.joint_coordinate == stops.joint_coordinate[stop])
        for problem in _passage(system, motions, stops, int(stop), int(number), start, end)
    )


def _passage(
    system: System, motions: Motions, stops: Stops, stop: int, number: int, start: float, end: float
) -> Iterator[Problem]:
    unit = system.names.stop_units[stop]
    size = system.length if unit == "m" else 1.0
    slack = THRESHOLDS.same_written * size

    def gap(t: Array) -> Array:
        value = motions.start[number] + run(motions.programs, number, [time_series(t)])[0]
        return np.asarray(stops.side[stop] * (value - stops.bound[stop]))

    times = look_times(motions.programs, number, start, end)
    gaps = gap(times)
    beyond = np.flatnonzero(gaps < -slack)
    if not len(beyond):
        return
    first, last = times[max(int(beyond[0]) - 1, 0)], times[beyond[0]]
    for _ in range(HALVINGS):
        middle = 0.5 * (first + last)
        first, last = (first, middle) if gap(np.array([middle]))[0] < -slack else (middle, last)
    coordinate = system.names.coordinates[int(stops.joint_coordinate[stop])]
    message = (
        f"motion '{system.names.motions[number]}' drives {coordinate} beyond this rigid stop from t = {last:.6g} s on, "
        f"by up to {-gaps.min():.6g} {unit}"
    )
    yield Problem(message, stops.places[stop], HINT)


# --- Free motions and rows of gaps ------------------------------------------------------------------------------------
# The free motions that the joints leave at a pose, in coordinates x, and the rows N of the stops' gaps by x.
# In x the kinetic energy is ½|x|²: u = u₀ + T R⁻¹ x, with G T = 0 and TᵀM T = RᵀR.


@dataclass(frozen=True, eq=False)
class Freedom:
    """The freedom of a mechanism at a state: `basis` T R⁻¹ (6n, f), and the pose and twist it belongs to."""

    system: System
    state: State
    pose: Pose
    twist: Twist
    M: Array
    G: Array
    basis: Array
    smallest: Array  # G⁺ (6n, m)

    @classmethod
    def at(cls, system: System, state: State) -> Freedom:
        """Return the freedom at a state. Raises SimulationError where a free motion has no inertia."""
        pose = pose_of(state.q)
        M, G = tangent_mass_matrix(system, pose), _in_bodies(system.rows, pose)
        space = tangent_space(system, G)
        try:
            R = np.linalg.cholesky(space.N.T @ M @ space.N).T
        except np.linalg.LinAlgError as error:
            cause = "a stop meets a motion without inertia: no impulse is finite there"
            raise SimulationError(state.t, cause, hint="give its bodies mass and inertia") from error
        basis = np.linalg.solve(R.T, space.N.T).T
        return cls(system, state, pose, twist_of(pose, state.v), M, G, basis, space.pseudoinverse)

    def rows(self, stops: Stops) -> Array:
        """Return N (S, f): g' = N x for the gaps, apart from the part that motions drive."""
        return np.asarray(stops.side[:, None] * _in_bodies(stops.coordinates, self.pose) @ self.basis)

    def multipliers_of(self, gradients: Array) -> Array:
        """Return the smallest multipliers λ (k, m) caused by a unit force along each coordinate, with `gradients` (k,
        6n)."""
        left = gradients - (gradients @ self.basis) @ (self.M @ self.basis).T
        return np.asarray(left @ self.smallest)

    def gradients_of(self, along: PrimitiveSet) -> Array:
        """Return ∂s/∂(δr, δθ) of coordinates, (k, 6n)."""
        return _in_bodies(along, self.pose)


def _in_bodies(bound: PrimitiveSet, pose: Pose) -> Array:
    """Return the derivatives of a set's values by (δr, δθ), (m, 6n)."""
    return np.ascontiguousarray(tangent_jacobian(bound, pose)[:, :-1, :6]).reshape(
        bound.size, 6 * (len(pose.position) - 1)
    )
