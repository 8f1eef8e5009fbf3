"""All assemblies of a mechanism: the poses that meet its joints, its motions at a time, and coordinates that are held.

The search starts from many random poses: each body anywhere within its reach (`reach`), which every assembly is, and
turned at will. So each assembly draws a share of the starts. One with the share p is missed by n starts with the
probability (1 - p)^n. At most 1/p assemblies have such a share: that any of these was missed is less probable than
(1 - p)^n / p. The search may end after each batch of starts. So that the bound holds whenever it does, batch k has the
part 1 / (k (k + 1)) of the probability, as these add up to 1.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.base.arrays import Array, Flags, Integers, cross, may_overflow
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, coordinate_values, nearest, scaled_residual
from mbproj.equations.constraints import EPSILON
from mbproj.equations.kinematics import Pose, attached, pose_of
from mbproj.equations.motions import Drive, drive_at
from mbproj.joints.primitives.basic import Primitive
from mbproj.joints.primitives.table import name_of
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import planar_reduction
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import Conditions, System

#: The seed of the random starts, and the number of starts that are closed at once.
SEED, AT_ONCE = 44, 200


@dataclass(frozen=True, eq=False)
class Assembly:
    """A pose that closes: coordinates q (7n,), joint coordinates (nc,) in m and rad, and the number of starts that led
    here. `distance`: the distance from a singular pose, which is the smallest singular value of C_q in lengths of the
    mechanism and rad."""

    q: Array
    coordinates: Array
    hits: int
    distance: float

    @property
    def is_singular(self) -> bool:
        """Whether assemblies meet at this pose."""
        return self.distance < THRESHOLDS.dependent


@dataclass(frozen=True)
class Assemblies:
    """All assemblies that were found, the one at the initial pose first; the number of `starts`, and of those that
    `closed`. `looks`: how often the search might have ended, 0 where the number of starts was given."""

    assemblies: tuple[Assembly, ...]
    starts: int
    closed: int
    looks: int = 0

    @property
    def share(self) -> float:
        """The share p of the starts: that an assembly was missed which draws more has at most the probability
        `missed` of the thresholds."""
        most = np.log(THRESHOLDS.missed) - np.log(max(self.looks * (self.looks + 1), 1))
        low, high = 0.0, 1.0
        while high - low > THRESHOLDS.rounded * high:
            p = 0.5 * (low + high)
            low, high = (low, p) if self.starts * np.log1p(-p) - np.log(p) <= most else (p, high)
        return high

    @property
    def is_unsure(self) -> bool:
        """Whether an assembly was found that draws no more than the `share`, or so seldom that others like it may be
        missed."""
        rarest = min((each.hits for each in self.assemblies), default=0)
        return rarest < max(THRESHOLDS.found_often, self.share * self.starts)


def freedom_left(system: System, state: State, held: Conditions) -> int:
    """Return the number of degrees of freedom at a state while coordinates are `held`."""
    values = np.linalg.svd(scaled_rows_of(system, pose_of(state.q[None]), held)[0], compute_uv=False)
    return 6 * system.bodies - int(np.count_nonzero(values > THRESHOLDS.dependent))


def assemblies(system: System, state: State, held: Conditions, starts: int | None = None) -> Assemblies:
    """Return the assemblies with motions at the time of `state` and `held` coordinates, which leave no freedom.

    Without a number of `starts` the search ends when each assembly was found often, and the second half of the starts
    found no new one."""
    rng, drive = np.random.default_rng(SEED), drive_at(system, state.t)
    draw = _Draw(system, state, reach_of(system, state.q, held, drive))
    poses, last_new, done, closed = [_polished(system, state.q, held, drive)], 0, 0, 0
    hits = [0]
    while done < (starts or THRESHOLDS.most_starts):
        count = min(AT_ONCE, (starts or THRESHOLDS.most_starts) - done)
        q, good = close_all(system, draw.starts(rng, count), held, drive, draw.longest)
        done += count
        for each in q[good & _is_not_turned_over(system, q)]:
            closed += 1
            at = _number(system, each, poses)
            if at is None:
                polished = _polished(system, each, held, drive)
                at = _number(system, polished, poses)
                if at is None:
                    at, last_new = len(poses), done
                    poses.append(polished)
                    hits.append(0)
            hits[at] += 1
        often = min(hits) >= THRESHOLDS.found_often
        if starts is None and often and done >= 2 * max(last_new, AT_ONCE):
            break
    order = [0, *sorted(range(1, len(poses)), key=lambda k: _key(system, poses[k]))]
    ordered = tuple(_assembly(system, poses[k], held, hits[k]) for k in order)
    return Assemblies(ordered, done, closed, 0 if starts else -(-done // AT_ONCE))


class _Draw:
    """Random initial poses: in the plane of a planar mechanism, else in space."""

    def __init__(self, system: System, state: State, reach: Reach) -> None:
        self.system, self.plane = system, planar_reduction(system, state.q)
        #: The longest step that a search makes at once, in lengths of the mechanism.
        self.longest = max(reach.largest / system.length, 1.0)
        self.low, self.high = reach.box(self.plane.axes[:, :2] if isinstance(self.plane, Plane) else np.eye(3))

    def starts(self, rng: np.random.Generator, count: int) -> Array:
        """Return `count` random poses, (count, 7n)."""
        n = self.system.bodies
        place = rng.uniform(self.low, self.high, (count, *self.low.shape))
        if isinstance(self.plane, Plane):
            angle = rng.uniform(-np.pi, np.pi, (count, n, 1))
            p = np.concatenate([place, angle], axis=-1).reshape(count, -1)
            return self.plane.expanded(p, np.zeros_like(p))[0]
        orientation = rng.normal(size=(count, n, 4))
        orientation /= np.linalg.norm(orientation, axis=-1, keepdims=True)
        return np.concatenate([place, orientation], axis=-1).reshape(count, -1)


def _is_not_turned_over(system: System, q: Array) -> Flags:
    """Whether the axes that joints make parallel point the same way, for poses (B, 7n). The rows also allow opposite
    axes, which no assembly has."""
    cosines = system.alignment.value(pose_of(q).places(system.alignment))
    upright: Flags = np.asarray(np.all(cosines > 0.0, axis=-1))
    return upright


def _polished(system: System, q: Array, held: Conditions, drive: Drive) -> Array:
    return nearest(system, q, held, drive, THRESHOLDS.closed_grains * EPSILON)[0]


def _number(system: System, q: Array, known: list[Array]) -> int | None:
    """Return the number of a pose among those found; None where it is new."""
    apart = [_distance(system, q, each) for each in known]
    at = int(np.argmin(apart))
    return at if apart[at] < THRESHOLDS.same_pose else None


def _distance(system: System, q: Array, other: Array) -> float:
    """Return the distance of two poses, in lengths of the mechanism and rad."""
    a, b = q.reshape(-1, 7), other.reshape(-1, 7)
    shift = np.abs(a[:, :3] - b[:, :3]).max() / system.length
    cosine = np.abs((a[:, 3:] * b[:, 3:]).sum(axis=1)).clip(0.0, 1.0)
    return float(max(shift, 2.0 * np.sqrt(2.0 * (1.0 - cosine.min()))))


def _key(system: System, q: Array) -> tuple[float, ...]:
    values = np.concatenate([coordinate_values(system, pose_of(q)), q])
    return tuple(np.round(values, 6).tolist())


def _assembly(system: System, q: Array, held: Conditions, hits: int) -> Assembly:
    values = np.linalg.svd(scaled_rows_of(system, pose_of(q[None]), held)[0], compute_uv=False)
    distance = float(values[6 * system.bodies - 1]) if len(values) >= 6 * system.bodies else 0.0
    return Assembly(q, coordinate_values(system, pose_of(q)), hits, distance)


def conditions(system: System, state: State, wanted: Iterator[tuple[int, float | None]]) -> Conditions:
    """Return the conditions that hold coordinates, by number, at a value, or at their value in `state` for None."""
    values = coordinate_values(system, pose_of(state.q))
    pairs = [(index, float(values[index]) if value is None else value) for index, value in wanted]
    return Conditions(
        np.array([index for index, _ in pairs], dtype=np.intp), np.array([value for _, value in pairs], dtype=float)
    )


def close_all(system: System, q: Array, held: Conditions, drive: Drive, longest: float = 1.0) -> tuple[Array, Flags]:
    """Return the poses (B, 7n) reached from poses q (B, 7n), and whether each meets joints, motions and `held`
    coordinates. No step is longer than `longest` lengths of the mechanism."""
    q = q.copy()
    damping, going = np.full(len(q), THRESHOLDS.half_digits), np.ones(len(q), dtype=bool)
    left = scaled_residual(system, pose_of(q), held, drive)
    for _ in range(THRESHOLDS.most_passes):
        open_by = np.abs(left).max(axis=1, initial=0.0)
        going &= (open_by > THRESHOLDS.closed_to) & (damping < 1.0 / THRESHOLDS.half_digits)
        at = np.flatnonzero(going)
        if not len(at):
            break
        rows = scaled_rows_of(system, pose_of(q[at]), held)
        with may_overflow():
            trial = _moved(system, q[at], _steps(rows, left[at], damping[at], longest))
            trial_left = scaled_residual(system, pose_of(trial), held, drive)
        better = np.linalg.norm(trial_left, axis=1) < np.linalg.norm(left[at], axis=1)
        q[at[better]], left[at[better]] = trial[better], trial_left[better]
        damping[at] = np.where(better, np.maximum(0.2 * damping[at], THRESHOLDS.same_written), 4.0 * damping[at])
    closed: Flags = np.abs(left).max(axis=1, initial=0.0) <= THRESHOLDS.assembled
    return q, closed


def scaled_rows_of(system: System, pose: Pose, held: Conditions) -> Array:
    """Return the derivatives (B, m + c, 6n) of `scaled_residual` by (δr / length, δθ in body axes) of each body."""
    rows = _tangent(system, system.rows, pose) / system.row_scale[system.bodies :, None]
    if not len(held.index):
        return rows
    wanted = _tangent(system, system.coordinates, pose)[:, held.index]
    lengths = system.coordinates.is_length[held.index]
    return np.concatenate([rows, wanted / np.where(lengths, system.length, 1.0)[:, None]], axis=1)


def _tangent(system: System, bound: PrimitiveSet, pose: Pose) -> Array:
    """Return the derivatives (B, m, 6n) of a set's values, lengths in m, by (δr / length, δθ in body axes) of each
    body."""
    body, local = bound.body[bound.entry_slot], bound.local[bound.entry_slot]
    gradient = bound.gradient_entries(pose.places(bound))
    in_body = (gradient[..., None, :] @ pose.rotation[..., body, :, :])[..., 0, :]
    entries = np.empty((*gradient.shape[:-1], 6))
    entries[..., :3] = system.length * bound.is_point[bound.entry_slot, None] * gradient
    entries[..., 3:] = cross(np.broadcast_to(local, in_body.shape), in_body)
    rows = np.zeros((len(gradient), bound.size, system.bodies + 1, 6))
    for entry, (row, carrier) in enumerate(zip(bound.entry_row.tolist(), body.tolist(), strict=True)):
        rows[:, row, carrier] += entries[:, entry]
    return rows[:, :, :-1].reshape(len(gradient), bound.size, 6 * system.bodies)


def _steps(rows: Array, left: Array, damping: Array, longest: float) -> Array:
    """Return the damped steps (B, 6n), none longer than `longest` lengths of the mechanism, or a radian."""
    transposed = np.swapaxes(rows, -1, -2)
    square = transposed @ rows
    diagonal = np.einsum("bii->bi", square)
    diagonal += (damping * (1e-3 + (left * left).sum(axis=1)))[:, None]
    steps = -np.linalg.solve(square, transposed @ left[..., None])[..., 0]
    sizes = np.abs(steps) / np.tile([longest] * 3 + [1.0] * 3, steps.shape[1] // 6)
    return np.asarray(steps / np.maximum(sizes.max(axis=1, keepdims=True), 1.0))


def _moved(system: System, q: Array, motion: Array) -> Array:
    """Return q (B, 7n) after motions (B, 6n) of (δr / length, δθ in body axes)."""
    bodies, δ = q.reshape(len(q), -1, 7), motion.reshape(len(q), -1, 6)
    turn = 0.5 * (np.swapaxes(matrix_L(bodies[..., 3:]), -1, -2) @ δ[..., 3:, None])[..., 0]
    moved = np.concatenate([bodies[..., :3] + system.length * δ[..., :3], bodies[..., 3:] + turn], axis=-1)
    moved[..., 3:] /= np.linalg.norm(moved[..., 3:], axis=-1, keepdims=True)
    return moved.reshape(len(q), -1)


# --- How far bodies can be from points of the ground ------------------------------------------------------------------
# A path of links and rods reaches no farther than it is long. So a body's centre lies in a ball about each point of
# the ground that a joint holds. The radius is the length of the shortest path there: within a body from point to
# point, along a rod its length, through joints that hold two points together nothing. A joint that slides has the
# length at which it is held or driven. Where it is free it may slide as far as all lengths of the mechanism together,
# which loops of links do not exceed.


@dataclass(frozen=True, eq=False)
class Reach:
    """The points of the ground (g, 3) and, for each body's centre, its largest distance from each, (n, g), in m."""

    points: Array
    radius: Array

    @property
    def largest(self) -> float:
        """The longest way across the region of a body, m."""
        low, high = self.box(np.eye(3))
        return float((high - low).max(initial=0.0))

    def box(self, axes: Array) -> tuple[Array, Array]:
        """Return the least and the largest coordinates (n, k) along axes (3, k) of the bodies' centres."""
        along = self.points @ axes
        low = (along - self.radius[..., None]).max(axis=1)
        high = (along + self.radius[..., None]).min(axis=1)
        return low, high


def reach_of(system: System, q: Array, held: Conditions, drive: Drive) -> Reach:
    """Return the reach of the bodies; a pose q (7n,) lies within it, and widens it where a joint slides farther."""
    pose, n = pose_of(q), system.bodies
    body, local, ends = _points(system.joints)
    place = attached(pose, body, local, np.ones(len(body)))
    apart = np.full((len(body) + n,) * 2, np.inf)
    owner_body, all_places = np.concatenate([body, np.arange(n)]), np.concatenate([place, pose.position[:n]])
    same = owner_body[:, None] == owner_body
    between = np.linalg.norm(all_places[:, None] - all_places, axis=-1)
    apart[same] = between[same]
    free = []
    for joint, first, second in ends:
        length = _length(system, joint, held, drive)
        if length is None:
            free.append((first, second))
        else:
            apart[first, second] = apart[second, first] = min(apart[first, second], length)
    finite = np.where(np.isfinite(apart), apart, 0.0)
    bodies = sum(
        float(finite[np.ix_(on_body, on_body)].max(initial=0.0))
        for on_body in (owner_body == each for each in range(n + 1))
    )
    whole = max(bodies + _rods(apart, same), system.length)
    for first, second in free:
        apart[first, second] = apart[second, first] = min(apart[first, second], max(whole, between[first, second]))
    for via in range(len(apart)):
        apart = np.minimum(apart, apart[:, via, None] + apart[via])
    ground = np.flatnonzero(body == n)
    if not len(ground):
        middle = pose.position[:n].mean(axis=0)
        far = np.linalg.norm(pose.position[:n] - middle, axis=1, keepdims=True)
        return Reach(middle[None], np.maximum(far, whole))
    radius = np.where(np.isfinite(apart), apart, whole)[len(body) :, ground]
    known = np.maximum(radius, between[len(body) :, ground] * (1.0 + THRESHOLDS.rounded))
    return Reach(all_places[ground], known)


def _points(joints: PrimitiveSet) -> tuple[Integers, Array, list[tuple[int, int, int]]]:
    """Return the body (p,) and the local place (p, 3) of the joints' points, and for each joint with two of them its
    number and theirs."""
    body: list[int] = []
    local: list[Array] = []
    known: dict[tuple[int, bytes], int] = {}
    ends: dict[int, dict[int, int]] = {}
    owner = np.full(len(joints.body), -1, dtype=np.intp)
    owner[joints.entry_slot] = joints.owner[joints.entry_row]
    for slot in np.flatnonzero((joints.is_point > 0.0) & (owner >= 0)).tolist():
        key = int(joints.body[slot]), joints.local[slot].tobytes()
        if key not in known:
            known[key] = len(body)
            body.append(key[0])
            local.append(joints.local[slot])
        ends.setdefault(int(owner[slot]), {}).setdefault(int(joints.side[slot]), known[key])
    pairs = [(joint, of[1], of[2]) for joint, of in ends.items() if len(of) == 2]
    return np.array(body, dtype=np.intp), np.array(local).reshape(-1, 3), pairs


def _length(system: System, joint: int, held: Conditions, drive: Drive) -> float | None:
    """Return the largest distance of a joint's two points; None where it slides freely."""
    parts = []
    for member, row in _members(system.joints, joint):
        kind = name_of(type(member))
        if kind == "coincident":
            return 0.0
        if kind == "distance":
            return float(system.joints.offset[row])
        if kind == "along":
            parts.append(float(system.joints.offset[row]))
    known = dict(zip(held.index.tolist(), held.value.tolist(), strict=True))
    known |= dict(zip(system.motions.joint_coordinate.tolist(), drive.value.tolist(), strict=True))
    for member, row in _members(system.coordinates, joint):
        kind = name_of(type(member))
        if row in known and kind == "distance":
            return abs(known[row])
        if row in known and kind == "along":
            parts.append(known[row])
    return float(np.linalg.norm(parts)) if len(parts) >= 3 else None


def _members(bound: PrimitiveSet, joint: int) -> Iterator[tuple[Primitive, int]]:
    """The primitives of a joint, each with its first row."""
    for row in np.flatnonzero(bound.owner == joint).tolist():
        member = bound.layout.members[bound.layout.member[row]]
        if row == member.rows[0]:
            yield member.primitive, row


def _rods(apart: Array, same: Flags) -> float:
    """Return the sum of the lengths between points of different bodies."""
    between = np.triu(np.where(np.isfinite(apart) & ~same, apart, 0.0))
    return float(between.sum())
