"""Reduces a system to its plane, or gives the reason why it has none.

Some rows are neither inside nor outside on their own, but in combination. A prismatic joint's vectors x and y are
normal to its axis, at any angle to the plane's normal n. So none of its rows need be inside or outside. Rows of a joint
that differ only in their vector (`along`), or have the same two bodies (`perpendicular`), form a block. A block locks
shifts along, or turns about, the directions that its rows span.

Where n is one of these directions, the block splits. As many rows are inside as there are motions in the plane that the
block locks. The others, minus multiples of the rows inside, are outside.

For `along` this split holds in every pose. For `perpendicular` it holds where the joint is closed: the row inside keeps
the bodies from turning about n, and without such a turn the others have no gradient in the plane. In a joint that is
open by an angle δ they have a gradient of the order of δ, which is dropped. Where n is not among the directions, the
joint is tilted and the scene is not planar.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Integers, cross, like_of, numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.joints.primitives.table import PRIMITIVES
from mbproj.model.channels import Channels
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.forces import Bushings
from mbproj.model.planar.certain import (
    BESIDE,
    INSIDE,
    OUTSIDE,
    STRANGE,
    TILTED,
    RowMap,
    Seen,
    candidate_normals,
    certain_plane,
    kind_of,
    plane_axes,
    see,
    seen_from,
    sides,
    strangeness,
)
from mbproj.model.planar.plane import Plane, planar_set
from mbproj.model.primitive_set import PrimitiveSet, bind, bindings
from mbproj.model.system import System

_NORMAL = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class NotPlanar:
    """The reason why a scene is not planar, in words that name the joint or the body."""

    reason: str


@dataclass(frozen=True, eq=False)
class _Pose:
    """A pose: positions (n+1, 3), unit Euler parameters (n+1, 4) and rotation matrices (n+1, 3, 3), the ground last."""

    position: Array
    orientation: Array
    rotation: Array


def planar_reduction(system: System, q: Array) -> Plane | NotPlanar:
    """Return the plane in which the joints keep all bodies, at the assembled pose q (7n,), or the reason why there is
    none.

    The verdict rests on the joints alone: not on initial velocities, nor on symmetry of forces or inertia. Candidates
    for the normal with most rows outside come first; the reason is that of the first candidate.
    """
    rows = np.concatenate([q.reshape(-1, 7), [[0.0, 0, 0, 1, 0, 0, 0]]])
    orientation = rows[:, 3:] / np.linalg.norm(rows[:, 3:], axis=1, keepdims=True)
    pose = _Pose(rows[:, :3], orientation, rotation_matrix(orientation))
    known = certain_plane(system.joints, pose.position, pose.rotation, system.length)
    if known is not None:
        find = _plane if known.is_held else _reduction
        plane = find(system, pose, known.axes, known.seen, known.side)
        if isinstance(plane, Plane):
            return plane
    refusals = []
    for axes, joints, side in _candidates(system, pose):
        reduction = _reduction(system, pose, axes, joints, side)
        if isinstance(reduction, Plane):
            return reduction
        refusals.append(reduction)
    return (
        refusals[0]
        if refusals
        else NotPlanar("nothing but symmetry can keep the bodies in a plane: no joint has an axis")
    )


def _candidates(system: System, pose: _Pose) -> list[tuple[Array, Seen, Integers]]:
    """Return the axes (3, 3) to try, the joints as seen along them, and the side of each row. Candidates with most rows
    outside come first; of equal ones, those with fewest rows inside."""
    normals = candidate_normals(system.joints, pose.rotation)
    if not len(normals):
        return []
    axes = numbers([plane_axes(normal) for normal in normals])
    joints = _attachments(system.joints, pose, axes, system.length)
    side = sides(system.joints, joints)
    ranked = np.lexsort([np.count_nonzero(side == INSIDE, axis=1), -np.count_nonzero(side == OUTSIDE, axis=1)])
    return [(axes[number], joints.in_axes(number), side[number]) for number in ranked.tolist()]


def _reduction(system: System, pose: _Pose, axes: Array, joints: Seen, side: Integers) -> Plane | NotPlanar:
    """Return the plane with these axes, or the reason against it."""
    parts = split(system.joints, joints, side)
    if isinstance(parts, Refusal):
        return _not_planar(f"joint '{system.names.joints[parts.joint]}' {parts.cause}, seen in the plane", axes)
    loose = escape(system.joints, joints, parts.outside, system.names.carriers, system.length)
    if loose is not None:
        return _not_planar(loose, axes)
    return _plane(system, pose, axes, joints, np.where(parts.inside, INSIDE, OUTSIDE))


def _plane(system: System, pose: _Pose, axes: Array, joints: Seen, side: Integers) -> Plane | NotPlanar:
    """Return the plane with these axes, in which the joints hold the bodies, or the refusal for an angle that is tilted
    against it."""
    n, inside = system.bodies, side == INSIDE
    coordinates = _attachments(system.coordinates, pose, axes, system.length)
    changing = _changing(system.coordinates, coordinates)
    if not changing.all():
        rate = _in_plane_rate(system.coordinates, coordinates)
        tilted = np.flatnonzero(~changing & (np.abs(rate) > THRESHOLDS.dependent))
        if len(tilted):
            return _not_planar(f"the angle '{system.names.coordinates[tilted[0]]}' is tilted, seen in the plane", axes)
    normal = (np.swapaxes(pose.rotation[:n], -1, -2) @ axes[:, 2, None])[..., 0]
    return Plane(
        axes=axes,
        depth=pose.position[:n] @ axes[:, 2],
        reference=pose.orientation[:n],
        mass=system.mass,
        inertia=np.einsum("ni,nij,nj->n", normal, system.inertia, normal),
        gravity=system.gravity @ axes[:, :2],
        joints=planar_set(system.joints, joints, inside, axes),
        coordinates=planar_set(system.coordinates, coordinates, changing, axes),
        constant=np.flatnonzero(~changing),
    )


def _attachments(bound: PrimitiveSet, pose: _Pose, axes: Array, length: float) -> Seen:
    return see(bound, pose.position, pose.rotation, axes, length)


def _changing(bound: PrimitiveSet, seen: Seen) -> npt.NDArray[np.bool_]:
    """Whether each coordinate can change, (nc,): angles between vectors in the plane, and displacements along a vector
    that is not the normal. Other tilted coordinates belong to motions that the joint locks."""
    side = sides(bound, seen)
    shift = np.zeros(bound.size, dtype=bool)
    for group in bound.groups:
        shift[group.rows] = isinstance(group.primitive, PRIMITIVES["along"])
    return (side == INSIDE) | (shift & (side != OUTSIDE))


def _in_plane_rate(bound: PrimitiveSet, seen: Seen) -> Array:
    """Return the rates of the coordinates, (nc,), while body 2 of each joint turns about n at 1 rad/s."""
    turning = cross(np.array([0.0, 0.0, 1.0]), seen.arm) * (bound.side == 2)[:, None]
    return bound.derivative_along(bound.gradient_entries(seen.x), turning)


def _not_planar(what: str, axes: Array) -> NotPlanar:
    x, y, z = axes[:, 2].tolist()
    return NotPlanar(f"{what} normal to [{x:.3g}, {y:.3g}, {z:.3g}]")


@dataclass(frozen=True, eq=False)
class Refusal:
    """The reason why rows do not split: the joint's index, and the cause in words that follow the joint's name."""

    joint: int
    cause: str


@dataclass(frozen=True, eq=False)
class PlaneSplit:
    """`inside` (m,) marks the rows that act in the plane; `outside` makes the rows that hold the bodies in it. Rows of
    coincident points are along e1, e2 and n here."""

    inside: npt.NDArray[np.bool_]
    outside: RowMap


@dataclass(frozen=True, eq=False)
class _Block:
    """Rows (k,) of one joint and the directions (k, 3) that they lock, in plane axes. `in_plane` selects the components
    of a direction that are motion in the plane: e1 and e2 of a shift, n of a turn."""

    joint: int
    rows: Integers
    directions: Array
    in_plane: slice


def split(bound: PrimitiveSet, seen: Seen, side: Integers) -> PlaneSplit | Refusal:
    """Return the rows inside and outside, from the side of each on its own; or the first joint that does not split."""
    strange = np.flatnonzero(side == STRANGE)
    if len(strange):
        return Refusal(int(bound.owner[strange[0]]), strangeness(bound, int(strange[0])))
    inside = side == INSIDE
    combinations = [([row], [1.0]) for row in np.flatnonzero(side == OUTSIDE).tolist()]
    for block in _tilted_blocks(bound, seen, side):
        if not _spans_normal(block.directions):
            return Refusal(block.joint, "is tilted")
        pivots, coefficients = _eliminated(block.directions[:, block.in_plane])
        inside[block.rows] = False
        inside[block.rows[pivots]] = True
        for place, row in enumerate(block.rows.tolist()):
            if place not in pivots and side[row] != OUTSIDE:
                combinations.append(([row, *block.rows[pivots].tolist()], [1.0, *(-coefficients[place]).tolist()]))
    return PlaneSplit(inside, _row_map(combinations))


def _row_map(combinations: list[tuple[list[int], list[float]]]) -> RowMap:
    row = np.repeat(np.arange(len(combinations)), [len(sources) for sources, _ in combinations])
    source = np.array([source for sources, _ in combinations for source in sources], dtype=np.intp)
    return RowMap(len(combinations), row, source, numbers([w for _, weights in combinations for w in weights]))


def _tilted_blocks(bound: PrimitiveSet, seen: Seen, side: Integers) -> Iterator[_Block]:
    """The blocks that have a tilted row, joint by joint."""
    group_of, place = np.empty((2, bound.size), dtype=np.intp)
    for index, group in enumerate(bound.groups):
        group_of[group.rows] = index
        place[group.rows] = np.arange(len(group.rows))[:, None]
    for joint in sorted(set(bound.owner[side == TILTED].tolist())):
        members: dict[tuple[str, bytes], list[tuple[int, Array]]] = {}
        for row in range(*np.searchsorted(bound.owner, [joint, joint + 1])):  # a joint's rows are consecutive
            group = bound.groups[group_of[row]]
            kind, slots = kind_of(group.primitive), group.slots[place[row]]
            if kind in ("along", "perpendicular"):
                shared, direction = (_shift if kind == "along" else _turn)(bound, seen, slots)
                members.setdefault((kind, shared), []).append((row, direction))
        for (kind, _), block in members.items():
            rows = np.array([row for row, _ in block], dtype=np.intp)
            if np.any(side[rows] == TILTED):
                in_plane = slice(0, 2) if kind == "along" else slice(2, 3)
                yield _Block(joint, rows, numbers([direction for _, direction in block]), in_plane)


def _shift(bound: PrimitiveSet, seen: Seen, slots: Integers) -> tuple[bytes, Array]:
    """Return the key by which an `along` row belongs to a block, and the direction of the shift that it locks: its
    vector."""
    return bound.body[slots].tobytes() + bound.local[slots[1:]].tobytes(), seen.x[slots[0]]


def _turn(bound: PrimitiveSet, seen: Seen, slots: Integers) -> tuple[bytes, Array]:
    """Return the key by which a `perpendicular` row belongs to a block, and the axis of the turn that it locks. For a
    turn φ of b's body relative to a's, a·(φ × b) = φ·(b × a)."""
    a, b = seen.x[slots]
    return bound.body[slots].tobytes(), cross(b, a)


def _spans_normal(directions: Array) -> bool:
    """Whether n is a combination of the directions (k, 3)."""
    _, values, basis = np.linalg.svd(directions, full_matrices=False)
    basis = basis[values > THRESHOLDS.rounding]
    return bool(np.linalg.norm(_NORMAL - (basis @ _NORMAL) @ basis) <= THRESHOLDS.rounding)


def _eliminated(parts: Array) -> tuple[list[int], Array]:
    """Return rows of `parts` (k, d) that span all, the largest first, and the coefficients (k, p) of all rows in
    these."""
    pivots: list[int] = []
    coefficients, rest = np.zeros((len(parts), 0)), parts
    while np.abs(rest).max() > THRESHOLDS.rounding:
        pivots.append(int(np.argmax(np.linalg.norm(rest, axis=1))))
        coefficients = parts @ np.linalg.pinv(parts[pivots])
        rest = parts - coefficients @ parts[pivots]
    return pivots, coefficients


# --- Whether the rows outside hold every body in the plane ------------------------------------------------------------
# Full column rank in the motions out of it. Out of the plane a body has three motions: a shift along n and turns
# about e1 and e2. As in `equations/rank`, lengths are in units of the system's length, and rows have unit length. A
# row counts where it is independent of the rows before it. A walk from the ground takes bodies one by one. A body
# whose rows to bodies already held have rank 3 is held too, because the matrix is block triangular. The walk costs
# linear time and settles trees, and loops that close joint by joint. Only connected pieces that it leaves need a
# factor: dense, or sparse where there are many bodies.


#: Rows as mappings from each body to the three entries of the row for that body.
Rows = list[dict[int, list[float]]]
#: The number of random motions that are tried on a large piece, their seed, and the passes of inverse iteration.
MOTIONS, SEED, PASSES = 4, 3, 3


def escape(bound: PrimitiveSet, seen: Seen, outside: RowMap, names: tuple[str, ...], length: float) -> str | None:
    """Return, in words, a body that the rows outside do not hold in the plane; None where they hold all."""
    rows = _rows(bound, seen, outside, len(names), length)
    free = _not_reached(rows, len(names))
    for piece, piece_rows in _pieces(rows, free):
        body = _moving(piece_rows, piece)
        if body is not None:
            return f"nothing but symmetry keeps body '{names[body]}' in the plane"
    return None


def _rows(bound: PrimitiveSet, seen: Seen, outside: RowMap, bodies: int, length: float) -> Rows:
    """Return the rows outside in (δz / length, turns about e1 and e2) of each body."""
    gradient, arm = bound.gradient_entries(seen.x), seen.arm[bound.entry_slot]
    turn, owner = cross(arm, gradient), bound.body[bound.entry_slot]
    parts = np.column_stack([length * bound.is_point[bound.entry_slot] * gradient[:, 2], turn[:, :2]])
    mine = np.flatnonzero(owner < bodies)
    mine = mine[np.argsort(bound.entry_row[mine], kind="stable")]
    first, end = (np.searchsorted(bound.entry_row[mine], outside.source, side) for side in ("left", "right"))
    count = end - first
    entry = mine[np.repeat(first - np.cumsum(count) + count, count) + np.arange(count.sum())]
    places, same = np.unique(np.repeat(outside.row, count) * bodies + owner[entry], return_inverse=True)
    values = np.zeros((len(places), 3), like=parts)
    np.add.at(values, same, np.repeat(outside.weight, count)[:, None] * parts[entry])
    row = places // bodies
    norm = np.sqrt(np.bincount(row, np.sum(values**2, axis=1), minlength=outside.size))
    values /= np.where(norm == 0.0, 1.0, norm)[row, None]
    rows: Rows = [{} for _ in range(outside.size)]
    for at, body, part in zip(row.tolist(), (places % bodies).tolist(), values.tolist(), strict=True):
        rows[at][body] = part
    return rows


def _not_reached(rows: Rows, bodies: int) -> list[int]:
    """Return the bodies that the walk from the ground does not reach."""
    rows_of: list[list[int]] = [[] for _ in range(bodies)]
    for index, row in enumerate(rows):
        for body in row:
            rows_of[body].append(index)
    basis: list[list[list[float]]] = [[] for _ in range(bodies)]
    waiting = [len(row) for row in rows]
    ready = deque(index for index, count in enumerate(waiting) if count == 1)
    while ready:
        index = ready.popleft()
        for body in [body for body in rows[index] if len(basis[body]) < 3]:  # the free body, if it is not held yet
            _extend(basis[body], rows[index][body])
            if len(basis[body]) == 3:
                for other in rows_of[body]:
                    waiting[other] -= 1
                    if waiting[other] == 1:
                        ready.append(other)
    return [body for body in range(bodies) if len(basis[body]) < 3]


def _extend(basis: list[list[float]], part: list[float]) -> None:
    """Add the part that is independent of the basis to it (Gram-Schmidt). Two passes are enough (Kahan)."""
    x, y, z = part
    for _ in range(2):
        for a, b, c in basis:
            inner = a * x + b * y + c * z
            x, y, z = x - inner * a, y - inner * b, z - inner * c
    norm = np.sqrt(x * x + y * y + z * z)
    if norm > THRESHOLDS.dependent:
        basis.append([x / norm, y / norm, z / norm])


def _pieces(rows: Rows, free: list[int]) -> list[tuple[list[int], Rows]]:
    """Return the free bodies in connected pieces, each with its rows, without the entries of bodies that are held."""
    piece_of = {body: [body] for body in free}
    left = [{body: part for body, part in row.items() if body in piece_of} for row in rows]
    left = [row for row in left if row]
    for row in left:
        first, *others = row
        for body in others:
            one, other = sorted((piece_of[first], piece_of[body]), key=len, reverse=True)
            if one is not other:
                one.extend(other)
                piece_of.update(dict.fromkeys(other, one))
    rows_of: dict[int, Rows] = {id(piece): [] for piece in piece_of.values()}
    for row in left:
        rows_of[id(piece_of[next(iter(row))])].append(row)
    pieces = {id(piece): piece for piece in piece_of.values()}
    return [(sorted(piece), rows_of[key]) for key, piece in pieces.items()]


def _moving(rows: Rows, piece: list[int]) -> int | None:
    """Return the body of a piece that its rows let move most, the first among equals; None where their rank is full.
    For a large piece with too few rows, return the body with the fewest."""
    is_large = len(piece) > THRESHOLDS.large
    if is_large and len(rows) < 3 * len(piece):
        rows_on = Counter(body for row in rows for body in row)
        return min(piece, key=lambda body: rows_on[body])
    place = {body: index for index, body in enumerate(piece)}
    row = [number for number, parts in enumerate(rows) for _ in parts]
    column = [place[body] for parts in rows for body in parts]
    values = numbers([part for parts in rows for part in parts.values()]).reshape(-1, 3)
    free = _some_free_motions if is_large else _free_motions
    motions = free(np.array(row, dtype=np.intp), np.array(column, dtype=np.intp), values, (len(rows), len(piece)))
    if not len(motions):
        return None
    moved = np.linalg.norm(motions, axis=(0, 2))
    return piece[int(np.argmax(moved > (1.0 - THRESHOLDS.rounded) * moved.max()))]


def _free_motions(row: Integers, body: Integers, values: Array, shape: tuple[int, int]) -> Array:
    """Return a basis (k, b, 3) of the motions that all rows allow, from the rows' entries (e, 3)."""
    matrix = np.zeros((*shape, 3), like=values)
    matrix[row, body] = values
    _, values, vectors = np.linalg.svd(matrix.reshape(shape[0], 3 * shape[1]), full_matrices=True)
    motions: Array = vectors[np.count_nonzero(values > THRESHOLDS.dependent) :].reshape(-1, shape[1], 3)
    return motions


def _some_free_motions(row: Integers, body: Integers, values: Array, shape: tuple[int, int]) -> Array:
    """Return some random motions of a large piece that all rows allow, by inverse iteration with a sparse factor of
    RᵀR. A motion counts as allowed where the rows resist it by less than the root of the shift; the scene then runs in
    space."""
    from scipy import sparse
    from scipy.sparse.linalg import splu

    column = (3 * body[:, None] + np.arange(3)).ravel()
    R = sparse.csr_array((values.ravel(), (np.repeat(row, 3), column)), shape=(shape[0], 3 * shape[1]))
    shift = THRESHOLDS.no_digits
    shifted = (R.T @ R + shift * sparse.eye_array(3 * shape[1])).tocsc()
    factor = splu(shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    motions = np.random.default_rng(SEED).normal(size=(3 * shape[1], MOTIONS))
    for _ in range(PASSES):
        motions = factor.solve(motions)
        motions /= np.linalg.norm(motions, axis=0)
    allowed = np.linalg.norm(R @ motions, axis=0) < math.sqrt(shift)
    return np.asarray(motions[:, allowed].T.reshape(-1, shape[1], 3))


# --- Forces and motions of a planar scene -----------------------------------------------------------------------------
# Those that act in the plane, and those for which a scene is not planar.
# Bushings have three coordinates in the plane, with their stiffness, in place of six. Where the relative rotation is
# about the normal n, its vector is θ n, and the translation has a constant part along n: the six coordinates are
# linear in two components and θ, s = B y + s0. Then F in the plane is Bᵀ F, exactly; the joints bear the rest.


def obstacle_in_plane(system: System, plane: Plane) -> str | None:
    """Return the first load, motion, stop or friction that is no function of the coordinates in the plane, in words;
    None without any.

    Forces out of the plane are no obstacle: the joints bear them.
    """
    locked = np.flatnonzero(coordinates_in_plane(plane, system.motions.joint_coordinate) < 0)
    if len(locked):
        return f"motion '{system.names.motions[locked[0]]}' drives a coordinate out of the plane"
    named = channels_in_plane(plane, system.channels)
    if (named < 0).any():
        name = system.names.coordinates[int(system.channels.index[int(np.argmax(named < 0))])]
        return f"a function names '{name}', a coordinate out of the plane"
    laws, owners = system.forces.laws, [f"force '{name}' acts" for name in system.forces.law_owners]
    leaves = _leaves_plane(system, plane, laws.coordinates, laws.joint_coordinate, owners)
    if leaves is not None:
        return leaves
    leaning = tilted_bushings(plane, system.forces.bushings)
    if len(leaning):
        return f"the frames of force '{system.forces.bushing_names[leaning[0]]}' lean against each other"
    if system.stops is not None:
        owners = [f"the stop of {owner} acts" for owner in system.stops.owners]
        leaves = _leaves_plane(system, plane, system.stops.coordinates, system.stops.joint_coordinate, owners)
        if leaves is not None:
            return leaves
    return _friction_obstacle(system, plane)


def _friction_obstacle(system: System, plane: Plane) -> str | None:
    """Return the friction that depends on forces or moments out of the plane, which the plane does not know; None
    without any. Of the two tangents at a stop one may be normal to the plane."""
    bearings, frictions = system.bearings, system.frictions
    frames = np.concatenate([rotation_matrix(plane.reference), np.eye(3)[None]])
    if bearings is not None:
        axis = (frames[system.reaction_body[bearings.joint]] @ bearings.axis[..., None])[..., 0]
        tilted = np.abs(axis @ plane.axes[:, 2]) < (1.0 - THRESHOLDS.rounding) * np.linalg.norm(axis, axis=-1)
        leaves = tilted | ((bearings.axial > 0.0) & ~bearings.is_of_rows) | np.isfinite(bearings.length)
        if leaves.any():
            joint = system.names.joints[int(bearings.joint[int(np.argmax(leaves))])]
            return f"friction depends on the load of joint '{joint}' out of the plane"
    if frictions is None:
        return None
    bound, side = (
        bindings(frictions.coordinates),
        sides(frictions.coordinates, _in_plane(system, plane, frictions.coordinates)),
    )
    in_plane = np.flatnonzero((frictions.partner < 0) | ((side != OUTSIDE) & (side != BESIDE)))
    along = bind([replace(bound[k], owner=at) for at, k in enumerate(in_plane)])
    owners = [f"{frictions.owners[k]} acts" for k in in_plane]
    return _leaves_plane(system, plane, along, frictions.joint_coordinate[in_plane], owners)


def _leaves_plane(
    system: System, plane: Plane, along: PrimitiveSet, joint_coordinate: Integers, owners: Sequence[str]
) -> str | None:
    """Return the first owner whose coordinate is no function of those in the plane, in words; None without any."""
    of_joints = joint_coordinate >= 0
    locked = np.flatnonzero(of_joints & (coordinates_in_plane(plane, joint_coordinate) < 0))
    if len(locked):
        return f"{owners[locked[0]]} along a coordinate out of the plane"
    leaves = ~of_joints & (sides(along, _in_plane(system, plane, along)) != INSIDE)
    for group in along.groups:
        has_axis = "vector" in group.primitive.slots
        for row in group.rows[leaves[group.rows[:, 0]], 0]:
            what = "along an axis out of the plane" if has_axis else "between points at different depths"
            return f"{owners[row]} {what}"
    return None


def coordinates_in_plane(plane: Plane, joint_coordinate: Integers) -> Integers:
    """Return the numbers in `plane.coordinates` of the system's joint coordinates (k,); -1 for one that is constant in
    the plane, and for -1."""
    number = np.full(len(plane.constant) + plane.coordinates.size + 1, -1, dtype=np.intp)
    number[plane.coordinates.source.source] = np.arange(plane.coordinates.size)
    return number[joint_coordinate]


def channels_in_plane(plane: Plane, channels: Channels) -> Integers:
    """Return the numbers of channels (c,) among the states of elements or in `plane.coordinates`; -1 for none."""
    index = channels.index.copy()
    index[~channels.is_state] = coordinates_in_plane(plane, index[~channels.is_state])
    return index


def locals_in_plane(plane: Plane, bound: PrimitiveSet) -> Array:
    """Return the local vectors (S, 2) of a set's attachments in their bodies' planar axes."""
    return _in_axes(plane, bound)[:, :2]


def _in_plane(system: System, plane: Plane, bound: PrimitiveSet) -> Seen:
    """Return a set in plane axes at the plane's reference."""
    depth = np.append(plane.depth, 0.0)
    return seen_from(bound, _in_axes(plane, bound), depth[:, None] * [0.0, 0.0, 1.0], system.length)


def _in_axes(plane: Plane, bound: PrimitiveSet) -> Array:
    reference = np.concatenate([rotation_matrix(plane.reference), np.eye(3)[None]])
    return (plane.axes.T @ reference[bound.body] @ bound.local[..., None])[..., 0]


def tilted_bushings(plane: Plane, bushings: Bushings) -> Integers:
    """Return the numbers of the bushings whose frames are not turned against each other about the normal alone."""
    turned = _relative(plane, bushings)
    return np.flatnonzero(np.abs(turned[:, 2, :2]).max(axis=-1, initial=0.0) > THRESHOLDS.rounding)


def bushings_in_plane(plane: Plane, bushings: Bushings) -> dict[str, Array]:
    """Return all bushings in the plane, of which none may be tilted, by name: `origin` (B, 2, 2), and `turn` (B, 2, 2,
    2) from the frames to the bodies' planar axes; `stiffness`, `damping` (B, 3, 3) and `preload` (B, 3) of two
    components and an angle; `map` (B, 6, 3) from these to all six."""
    origin = _reference(plane, bushings) @ bushings.origin[..., None]
    ends = (plane.axes.T @ origin)[..., 0]
    depth = ends[..., 2] + np.append(plane.depth, 0.0)[bushings.body]
    first = np.swapaxes(_frames(plane, bushings)[:, 0], -1, -2) @ plane.axes  # columns e1, e2, n in frame 1
    apart = np.zeros((bushings.size, 6), like=like_of(first, depth))
    apart[:, :3] = first[..., 2] * (depth[:, 1] - depth[:, 0])[:, None]
    B = np.zeros((bushings.size, 6, 3), like=first)
    B[:, :3, :2], B[:, 3:, 2] = first[..., :2], first[..., 2]
    transposed = np.swapaxes(B, -1, -2)
    left = bushings.preload[..., None] - bushings.stiffness @ apart[..., None]
    relative = _relative(plane, bushings)[:, :2, :2]
    turn = np.stack([np.broadcast_to(np.eye(2), relative.shape), relative], axis=1)
    return {
        "origin": ends[..., :2],
        "turn": turn,
        "stiffness": transposed @ bushings.stiffness @ B,
        "damping": transposed @ bushings.damping @ B,
        "preload": (transposed @ left)[..., 0],
        "map": B,
    }


def _reference(plane: Plane, bushings: Bushings) -> Array:
    """Return the orientations (B, 2, 3, 3) of the bodies at angle zero."""
    return np.concatenate([rotation_matrix(plane.reference), np.eye(3)[None]])[bushings.body]


def _frames(plane: Plane, bushings: Bushings) -> Array:
    """Return the orientations (B, 2, 3, 3) of the bushings' frames where the bodies are at angle zero."""
    turned: Array = _reference(plane, bushings) @ rotation_matrix(bushings.turn)
    return turned


def _relative(plane: Plane, bushings: Bushings) -> Array:
    """Return the rotations (B, 3, 3) from frame 1 to frame 2 where the bodies are at angle zero, in the axes of the
    plane."""
    frames = _frames(plane, bushings)
    relative: Array = plane.axes.T @ frames[:, 1] @ np.swapaxes(frames[:, 0], -1, -2) @ plane.axes
    return relative
