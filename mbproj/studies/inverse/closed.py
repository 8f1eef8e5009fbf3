"""A mechanism that follows a given motion of joint coordinates and markers, with its joints closed at each time.

The joints' rows hold exactly, C(q) = 0. The given coordinates hold in the least-squares sense, because measured
coordinates of a closed loop contradict each other a little. With a null space matrix N of G, and the rows K of the
given coordinates,

    δξ = -G⁺C + N z,   |K δξ - (g(t) - s(q))|² least;   u = N z,  |K u - g'|² least;   and u' likewise.

Where more coordinates than freedoms are given they are averaged; fewer are refused.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

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


@dataclass(frozen=True, eq=False)
class GivenRows:
    """The coordinates whose motion is given: joint coordinates by number, then components of markers (marker, axis).
    `scale` (c,) is the mechanism's length for lengths, 1 for angles. `order` is the place of each in the file."""

    coordinates: tuple[int, ...]
    components: tuple[tuple[int, int], ...]
    scale: Array
    order: tuple[int, ...]


def given_rows(system: System, names: Sequence[str]) -> GivenRows:
    """The rows of these names, all of which the system has."""
    own = system.names
    coordinates = [k for k, name in enumerate(names) if name in own.coordinates]
    others = [k for k, name in enumerate(names) if name not in own.coordinates]
    at = [own.coordinates.index(names[k]) for k in coordinates]
    components = [(own.markers.index(names[k][:-2]), "xyz".index(names[k][-1])) for k in others]
    lengths = np.array([own.coordinate_units[k] == "m" for k in at] + [True] * len(others), dtype=bool)
    scale = np.where(lengths, system.length, 1.0)
    return GivenRows(tuple(at), tuple(components), scale, (*coordinates, *others))


@dataclass(frozen=True, eq=False)
class FollowedMotion:
    """The motion at each time, and the deviation of the mechanism from the given coordinates, (T, c), in their
    order."""

    motions: list[MotionAtTime]
    off: Array


def follow(
    system: System, start: State, names: Sequence[str], splines: Sequence[Smoothed], times: Array
) -> FollowedMotion:
    """Follow the given motion with a system without motions, from the pose of `start` on.

    Raises InputError where the given motion leaves a freedom open, SimulationError where the joints do not close.
    """
    rows = given_rows(system, names)
    series = np.stack([spline.at(times) for spline in splines], axis=-1)[:, :, list(rows.order)]
    q, reached = start.q, _values(system, rows, pose_of(start.q))
    expected = coordinate_values(system, pose_of(start.q)) + 2.0 * np.pi * start.turns
    angles = is_angle(system)[list(rows.coordinates)].astype(bool)
    reached[: len(angles)] = expected[list(rows.coordinates)]
    # The scene's pose and the first sample may differ by whole turns.
    away = np.round((series[0, 0, : len(angles)] - reached[: len(angles)]) / (2.0 * np.pi)) * angles
    reached[: len(angles)] += 2.0 * np.pi * away
    expected = expected.copy()
    expected[list(rows.coordinates)] += 2.0 * np.pi * away
    motions: list[MotionAtTime] = []
    off = []
    for t, target, rate, change in zip(times, *series, strict=True):
        if motions:
            q = moved(q, _displacement_until(motions[-1], float(t)))
        parts = max(1, int(np.ceil(np.abs((target - reached) / rows.scale).max() / LONGEST)))
        for part in range(1, parts + 1):
            q = _closed_pose(system.at_positions, rows, q, reached + (target - reached) * part / parts, float(t))
            value = coordinate_values(system, pose_of(q))
            expected = value + 2.0 * np.pi * np.round((expected - value) / (2.0 * np.pi)) * is_angle(system)
        motion, left = _with_rates(
            system, rows, MotionAtTime(float(t), q, *_still(q), expected, start.x), target, rate, change
        )
        motions.append(motion)
        off.append(left)
        reached = target
    back = np.argsort(rows.order)
    return FollowedMotion(motions, np.array(off)[:, back])


def _displacement_until(motion: MotionAtTime, t: float) -> Array:
    """The displacement of the bodies until time t, to second order, (6n,)."""
    h = t - motion.t
    return h * motion.u + 0.5 * h**2 * motion.change


def _still(q: Array) -> tuple[Array, Array]:
    none = np.zeros(len(q) // 7 * 6)
    return none, none


def _values(system: System, rows: GivenRows, pose: Pose) -> Array:
    """The values of the given coordinates at a pose, (c,), without whole turns."""
    places = pose.position[system.marker_body] + _arms(system, pose)
    own = coordinate_values(system, pose)[list(rows.coordinates)]
    return np.concatenate([own, [places[marker, axis] for marker, axis in rows.components]])


def _arms(system: System, pose: Pose) -> Array:
    """The vector A s of each marker, from its body's centre, global axes, (k, 3)."""
    arms: Array = (pose.rotation[system.marker_body] @ system.marker_local[..., None])[..., 0]
    return arms


def _markers(system: System, rows: GivenRows, motion: MotionAtTime) -> tuple[Rows, Array]:
    """The rows of the markers' components in (δr, δθ in body axes), and the part ω × (ω × s) of their accelerations."""
    pose = motion.pose
    marker, axis = np.array(rows.components, dtype=np.intp).reshape(-1, 2).T
    body, local = system.marker_body[marker], system.marker_local[marker]
    ω = np.concatenate([motion.u.reshape(-1, 6)[:, 3:], np.zeros((1, 3))])[body]
    each, A = np.arange(len(axis)), pose.rotation[body]
    entries = np.concatenate([np.eye(3)[axis], -(A @ tilde(local))[each, axis]], axis=1)
    bias = (A @ np.cross(ω, np.cross(ω, local))[..., None])[each, axis, 0]
    return Rows.of(len(axis), system.bodies, each, body, entries), bias


def _closed_pose(system: System, rows: GivenRows, q: Array, target: Array, t: float) -> Array:
    """Close the joints near q; of all closed poses take the one nearest to the `target` of the given coordinates."""
    for _ in range(ITERATIONS):
        motion = MotionAtTime(t, q, *_still(q), np.zeros(system.coordinates.size))
        space, K = _linear(system, rows, motion)
        C = constraint(system, motion.pose)[system.bodies :]
        close = -(space.pseudoinverse @ C)
        δ = close + space.N @ _least_squares(space, K, rows, _deviation(system, rows, motion, target) - K @ close, t)
        q = moved(q, δ)
        size = np.abs(δ / space.lengths).max(initial=0.0)
        if size <= CLOSED:
            break
    left = np.abs(constraint(system, pose_of(q)) / system.row_scale).max(initial=0.0)
    if not left <= OPEN:
        cause = "the joints do not close along the given motion"
        raise SimulationError(t, cause, hint="it may be out of reach: compare it with a run of the scene")
    return q


def _deviation(system: System, rows: GivenRows, motion: MotionAtTime, target: Array) -> Array:
    """The deviation of `target` from the mechanism's coordinates, (c,); angles within half a turn."""
    off = target - _values(system, rows, motion.pose)
    angles = np.zeros(len(off), dtype=bool)
    angles[: len(rows.coordinates)] = is_angle(system)[list(rows.coordinates)].astype(bool)
    return np.where(angles, np.arctan2(np.sin(off), np.cos(off)), off)


def _linear(system: System, rows: GivenRows, motion: MotionAtTime) -> tuple[TangentSpace, Array]:
    """The tangent space at a pose, and the rows K (c, 6n) of the given coordinates."""
    pose, index = motion.pose, np.array(rows.coordinates, dtype=np.intp)
    given = [rows_at(system.coordinates, pose).chosen(index), _markers(system, rows, motion)[0]]
    return tangent_space(system, rows_at(system.rows, pose).dense()), stacked(system.bodies, given).dense()


def _bias_accelerations(system: System, rows: GivenRows, motion: MotionAtTime) -> tuple[Array, Array]:
    """The accelerations G'u (m,) and K'u (c,) of the rows where u' is zero."""
    pose = motion.pose
    twist, change = motion.twist(pose), motion.change_of(pose)
    own, others = (
        np.asarray(set_velocity(bound, pose, change) + set_bias(bound, pose, twist))
        for bound in (system.rows, system.coordinates)
    )
    return own, np.concatenate([others[list(rows.coordinates)], _markers(system, rows, motion)[1]])


def _least_squares(space: TangentSpace, K: Array, rows: GivenRows, wanted: Array, t: float) -> Array:
    """The z (f,) that minimises |K N z - wanted|. Raises InputError where the rows leave a freedom open."""
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
    system: System, rows: GivenRows, motion: MotionAtTime, target: Array, rate: Array, change: Array
) -> tuple[MotionAtTime, Array]:
    """Return the motion with its velocities and accelerations, and the deviation of the mechanism from the given
    coordinates."""
    space, K = _linear(system, rows, motion)
    u = space.N @ _least_squares(space, K, rows, rate, motion.t)
    own = MotionAtTime(motion.t, motion.q, u, motion.change, motion.expected, motion.x)
    G_dot_u, K_dot_u = _bias_accelerations(system, rows, own)
    held = -(space.pseudoinverse @ G_dot_u)
    u_dot = held + space.N @ _least_squares(space, K, rows, change - K_dot_u - K @ held, motion.t)
    left = -_deviation(system, rows, motion, target)
    return MotionAtTime(motion.t, motion.q, u, u_dot, motion.expected, motion.x), left
