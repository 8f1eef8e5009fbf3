"""A mechanism that follows a given motion of joint coordinates and markers, with its joints closed at each time.

In: the values g(t) (c,) of some coordinates with two derivatives, in m and rad. Out: the poses q (7n,), velocities u
and accelerations u' (6n,) of all n bodies at these times, and by how much the coordinates s(q) miss g. Each time is
closed by itself, so that no error grows along the motion.

The joints' rows hold exactly, C(q) = 0. The given coordinates hold in the least-squares sense, because measured
coordinates of a closed loop contradict each other a little. Let ξ be a small motion (δr, δθ) of all bodies, G = C_ξ and
K = s_ξ. With a null space matrix N of G,

    ξ = -G⁺C + N z,  |K ξ - (g(t) - s(q))|² least;   u = N z,  |K u - g'|² least;   u' = -G⁺G'u + N z,  likewise.

Where more coordinates than freedoms are given they are averaged; fewer are refused.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, SimulationError
from mbproj.equations.assembly.assemble import State, coordinate_values, is_angle
from mbproj.equations.blocks import Rows, stacked
from mbproj.equations.constraints import constraint, set_bias, set_velocity
from mbproj.equations.derivatives import MotionAtTime, rows_at, tilde
from mbproj.equations.kinematics import Pose, pose_of
from mbproj.equations.tangent_space import TangentSpace, moved, tangent_space
from mbproj.model.system import System
from mbproj.studies.inverse.given_motion import Smoothed

#: A step between two poses is divided until the given coordinates change by at most this in each part, in rad and
#: lengths.
LONGEST = 0.2
#: The most Newton iterations, and the size of a correction at which they end, in rad and lengths of the mechanism.
ITERATIONS, CLOSED = 40, 1e-13
#: A larger violation than this, in lengths of the mechanism or rad, means that the joints are open.
OPEN = 1e-10
#: The given motion does not determine a freedom whose singular value of K N is below this part of the largest.
UNDETERMINED = 1e-8
TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class GivenRows:
    """The c coordinates whose motion is given: first joint coordinates by number, then components of markers (marker,
    axis). `order`: the place of each in the file. `is_angle` (c,), and `scale` (c,), the mechanism's length in m for
    lengths, 1 for angles."""

    coordinates: tuple[int, ...]
    components: tuple[tuple[int, int], ...]
    order: tuple[int, ...]
    is_angle: npt.NDArray[np.bool_]
    scale: Array


@dataclass(frozen=True, eq=False)
class FollowedMotion:
    """The motion at each of T times, and the deviation s(q) - g of the mechanism from the given coordinates, (T, c), in
    the order of the file."""

    motions: list[MotionAtTime]
    off: Array


def follow(
    system: System, start: State, names: Sequence[str], splines: Sequence[Smoothed], times: Array
) -> FollowedMotion:
    """Follow the given motion with a system without motions, from the pose of `start` on. `splines` are those of the
    coordinates `names`, all of which the system has, at `times` (T,) in s.

    Raises InputError where the given motion leaves a freedom open, SimulationError where the joints do not close.
    """
    rows = _given_rows(system, names)
    series = np.stack([spline.at(times) for spline in splines], axis=-1)[:, :, list(rows.order)]
    q = start.q
    reached, expected = _start_values(system, rows, start, series[0, 0])
    motions: list[MotionAtTime] = []
    deviations = []
    for t, target, rate, acceleration in zip(times, *series, strict=True):
        if motions:
            q = moved(q, _displacement_until(motions[-1], float(t)))
        parts = max(1, int(np.ceil(np.abs((target - reached) / rows.scale).max() / LONGEST)))
        for part in range(1, parts + 1):
            q = _closed_pose(system.at_positions, rows, q, reached + (target - reached) * part / parts, float(t))
            value = coordinate_values(system, pose_of(q))
            expected = value + TURN * np.round((expected - value) / TURN) * is_angle(system)
        at_pose = MotionAtTime(float(t), q, *_at_rest(q), expected, start.x)
        motions.append(_with_rates(system, rows, at_pose, rate, acceleration))
        deviations.append(-_deviation(system, rows, at_pose, target))
        reached = target
    return FollowedMotion(motions, np.array(deviations)[:, np.argsort(rows.order)])


def _given_rows(system: System, names: Sequence[str]) -> GivenRows:
    """The rows of these names: a joint coordinate, or a marker's component such as "P.x"."""
    known = system.names
    of_joints = [k for k, name in enumerate(names) if name in known.coordinates]
    of_markers = [k for k, name in enumerate(names) if name not in known.coordinates]
    coordinates = [known.coordinates.index(names[k]) for k in of_joints]
    components = [(known.markers.index(names[k][:-2]), "xyz".index(names[k][-1])) for k in of_markers]
    lengths = np.array([known.coordinate_units[k] == "m" for k in coordinates] + [True] * len(of_markers), dtype=bool)
    scale = np.where(lengths, system.length, 1.0)
    return GivenRows(tuple(coordinates), tuple(components), (*of_joints, *of_markers), ~lengths, scale)


def _start_values(system: System, rows: GivenRows, start: State, first: Array) -> tuple[Array, Array]:
    """The values at the pose of `start` of the given coordinates (c,) and of all joint coordinates. The scene's pose
    and the `first` sample (c,) may differ by whole turns: given angles start within half a turn of it."""
    expected = coordinate_values(system, pose_of(start.q)) + TURN * start.turns
    joints = list(rows.coordinates)
    reached = _values(system, rows, pose_of(start.q))
    reached[: len(joints)] = expected[joints]
    whole_turns = TURN * (np.round((first - reached) / TURN) * rows.is_angle)
    expected[joints] += whole_turns[: len(joints)]
    return reached + whole_turns, expected


def _displacement_until(motion: MotionAtTime, t: float) -> Array:
    """The displacement of the bodies until time t, to second order, (6n,)."""
    h = t - motion.t
    return h * motion.u + 0.5 * h**2 * motion.change


def _at_rest(q: Array) -> tuple[Array, Array]:
    """Velocities and accelerations (6n,) that are 0."""
    zero = np.zeros(len(q) // 7 * 6)
    return zero, zero


def _values(system: System, rows: GivenRows, pose: Pose) -> Array:
    """The values of the given coordinates at a pose, (c,), without whole turns."""
    places = pose.position[system.marker_body] + _arms(system, pose)
    of_joints = coordinate_values(system, pose)[list(rows.coordinates)]
    return np.concatenate([of_joints, [places[marker, axis] for marker, axis in rows.components]])


def _arms(system: System, pose: Pose) -> Array:
    """The vector A s of each marker, from its body's centre, global axes, (k, 3)."""
    arms: Array = (pose.rotation[system.marker_body] @ system.marker_local[..., None])[..., 0]
    return arms


def _markers(system: System, rows: GivenRows, motion: MotionAtTime) -> tuple[Rows, Array]:
    """The k rows (k, 6n) of the markers' components in (δr, δθ in body axes), and the part ω × (ω × s) of their
    accelerations, (k,)."""
    pose = motion.pose
    marker, axis = np.array(rows.components, dtype=np.intp).reshape(-1, 2).T
    body, local = system.marker_body[marker], system.marker_local[marker]
    ω = np.concatenate([motion.u.reshape(-1, 6)[:, 3:], np.zeros((1, 3))])[body]
    row, A = np.arange(len(axis)), pose.rotation[body]
    entries = np.concatenate([np.eye(3)[axis], -(A @ tilde(local))[row, axis]], axis=1)
    bias = (A @ np.cross(ω, np.cross(ω, local))[..., None])[row, axis, 0]
    return Rows.of(len(axis), system.bodies, row, body, entries), bias


def _closed_pose(system: System, rows: GivenRows, q: Array, target: Array, t: float) -> Array:
    """Close the joints near q by Newton's method (Gauss and Newton's along N); of all closed poses take the one nearest
    to the `target` (c,) of the given coordinates. Raises SimulationError where the joints stay open."""
    for _ in range(ITERATIONS):
        motion = MotionAtTime(t, q, *_at_rest(q), np.zeros(system.coordinates.size))
        space, K = _linear(system, rows, motion)
        C = constraint(system, motion.pose)[system.bodies :]
        closing = -(space.pseudoinverse @ C)
        wanted = _deviation(system, rows, motion, target) - K @ closing
        ξ = closing + space.N @ _least_squares(space, K, rows, wanted, t)
        q = moved(q, ξ)
        size = np.abs(ξ / space.lengths).max(initial=0.0)
        if size <= CLOSED:
            break
    violation = np.abs(constraint(system, pose_of(q)) / system.row_scale).max(initial=0.0)
    if not violation <= OPEN:
        cause = "the joints do not close along the given motion"
        raise SimulationError(t, cause, hint="it may be out of reach: compare it with a run of the scene")
    return q


def _deviation(system: System, rows: GivenRows, motion: MotionAtTime, target: Array) -> Array:
    """The deviation target - s(q), (c,); angles within half a turn."""
    off = target - _values(system, rows, motion.pose)
    return np.where(rows.is_angle, np.arctan2(np.sin(off), np.cos(off)), off)


def _linear(system: System, rows: GivenRows, motion: MotionAtTime) -> tuple[TangentSpace, Array]:
    """The tangent space at a pose, and the rows K (c, 6n) of the given coordinates."""
    pose, index = motion.pose, np.array(rows.coordinates, dtype=np.intp)
    K = [rows_at(system.coordinates, pose).chosen(index), _markers(system, rows, motion)[0]]
    return tangent_space(system, rows_at(system.rows, pose).dense()), stacked(system.bodies, K).dense()


def _bias_accelerations(system: System, rows: GivenRows, motion: MotionAtTime) -> tuple[Array, Array]:
    """The accelerations G'u (m,) and K'u (c,) of the rows where u' is zero."""
    pose = motion.pose
    twist, change = motion.twist(pose), motion.change_of(pose)
    of_rows, of_coordinates = (
        np.asarray(set_velocity(bound, pose, change) + set_bias(bound, pose, twist))
        for bound in (system.rows, system.coordinates)
    )
    return of_rows, np.concatenate([of_coordinates[list(rows.coordinates)], _markers(system, rows, motion)[1]])


def _least_squares(space: TangentSpace, K: Array, rows: GivenRows, wanted: Array, t: float) -> Array:
    """The z (f,) that minimises |K N z - wanted|, with lengths in units of the mechanism's. Raises InputError where the
    rows leave a freedom open."""
    A = (K @ space.N) / rows.scale[:, None]
    U, σ, V = np.linalg.svd(A, full_matrices=False)
    rank = int(np.count_nonzero(σ > UNDETERMINED * σ.max(initial=0.0)))
    if rank < space.freedom:
        raise _undetermined(space.freedom, rank, t)
    return np.asarray(V.T @ ((U.T @ (wanted / rows.scale)) / σ))


def _undetermined(freedom: int, determined: int, t: float) -> InputError:
    missing = freedom - determined
    message = (
        f"at t = {t:.6g} s the given motion determines {determined} of {freedom} degrees of freedom, and "
        f"{missing} {'is' if missing == 1 else 'are'} left open"
    )
    return InputError(Problem(message, hint="give more joint coordinates or markers, or others near this pose"))


def _with_rates(
    system: System, rows: GivenRows, at_pose: MotionAtTime, rate: Array, acceleration: Array
) -> MotionAtTime:
    """The motion at a pose with its velocities and accelerations, from those of the given coordinates (c,)."""
    t, q, rest = at_pose.t, at_pose.q, (at_pose.expected, at_pose.x)
    space, K = _linear(system, rows, at_pose)
    u = space.N @ _least_squares(space, K, rows, rate, t)
    G_dot_u, K_dot_u = _bias_accelerations(system, rows, MotionAtTime(t, q, u, at_pose.change, *rest))
    along_joints = -(space.pseudoinverse @ G_dot_u)
    wanted = acceleration - K_dot_u - K @ along_joints
    return MotionAtTime(t, q, u, along_joints + space.N @ _least_squares(space, K, rows, wanted, t), *rest)
