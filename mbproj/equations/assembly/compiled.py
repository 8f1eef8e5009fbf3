"""A scene compiled to its System; joints whose numbers are rounded are adjusted, so that their loops close.

A linkage whose rows depend on each other moves only where its numbers are exact. With rounded numbers some rows depend
on each other only nearly, and the linkage is locked. The change δ of all joints' frames is the shortest one for which
all poses of a sample are closed while C_q keeps its smaller rank:

    minimise |δ|   where   Nₖᵀ (C(qₖ) + D δ) = 0   at each pose qₖ


with N the left singular vectors of C_q beyond that rank and D = ∂C/∂δ. The poses follow by qₖ ← qₖ - C_q⁺ (C + D δ).
Gauss-Newton repeats both until the changes are round-off.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.gauss_newton import moved, set_rows
from mbproj.equations.constraints import EPSILON
from mbproj.equations.kinematics import pose_of
from mbproj.model.compile.mechanism import initial_guess, with_elements_of, without_elements
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import Adjustment, System
from mbproj.scene.scene import Scene

#: The number of poses of the sample, and of further poses that must then be closed as well.
POSES, HELD_OUT = 7, 3
#: The step of central differences at which truncation and round-off have about the same size.
DIFFERENCE = EPSILON ** (1.0 / 3.0)
#: The number of joints that a note names.
MOST_NAMED = 4


def compile_system(scene: Scene) -> System:
    """Return the mechanism of the scene as frozen arrays, with its joints adjusted where the scene asks for that.

    Raises InputError where nothing can move, a joint would move too far, or an element names something that does not
    exist."""
    system, derived = without_elements(scene)
    most = scene.settings.adjust_joints
    if most is not None:
        system = adjusted(system, initial_guess(scene, system).q, most)
    return with_elements_of(scene, system, derived)


def adjusted(system: System, q: Array, most: float) -> System:
    """Return the system with joints moved so that its loops close. Return the same system where they close already, or
    where no adjustment closes them.

    Raises InputError where a point would move by more than `most` in m."""
    if system.bodies > THRESHOLDS.large or not system.joints.size:
        return system
    pose = _Adjusting(system.at_positions).adjustment(q)
    if pose is None:
        return system
    changes = tuple(_changes(system, *pose))
    largest = max(change.size(system.length) for change in changes)
    if largest > most:
        far, asked = f"{1e6 * largest:.3g} um", f"{1e6 * most:.3g} um"
        what = f"its loops close where joints move by up to {far}, and adjust_joints is {asked}"
        hint = f"look whether the numbers are right, or give adjust_joints: {rounded_up(largest)}"
        worst = max(changes, key=lambda change: change.size(system.length))
        place = system.joint_places[system.names.joints.index(worst.joint)]
        raise InputError(Problem(f"joint '{worst.joint}': {what}", place, hint))
    shift, tilt = pose
    return replace(
        system,
        joints=_moved(system.joints, shift, tilt),
        coordinates=_moved(system.coordinates, shift, tilt),
        alignment=_moved(system.alignment, shift, tilt),
        adjustments=changes,
    )


def adjustment_notes(scene: Scene, system: System) -> list[Problem]:
    """Return a note on how far joints were moved, the largest first; no note where none was moved."""
    changes = sorted(system.adjustments, key=lambda change: change.size(system.length), reverse=True)
    if not changes:
        return []
    named = [
        f"'{change.joint}' by {1e6 * change.shift:.3g} um and {1e6 * change.tilt:.3g} urad"
        for change in changes[:MOST_NAMED]
    ]
    more = f", and {len(changes) - MOST_NAMED} more by less" if len(changes) > MOST_NAMED else ""
    what = f"{len(changes)} joints were moved so that the loops close: {', '.join(named)}{more}"
    return [Problem(what, scene.place("simulation", "adjust_joints"))]


def rounded_up(size: float) -> str:
    """Return a length given in m as text in um with two digits, rounded up."""
    digits = 10.0 ** (np.floor(np.log10(1e6 * size)) - 1.0)
    return f"{np.ceil(1e6 * size / digits) * digits:.6g} um"


def needed(system: System, q: Array) -> float:
    """Return how far a joint's points must move for the loops to close, in m; 0 where they close already, or cannot."""
    if system.bodies > THRESHOLDS.large or not system.joints.size:
        return 0.0
    closed = _Adjusting(system.at_positions).adjustment(q)
    return 0.0 if closed is None else max(change.size(system.length) for change in _changes(system, *closed))


def _changes(system: System, shift: Array, tilt: Array) -> Iterator[Adjustment]:
    """The adjustment of each joint that moves: the larger one of its two frames."""
    for at, name in enumerate(system.names.joints):
        frames = slice(2 * at, 2 * at + 2)
        change = Adjustment(
            name,
            float(np.linalg.norm(shift[frames], axis=1).max()),
            float(np.linalg.norm(tilt[frames], axis=1).max()),
        )
        if change.size(system.length) > 0.0:
            yield change


def _holders(bound: PrimitiveSet) -> Integers:
    """Return 2 joint + side - 1 of each attachment, the number of its frame."""
    joint = np.zeros(len(bound.body), dtype=np.intp)
    joint[bound.entry_slot] = bound.owner[bound.entry_row]
    return 2 * joint + bound.side - 1


def _moved(bound: PrimitiveSet, shift: Array, tilt: Array) -> PrimitiveSet:
    """Return the set with points shifted and vectors turned by those of their frames, (frames, 3) each, in body
    axes."""
    if not bound.size:
        return bound
    held, local, point = _holders(bound), bound.local.copy(), bound.is_point > 0.0
    local[point] += shift[held[point]]
    vector, turned = local[~point], tilt[held[~point]]
    angle = np.linalg.norm(turned, axis=1, keepdims=True)
    axis = np.where(angle > 0.0, turned / np.where(angle > 0.0, angle, 1.0), 0.0)
    along = axis * np.sum(axis * vector, axis=1, keepdims=True)
    local[~point] = along + np.cos(angle) * (vector - along) + np.sin(angle) * np.cross(axis, vector)
    return replace(bound, local=local)


@dataclass(frozen=True, eq=False)
class _Adjusting:
    """The search for an adjustment δ (frames, 6), for each frame a shift over the mechanism's length and a tilt. Rows C
    (m,) of the joints are in units of that length."""

    system: System

    def _set(self, delta: Array) -> PrimitiveSet:
        return _moved(self.system.joints, self.system.length * delta[:, :3], delta[:, 3:])

    @property
    def _scale(self) -> Array:
        return np.where(self.system.joints.is_length, self.system.length, 1.0)

    def _zero(self) -> Array:
        return np.zeros((2 * len(self.system.names.joints), 6))

    def rows(self, q: Array, delta: Array) -> Array:
        """Return C at a pose with the frames moved by `delta`."""
        bound = self._set(delta)
        return np.asarray(bound.value(pose_of(q).places(bound)) / self._scale)

    def factor(self, q: Array, delta: Array) -> tuple[Array, Array, Array]:
        """Return the singular value decomposition of C_q by (δr / length, δθ): all left vectors, values, and right
        vectors."""
        G = set_rows(self.system, self._set(delta), pose_of(q)).dense() / self._scale[:, None]
        U, s, V = np.linalg.svd(G)
        return U, s, V

    def by_frames(self, q: Array, delta: Array) -> Array:
        """Return ∂C/∂δ, (m, 6 frames), by central differences; couplings have no frames of their own."""
        bound = self.system.joints
        gradient = np.zeros((bound.size, len(delta), 6))
        members = bound.layout.members
        rows = np.flatnonzero([members[at].primitive.follows != "coordinates" for at in bound.layout.member])
        for part in range(6):
            for side in (0, 1):
                step = np.zeros_like(delta)
                step[side::2, part] = DIFFERENCE
                slope = (self.rows(q, delta + step) - self.rows(q, delta - step)) / (2.0 * DIFFERENCE)
                gradient[rows, 2 * bound.owner[rows] + side, part] = slope[rows]
        return gradient.reshape(bound.size, -1)

    def adjustment(self, q: Array) -> tuple[Array, Array] | None:
        """Return the shift in m and the tilt in rad of each frame, (frames, 3); None where no adjustment is needed, or
        none closes the loops."""
        delta = self._zero()
        _, s, _ = self.factor(q, delta)
        rank = int(np.count_nonzero(s > THRESHOLDS.rounded * s[0]))
        if rank == len(q) // 7 * 6 or not np.any(s[rank:] > THRESHOLDS.rounding * s[0]):
            return None
        rng = np.random.default_rng(0)
        start = self._closed_pose(q, delta, rank)
        poses = [start, *(self._away(start, delta, rank, rng) for _ in range(POSES - 1))]
        if max(float(np.abs(self.rows(pose, delta)).max()) for pose in poses) > THRESHOLDS.rounded:
            return None  # the rows are independent elsewhere: the start is near a singular pose
        for _ in range(THRESHOLDS.most_passes):
            delta, poses, step = self._step(poses, delta, rank)
            if step < THRESHOLDS.rounding:
                break
        others = [self._away(start, delta, rank, rng) for _ in range(HELD_OUT)]
        open_by = max(float(np.abs(self.rows(pose, delta)).max()) for pose in (*poses, *others))
        if open_by > THRESHOLDS.closed_to:
            return None
        return self.system.length * delta[:, :3], delta[:, 3:]

    def _step(self, poses: list[Array], delta: Array, rank: int) -> tuple[Array, list[Array], float]:
        """Return δ and the poses after one Gauss-Newton step, and the size of the change of δ."""
        wanted, sides, known = [], [], []
        for q in poses:
            C, D, (U, s, V) = self.rows(q, delta), self.by_frames(q, delta), self.factor(q, delta)
            wanted.append(U[:, rank:].T @ D)
            sides.append(-U[:, rank:].T @ C)
            known.append((C, D, U[:, :rank] / s[:rank], V[:rank]))
        change = np.linalg.lstsq(np.vstack(wanted), np.concatenate(sides), rcond=DIFFERENCE)[0]
        after = [
            moved(self.system, q, -V.T @ (U.T @ (C + D @ change))) for q, (C, D, U, V) in zip(poses, known, strict=True)
        ]
        return delta + change.reshape(-1, 6), after, float(np.abs(change).max(initial=0.0))

    def _closed_pose(self, q: Array, delta: Array, rank: int) -> Array:
        """Return the pose nearest to q that closes the part of C within the range of C_q, which has this rank."""
        for _ in range(THRESHOLDS.most_passes):
            U, s, V = self.factor(q, delta)
            step = V[:rank].T @ (U[:, :rank].T @ self.rows(q, delta) / s[:rank])
            q = moved(self.system, q, -step)
            if np.abs(step).max() < THRESHOLDS.closed_to:
                break
        return q

    def _away(self, q: Array, delta: Array, rank: int, rng: np.random.Generator) -> Array:
        """Return a pose some way from q along a random direction that C_q of this rank leaves free."""
        free = self.factor(q, delta)[2][rank:]
        way = rng.normal(size=len(free)) @ free
        return self._closed_pose(moved(self.system, q, THRESHOLDS.long_way * way / np.abs(way).max()), delta, rank)
