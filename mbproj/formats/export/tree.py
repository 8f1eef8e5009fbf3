"""The tree of a scene's bodies that formats of robots need: the joints of the tree, and those that close its loops."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field, replace

import numpy as np
from numpy.polynomial import Polynomial

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.equations.assembly.assemble import coordinates
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import attached, attached_velocity, body_rates, pose_of, twist_of
from mbproj.formats.geometry import IDENTITY, Frame, from_quaternion
from mbproj.formats.mechanism import Same
from mbproj.joints.table import JOINTS, thread
from mbproj.linear.equilibrium.start import start_state
from mbproj.model.compile.frames import SYMBOLS, local_frames, poses_of
from mbproj.model.euler_parameters import product
from mbproj.scene.blocks.elements import SPRINGS
from mbproj.scene.records import GROUND, DryFriction, Joint, JointForce, Kind, Law, Limit, OfBody, Pair
from mbproj.scene.scene import Scene

# --- The start of a scene in the form that other formats need ---------------------------------------------------------
# Poses and velocities of its bodies, frames of its joints.


@dataclass(frozen=True, eq=False)
class Start:
    """The assembled start of a scene: `poses` of bodies and the ground; `velocities` (3,) of their centres of mass and
    angular velocities `turning` (3,), both global. `values` and `rates` are joint coordinates and their rates by name.
    `file_poses` are those in the scene's file. `frames` are the points and axes of each joint by symbol, in the axes of
    its bodies."""

    poses: Mapping[str, Frame]
    velocities: Mapping[str, Array]
    turning: Mapping[str, Array]
    values: Mapping[str, float]
    rates: Mapping[str, float]
    file_poses: Mapping[str, Frame]
    frames: Mapping[str, Mapping[str, Array]]

    def point(self, body: str, local: Array) -> Array:
        """The global place of a point that is given from the body's centre of mass, in its axes."""
        pose = self.poses[body]
        return np.asarray(pose.position + pose.rotation @ local)

    def of_joint(self, joint: Joint, symbol: str) -> Array:
        """A joint's point or axis, "p1", "x1", .. "z2", in global axes at the start."""
        body, local = joint.bodies[int(symbol[1]) - 1], self.frames[joint.name][symbol]
        return self.point(body, local) if symbol[0] == "p" else np.asarray(self.poses[body].rotation @ local)

    def ends(self, bodies: tuple[str, str], points: Pair) -> list[Array]:
        """The points of two bodies, each from its body's centre of mass, in that body's axes."""
        both = zip(bodies, (points.first, points.second), strict=True)
        return [self.in_body_axes(OfBody(body, point, points.local)) for body, point in both]

    def in_body_axes(self, point: OfBody) -> Array:
        """The point from its body's centre of mass, in that body's axes."""
        if point.local:
            return np.array(point.vector)
        pose = self.file_poses[point.body]
        return np.asarray(pose.rotation.T @ (np.array(point.vector) - pose.position))

    @property
    def moves(self) -> bool:
        """Whether any body has a velocity at the start."""
        return any(np.any(each) for each in (*self.velocities.values(), *self.turning.values()))


def start_of(scene: Scene) -> Start:
    """The start of a scene. Raises InputError, and the errors of assembly, where it has none."""
    system = compile_system(scene)
    state = start_state(scene, system)
    pose, carrier = pose_of(state.q), system.body_carrier
    twist = twist_of(pose, state.v)
    points = np.ones(len(carrier))
    position = attached(pose, carrier, system.body_offset, points)
    velocity = attached_velocity(twist, carrier, system.body_offset, points)
    omega = np.einsum("nij,nj->ni", pose.rotation, body_rates(pose, twist))[carrier]
    turned = product(pose.orientation[carrier], system.body_turn)
    names = [body.name for body in scene.bodies]
    poses = {
        name: Frame(np.array(at), from_quaternion(np.array(turn)))
        for name, at, turn in zip(names, position, turned, strict=True)
    }
    values, rates = coordinates(system, state.q, state.v)
    file_poses = poses_of(scene)
    joints = [joint for joint in scene.joints if joint.couples is None]
    framed = dict(zip([joint.name for joint in joints], local_frames(joints, file_poses), strict=True))
    return Start(
        poses | {GROUND: IDENTITY},
        dict(zip(names, np.asarray(velocity), strict=True)) | {GROUND: np.zeros(3)},
        dict(zip(names, np.asarray(omega), strict=True)) | {GROUND: np.zeros(3)},
        dict(zip(system.names.coordinates, values.tolist(), strict=False)),
        dict(zip(system.names.coordinates, rates.tolist(), strict=False)),
        {name: Frame(*each) for name, each in file_poses.items()},
        {name: dict(zip(SYMBOLS, each, strict=True)) for name, each in framed.items()},
    )


# --- The tree of a scene's bodies that formats of robots need ---------------------------------------------------------


#: The joints that may be in a tree; the first of them cannot be written as a loop in formats of robots.
IN_TREE = (
    *("prismatic", "cylindrical", "planar", "universal", "screw", "point_on_line", "point_in_plane"),
    *("fixed", "revolute", "spherical"),
)


@dataclass(frozen=True, eq=False)
class TreeFreedom:
    """A freedom of a joint: a "hinge", a "slide", a "ball", or all six of a "free" body. `name` is that of the joint
    where it has one coordinate, else it ends with that of the coordinate. `point` and unit `axis` are global at the
    start. `coordinate` is "joint.angle", with its value and its rate; "" where the scene has none."""

    kind: str
    name: str
    point: Array
    axis: Array = field(default_factory=lambda: np.zeros(3))
    coordinate: str = ""
    value: float = 0.0
    rate: float = 0.0


@dataclass(frozen=True, eq=False)
class TreeBranch:
    """A body, its carrier, and the freedoms between them, in order from the carrier on."""

    body: str
    carrier: str
    freedoms: tuple[TreeFreedom, ...]
    joint: str = ""


@dataclass(frozen=True, eq=False)
class Tree:
    """The branches from the ground on, each after its carrier's, and the joints that close loops."""

    branches: tuple[TreeBranch, ...]
    loops: tuple[Joint, ...]

    def carried(self, body: str) -> Iterator[TreeBranch]:
        """The branches that a body carries."""
        return (branch for branch in self.branches if branch.carrier == body)

    @property
    def freedoms(self) -> dict[str, TreeFreedom]:
        """The freedoms that have a coordinate, by its name."""
        return {each.coordinate: each for branch in self.branches for each in branch.freedoms if each.coordinate}


def tree_of(scene: Scene, start: Start, able: tuple[str, ...] = IN_TREE) -> Tree:
    """A tree of joints of the types in `able`. It prefers joints on whose coordinates something acts."""
    acted = _acted_on(scene)
    joints = [joint for joint in scene.joints if JOINTS[joint.type].frame != "joints"]
    wanted = sorted(
        (joint for joint in joints if joint.type in able),
        key=lambda joint: (joint.name not in acted, able.index(joint.type)),
    )
    group = {body.name: body.name for body in scene.bodies} | {GROUND: GROUND}
    chosen: dict[str, Joint] = {}
    for joint in wanted:
        first, second = (group[body] for body in joint.bodies)
        if first != second:
            chosen[joint.name] = joint
            group = {body: first if each == second else each for body, each in group.items()}
    tree_joints = [joint for joint in joints if joint.name in chosen]
    branches = tuple(_branches(scene, start, tree_joints))
    return Tree(branches, tuple(joint for joint in joints if joint.name not in chosen))


def _acted_on(scene: Scene) -> set[str]:
    """The names of the joints that should be in the tree: something acts on their coordinates, or couples them."""
    joints = {force.joint for force in scene.forces if isinstance(force, JointForce)}
    joints |= {motion.joint for motion in scene.motions}
    for joint in scene.joints:
        if joint.reflected_inertia or joint.limits:
            joints.add(joint.name)
        if joint.couples is not None:
            joints |= set(joint.couples.joints)
    return joints


def _branches(scene: Scene, start: Start, joints: list[Joint]) -> Iterator[TreeBranch]:
    done, waiting = {GROUND}, [GROUND]
    for begin in [GROUND, *(body.name for body in scene.bodies)]:
        if begin not in done:
            pose = start.poses[begin]
            done.add(begin)
            waiting.append(begin)
            yield TreeBranch(begin, GROUND, (TreeFreedom("free", f"{begin}_free", pose.position),))
        while waiting:
            carrier = waiting.pop(0)
            for joint in joints:
                if carrier not in joint.bodies:
                    continue
                back = joint.bodies[1] == carrier
                body = joint.bodies[0] if back else joint.bodies[1]
                if body not in done:
                    done.add(body)
                    waiting.append(body)
                    yield TreeBranch(body, carrier, freedoms(joint, start, back), joint.name)


def freedoms(joint: Joint, start: Start, back: bool) -> tuple[TreeFreedom, ...]:
    """The freedoms of the second body of a joint against the first, or with `back` of the first against the second.

    Back reverses each axis, and their order too: the inverse of R₁(θ₁) R₂(θ₂) is R₂(-θ₂) R₁(-θ₁)."""
    point = start.of_joint(joint, "p2")
    kinds = _kinds(joint, start)
    alone = sum(1 for _, coordinate, _ in kinds if coordinate) == 1 and len(kinds) == 1
    free = []
    for kind, coordinate, axis in kinds:
        name = f"{joint.name}.{coordinate}" if coordinate else ""
        called = joint.name if alone or not coordinate else f"{joint.name}_{coordinate}"
        value, rate = start.values.get(name, 0.0), start.rates.get(name, 0.0)
        free.append(TreeFreedom(kind, called, point, -axis if back else axis, name, value, rate))
    return tuple(reversed(free) if back else free)


def _kinds(joint: Joint, start: Start) -> list[tuple[str, str, Array]]:
    """The (kind, coordinate, axis) of each freedom of a joint, from the first body on."""
    x, y, z, z2 = (start.of_joint(joint, symbol) for symbol in ("x1", "y1", "z1", "z2"))
    return {
        "fixed": [],
        "revolute": [("hinge", "angle", z)],
        "prismatic": [("slide", "displacement", z)],
        "spherical": [("ball", "", np.zeros(3))],
        "universal": [("hinge", "angle_1", z), ("hinge", "angle_2", z2)],
        "cylindrical": [("slide", "displacement", z), ("hinge", "angle", z)],
        "screw": [("slide", "displacement", z), ("hinge", "angle", z)],
        "planar": [("slide", "displacement_x", x), ("slide", "displacement_y", y), ("hinge", "angle", z)],
        "point_on_line": [("slide", "displacement", z), ("ball", "", np.zeros(3))],
        "point_in_plane": [("slide", "displacement_x", x), ("slide", "displacement_y", y), ("ball", "", np.zeros(3))],
    }[joint.type]


def without_massless(scene: Scene, tree: Tree, named: Mapping[str, int]) -> Tree:
    """The tree without massless bodies between two others: each gives its freedoms to the body that it carries. Bodies
    that loops, forces or markers name stay; `named` counts these names."""
    massless = {body.name for body in scene.bodies if not body.mass and not np.any(body.inertia)}
    branches = {branch.body: branch for branch in tree.branches}
    for name in massless:
        carried = [branch for branch in branches.values() if branch.carrier == name]
        inner = branches[name]
        single = {each.kind for branch in (inner, *carried) for each in branch.freedoms} <= {"hinge", "slide"}
        if len(carried) == 1 and single and not named.get(name):
            (outer,) = carried
            joined = (*inner.freedoms, *outer.freedoms)
            branches[outer.body] = replace(outer, carrier=inner.carrier, freedoms=joined)
            del branches[name]
    return replace(tree, branches=tuple(branches.values()))


def down(tree: Tree, body: str) -> list[TreeBranch]:
    """The branches that a body carries, directly or not, in the order of the file."""
    branches = []
    for branch in tree.carried(body):
        branches += [branch, *down(tree, branch.body)]
    return branches


def name_counts(scene: Scene) -> Counter[str]:
    """The number of loops, forces and markers that name each body. A named body is needed, and cannot be removed."""
    names: Counter[str] = Counter(marker.body for marker in scene.markers)
    for force in scene.forces:
        names.update(getattr(force, "bodies", ()))
        names.update([body for body in [getattr(force, "body", None)] if body])
        for end in ("first", "second", "point", "location"):
            if hasattr(getattr(force, end, None), "body"):
                names[getattr(force, end).body] += 1
    joints: Counter[str] = Counter()
    for joint in scene.joints:
        if joint.couples is None:
            joints.update(joint.bodies)
    names.update({name: 1 for name, often in joints.items() if often != 2})
    return names


# --- Springs, dampers, friction, inertias and limits ------------------------------------------------------------------
# The springs, dampers, friction, inertias and limits on joint coordinates, in the form that other formats have.


#: Adds a row to the table: an element, what happens to it, whether the motion is still that of the scene.
Say = Callable[[str, str, Same], None]


def left_out(kind: Kind) -> str:
    """The reason, for the table, why a force that is an element is left out."""
    if kind.type in SPRINGS:
        return "left out: numbers of it change in a run"
    return f"left out: no model has the type {kind.type}"


@dataclass(frozen=True)
class CoordinateLoads:
    """All that acts on one coordinate s, in SI units: F = -stiffness (s - rest) - damping s', a constant dry friction,
    a reflected inertia, and the limit of s."""

    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    dry: float = 0.0
    armature: float = 0.0
    limit: Limit | None = None


def acting_on(scene: Scene, say: Say) -> dict[str, CoordinateLoads]:
    """The forces, inertias and limits on each coordinate, by its name "joint.angle". A force that has no such form gets
    a row of the table."""
    loads: dict[str, CoordinateLoads] = {}
    joints = {joint.name: joint for joint in scene.joints}
    for joint in scene.joints:
        for coordinate, inertia in joint.reflected_inertia.items():
            name = f"{joint.name}.{coordinate}"
            loads[name] = replace(loads.get(name, CoordinateLoads()), armature=inertia)
        for coordinate, limit in joint.limits.items():
            name = f"{joint.name}.{coordinate}"
            loads[name] = replace(loads.get(name, CoordinateLoads()), limit=limit)
    for force in scene.forces:
        if not isinstance(force, JointForce):
            continue
        joint = joints[force.joint]
        if force.element is not None:
            say(f"force '{force.name}'", left_out(force.element), Same.NO)
            continue
        for coordinate, law in force.laws.items():
            if law.function is not None:
                say(f"force '{force.name}'", "left out: its law is a function", Same.NO)
                continue
            name = f"{joint.name}.{coordinate or _only(joint, force.unit)}"
            loads[name] = _with(loads.get(name, CoordinateLoads()), law)
        for coordinate, dry in force.coulomb.items():
            name = f"{joint.name}.{coordinate or _only(joint, dry.unit)}"
            if not constant(dry):
                what = "left out: its dry friction is not one constant force"
                say(f"friction '{force.name}'", what, Same.NO)
                continue
            assert isinstance(dry.sliding, float)
            old = loads.get(name, CoordinateLoads())
            loads[name] = replace(old, dry=old.dry + dry.sliding)
    return loads


def _only(joint: Joint, unit: str | None) -> str:
    """The first coordinate of a joint in a unit (None: any)."""
    units = {name: "rad" if row[0] == "angle" else "m" for name, row in JOINTS[joint.type].coordinates.items()}
    return next(name for name, coordinate_unit in units.items() if unit in (None, coordinate_unit))


def constant(dry: DryFriction) -> bool:
    """Whether a dry friction is one constant force or torque, equal while it slides and while it sticks."""
    smooth = dry.regularised is not None or dry.stribeck_speed is not None
    return dry.bearing is None and not smooth and not dry.varies and dry.static == dry.sliding


def _with(old: CoordinateLoads, law: Law) -> CoordinateLoads:
    """`old` with one more spring and damper: k = Σ kᵢ, and the rest position s where Σ kᵢ (s - sᵢ) = 0."""
    total = old.stiffness + law.stiffness
    moment = old.stiffness * old.rest + law.stiffness * (law.free or 0.0)
    rest = moment / total if total else 0.0
    return replace(old, stiffness=total, rest=rest, damping=old.damping + law.damping)


# --- Couplings of joint coordinates as sums ---------------------------------------------------------------------------
# Σ kᵢ (sᵢ - sᵢ⁰) = f(s₀) - f(s₀⁰), counted from the start, where they hold.


#: A function counts as a polynomial of the fourth degree where it differs from one by less than about this part of its
#: size.
SAME = 1e-12


@dataclass(frozen=True, eq=False)
class CouplingSum:
    """A coupling as a sum: `weights` kᵢ of coordinates by name. `curve` is f(s₀⁰ + d) - f(s₀⁰) as a polynomial of d of
    at most the fourth degree, None where there is no function; `first` is the name of s₀."""

    name: str
    weights: Mapping[str, float]
    first: str = ""
    curve: Polynomial | None = None


def sum_of(joint: Joint, start: Start) -> CouplingSum | None:
    """The sum of a coupling, or of a screw; None where its function is no such polynomial."""
    if joint.type == "screw":
        names = [f"{joint.name}.displacement", f"{joint.name}.angle"]
        return CouplingSum(joint.name, dict(zip(names, thread(joint.parameters["pitch"]).weights, strict=True)))
    assert joint.couples is not None
    of = dict(joint.couples.of)
    first = next(iter(of))
    if joint.couples.function is None:
        return CouplingSum(joint.name, of)
    curve = _polynomial(joint, start.values[first])
    weights = {name: weight for name, weight in of.items() if weight}
    return None if curve is None else CouplingSum(joint.name, weights, first, curve)


def _polynomial(joint: Joint, at: float) -> Polynomial | None:
    """The polynomial f(at + d) - f(at) through five points. None where f leaves it at one of ten others, which span
    more than a turn to both sides: a function with a dwell is no polynomial."""
    from mbproj.functions.standard import Curve

    assert joint.couples is not None and joint.couples.function is not None
    curve = Curve(joint.couples.function)

    def f(d: np.ndarray) -> np.ndarray:
        return np.asarray(curve(at + d)[0].real)

    d, others = np.array([-1.0, -0.5, 0.0, 0.5, 1.0]), np.array([-6.9, -4.1, -2.0, -0.8, -0.3, 0.2, 0.7, 2.0, 3.3, 7.1])
    with np.errstate(all="ignore"):
        values, wanted = f(d) - f(np.zeros(1)), f(others) - f(np.zeros(1))
    if not (np.isfinite(values).all() and np.isfinite(wanted).all()):
        return None
    polynomial = Polynomial.fit(d, values, 4).convert()
    scale = max(1.0, float(np.abs(wanted).max()))
    polynomial = Polynomial(np.where(np.abs(polynomial.coef) < SAME * scale, 0.0, polynomial.coef))
    return polynomial if np.abs(polynomial(others) - wanted).max() <= 100 * SAME * scale else None


def five(curve: Polynomial) -> Array:
    """The coefficients of a polynomial of the fourth degree at most, the constant first, (5,)."""
    coefficients = np.zeros(5)
    coefficients[: len(curve.coef)] = curve.coef
    return coefficients
