"""Joints of a scene that measure tendons: ropes, telescopes, and massless sliders that follow a sum of coordinates.

Each is made once, when something first acts along the tendon.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import field, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Place
from mbproj.formats.chains import EXACT, Coordinates
from mbproj.formats.mechanism import Connection, ImportedBody, ImportedMechanism, ImportedNames, Quantity
from mbproj.formats.mjcf.compiled import CompiledMjcf
from mbproj.formats.mjcf.joints import HINGE, SLIDE, Called, joint_name
from mbproj.scene.blocks.ropes import MOST_NODES
from mbproj.scene.records import GROUND

# --- The paths of tendons over sites, pulleys, spheres and cylinders, as a rope of a scene runs -----------------------
# Points and circles.
# A scene's rope has a plane, MuJoCo's tendon has none. They are the same where all bodies that the tendon touches
# next to a circle move in that plane.


#: Two places of a path on one body are the same where they are nearer to each other than this, in m.
ONE_PLACE = 1e-12


class Spot(NamedTuple):
    """A place of a path on the body `number` of the model: a global point, or the centre of a circle that the path
    bends around. `shape` is the number of the circle's geom."""

    number: int
    point: Array
    radius: float = 0.0
    left: bool = True
    shape: int = -1


@dataclass(frozen=True, eq=False)
class TendonBranch:
    """A part of a tendon between pulleys, whose length counts with a weight. It has its spots and its `length` at the
    start, the normal (3,) of its circles, and the body that carries them. `wrong` is the reason why no rope can run so.
    `passed` are the shapes that it does not touch."""

    weight: float
    spots: Sequence[Spot]
    length: float
    normal: Array | None = None
    carrier: int = 0
    wrong: str = ""
    passed: Sequence[str] = ()


def is_path(compiled: CompiledMjcf, number: int) -> bool:
    """Whether a tendon goes over sites, and is no sum of joint coordinates."""
    import mujoco

    first = int(compiled.model.tendon_adr[number])
    return int(compiled.model.wrap_type[first]) != int(mujoco.mjtWrap.mjWRAP_JOINT)


def branches_of(compiled: CompiledMjcf, called: Called, number: int) -> list[TendonBranch]:
    """The branches of a tendon over sites at the pose of the start."""
    divided = _divided(compiled, number)
    return [_branch(compiled, called, weight, items) for weight, items in divided if len(items) > 1]


class _Item(NamedTuple):
    """A site, or a shape with its side site (-1: none) and the points (2, 3) at which the tendon meets and leaves it;
    None where it does not."""

    site: int
    shape: int
    side: int
    touches: Array | None


def _divided(compiled: CompiledMjcf, number: int) -> Iterator[tuple[float, list[_Item]]]:
    """Yield the weight of each branch, and the sites and shapes over which it runs."""
    import mujoco

    model, data, of = compiled.model, compiled.data, mujoco.mjtWrap
    first = int(model.tendon_adr[number])
    at = int(data.ten_wrapadr[number])
    objects, points = data.wrap_obj.ravel(), data.wrap_xpos.reshape(-1, 3)
    weight, items = 1.0, list[_Item]()
    for each in range(first, first + int(model.tendon_num[number])):
        kind, what = int(model.wrap_type[each]), int(model.wrap_objid[each])
        if kind == int(of.mjWRAP_PULLEY):
            yield weight, items
            weight, items, at = 1.0 / float(model.wrap_prm[each]), [], at + 1
        elif kind == int(of.mjWRAP_SITE):
            items.append(_Item(what, -1, -1, None))
            at += 1
        else:
            met = int(objects[at]) == what
            side = round(float(model.wrap_prm[each]))
            items.append(_Item(-1, what, side, np.array(points[at : at + 2]) if met else None))
            at += 2 if met else 0
    yield weight, items


def _branch(compiled: CompiledMjcf, called: Called, weight: float, items: list[_Item]) -> TendonBranch:
    model, data = compiled.model, compiled.data
    passed = [_called(compiled, each) for each in items if each.shape >= 0 and each.touches is None]
    on_path = [each for each in items if each.shape < 0 or each.touches is not None]
    sites = [Spot(int(model.site_bodyid[each.site]), np.array(data.site_xpos[each.site])) for each in on_path]
    circles = [at for at, each in enumerate(on_path) if each.shape >= 0]
    if not circles:
        length = sum(float(np.linalg.norm(end.point - start.point)) for start, end in pairwise(sites))
        return TendonBranch(weight, _without_repeats(called, sites), length, passed=passed)
    axes = [_axis(compiled, on_path[at], sites[at - 1].point, sites[at + 1].point) for at in circles]
    normal = axes[0]
    carrier = int(model.geom_bodyid[on_path[circles[0]].shape])
    for at, axis in zip(circles, axes, strict=True):
        circle, beside = on_path[at], (sites[at - 1], sites[at + 1])
        wrong = _inside(compiled, circle) or _out_of_plane(compiled, circle, beside, normal, axis, carrier)
        if wrong:
            return TendonBranch(weight, sites, 0.0, wrong=wrong, passed=passed)
        sites[at] = _circle(compiled, circle, beside, normal)
    length = _length(on_path, sites, normal)
    return TendonBranch(weight, _without_repeats(called, sites), length, normal, carrier, passed=passed)


def _called(compiled: CompiledMjcf, item: _Item) -> str:
    return compiled.name("geom", item.shape) or f"geom {item.shape}"


def _length(on_path: list[_Item], spots: list[Spot], normal: Array) -> float:
    """The length of a path in m, with the arcs on its circles, each less than a turn."""
    total, last = 0.0, spots[0].point
    for item, spot in zip(on_path, spots, strict=True):
        first, second = (spot.point, spot.point) if item.touches is None else item.touches
        total += float(np.linalg.norm(first - last))
        if item.touches is not None:
            start, end = first - spot.point, second - spot.point
            angle = float(np.arctan2(np.cross(start, end) @ normal, start @ end))
            total += spot.radius * (angle if spot.left else -angle) % (2.0 * np.pi * spot.radius)
        last = second
    return total


def _without_repeats(called: Called, spots: list[Spot]) -> list[Spot]:
    """The spots without points that are at the place of the point before, on the same body."""
    distinct = spots[:1]
    for spot in spots[1:]:
        last = distinct[-1]
        same = called[spot.number] == called[last.number] and not (spot.radius or last.radius)
        if not (same and np.linalg.norm(spot.point - last.point) < ONE_PLACE):
            distinct.append(spot)
    return distinct


def _axis(compiled: CompiledMjcf, item: _Item, before: Array, after: Array) -> Array:
    """The unit normal of the plane in which the tendon bends around a shape."""
    if _is_cylinder(compiled, item):
        return np.array(compiled.data.geom_xmat[item.shape].reshape(3, 3)[:, 2])
    assert item.touches is not None
    centre = compiled.data.geom_xpos[item.shape]
    arms = [before - centre, after - centre, *(point - centre for point in item.touches)]
    normals = [np.cross(one, other) for at, one in enumerate(arms) for other in arms[at + 1 :]]
    best = max(normals, key=lambda each: float(np.linalg.norm(each)))
    return np.asarray(best / np.linalg.norm(best))


def _inside(compiled: CompiledMjcf, item: _Item) -> str:
    """The reason why no rope runs so, where the side site is inside of a shape, which keeps the tendon inside; else
    ""."""
    if item.side < 0:
        return ""
    data, model = compiled.data, compiled.model
    arm = data.geom_xmat[item.shape].reshape(3, 3).T @ (data.site_xpos[item.side] - data.geom_xpos[item.shape])
    arm = arm[:2] if _is_cylinder(compiled, item) else arm
    return (
        f"it runs inside of '{_called(compiled, item)}'" if np.linalg.norm(arm) < model.geom_size[item.shape][0] else ""
    )


def _out_of_plane(
    compiled: CompiledMjcf, item: _Item, beside: tuple[Spot, Spot], normal: Array, axis: Array, carrier: int
) -> str:
    """The reason why no rope runs so, where the tendon, or the motion of a body that it touches, leaves the plane with
    this normal; else ""."""
    model, data = compiled.model, compiled.data
    name = _called(compiled, item)
    if np.linalg.norm(np.cross(normal, axis)) > EXACT:
        return f"its shapes lie in several planes, that of '{name}' too"
    heights = [float(normal @ spot.point) for spot in beside]
    if not _is_cylinder(compiled, item):
        heights.append(float(normal @ data.geom_xpos[item.shape]))
    if max(heights) - min(heights) > EXACT:
        return f"it runs around '{name}' along a helix, and a rope in a plane"
    for number in (int(model.geom_bodyid[item.shape]), *(spot.number for spot in beside)):
        if not _stays(model, data, number, carrier, normal):
            return f"what it touches moves out of the plane of '{name}', and a rope stays in it"
    return ""


def _is_cylinder(compiled: CompiledMjcf, item: _Item) -> bool:
    import mujoco

    return int(compiled.model.geom_type[item.shape]) == int(mujoco.mjtGeom.mjGEOM_CYLINDER)


def _stays(model: Any, data: Any, one: int, other: int, normal: Array) -> bool:
    """Whether the relative motion of two bodies is in the plane: turns about its normal, and slides normal to that."""
    for joint in above(model, one) ^ above(model, other):
        kind, axis = int(model.jnt_type[joint]), data.xaxis[joint]
        if kind not in (HINGE, SLIDE):
            return False
        if (np.linalg.norm(np.cross(axis, normal)) if kind == HINGE else abs(axis @ normal)) > EXACT:
            return False
    return True


def above(model: Any, number: int) -> set[int]:
    """The numbers of the joints between a body and the ground."""
    joints: set[int] = set()
    while number:
        first = int(model.body_jntadr[number])
        joints |= set(range(first, first + int(model.body_jntnum[number])))
        number = int(model.body_parentid[number])
    return joints


def _circle(compiled: CompiledMjcf, item: _Item, beside: tuple[Spot, Spot], normal: Array) -> Spot:
    """The circle of a shape in the plane of the tendon, with the side to which the tendon bends."""
    model, data = compiled.model, compiled.data
    assert item.touches is not None
    centre = np.array(data.geom_xpos[item.shape])
    centre += normal * (normal @ (beside[0].point - centre))
    first = item.touches[0]
    left = float(np.cross(first - centre, first - beside[0].point) @ normal) > 0.0
    return Spot(int(model.geom_bodyid[item.shape]), centre, float(model.geom_size[item.shape][0]), left, item.shape)


# --- Joints of a scene that measure tendons ---------------------------------------------------------------------------


#: The keys of a joint that fix or limit its length; a new choice removes the others.
LENGTH_KEYS = ("free", "slack", "length", "stiffness", "limits")


class MeasuringCoordinate(NamedTuple):
    """A coordinate s of a joint that determines the length of a tendon: `ratio` s + `constant`."""

    joint: str
    coordinate: str
    ratio: float
    constant: float


class TendonSum(NamedTuple):
    """A tendon's length as Σ weight × coordinate + `constant`; the weights are by the names of joint coordinates."""

    weights: dict[str, float]
    constant: float


@dataclass(frozen=True, eq=False)
class ModelTendons:
    """The tendons of a model. `names` are those of the scene's joints, `joint_names` those of the joints that were
    made for parts of tendons. `acting` are the numbers of the tendons that have a counterpart in the scene."""

    compiled: CompiledMjcf
    mechanism: ImportedMechanism
    called: Called
    coordinates: Coordinates
    names: ImportedNames
    joint_names: dict[tuple[str, int, int], str] = field(default_factory=dict)
    known_branches: dict[int, list[TendonBranch]] = field(default_factory=dict)
    acting: set[int] = field(default_factory=set)

    def name(self, number: int) -> str:
        """The name of a tendon."""
        return self.compiled.name("tendon", number) or f"tendon_{number}"

    def place(self, number: int) -> Place | None:
        """The place of a tendon."""
        return self.compiled.place_in("tendon", self.name(number))

    def length(self, number: int) -> float:
        """The length of a tendon at the start, in m."""
        return float(self.compiled.data.ten_length[number])

    def branches(self, number: int) -> list[TendonBranch]:
        """The branches of a tendon over sites whose lengths may change; [] for another tendon."""
        return [each for each in self._every(number) if each.wrong or self._moves(each)]

    def constant(self, number: int) -> float:
        """The constant part of the length of a tendon over sites, in m."""
        every = self._every(number)
        return sum(each.weight * each.length for each in every if not (each.wrong or self._moves(each)))

    def passed(self, number: int) -> list[str]:
        """The names of shapes that a tendon may run around, but does not touch at the start."""
        return [name for each in self._every(number) for name in each.passed]

    def bends(self, number: int) -> bool:
        """Whether a tendon runs around shapes."""
        return any(each.normal is not None for each in self.branches(number))

    def _every(self, number: int) -> list[TendonBranch]:
        if number not in self.known_branches:
            over_sites = is_path(self.compiled, number)
            self.known_branches[number] = branches_of(self.compiled, self.called, number) if over_sites else []
        return self.known_branches[number]

    def wrong(self, number: int) -> str:
        """The reason why no rope can run as the tendon does; "" where one can."""
        for branch in self.branches(number):
            if branch.wrong:
                return branch.wrong
            if len(branch.spots) > MOST_NODES:
                return f"it runs over {len(branch.spots)} places, and a rope over {MOST_NODES} at most"
        return ""

    def is_constant(self, number: int) -> bool:
        """Whether no motion changes a tendon's length: all its sites are on one body, or on bodies that stay."""
        return is_path(self.compiled, number) and not self.branches(number)

    def joints(self, number: int) -> dict[int, float]:
        """The weights of joints, by number, in a tendon that is their sum; {} for a tendon over sites."""
        model = self.compiled.model
        if is_path(self.compiled, number):
            return {}
        first = int(model.tendon_adr[number])
        every = range(first, first + int(model.tendon_num[number]))
        return {int(model.wrap_objid[at]): float(model.wrap_prm[at]) for at in every}

    def coordinate(self, joint: int) -> tuple[str, str] | None:
        """The joint and the coordinate of the scene that a joint of the model became; None where it has none."""
        child = self.called[int(self.compiled.model.jnt_bodyid[joint])]
        return self.coordinates.get(joint_name(self.compiled, joint, child))

    def line(self, number: int) -> tuple[tuple[str, str], Array] | None:
        """The bodies that a straight tendon between two sites joins, and the points (2, 3) in their axes; None for
        others."""
        branches = self.branches(number)
        if len(branches) != 1 or branches[0].weight != 1.0 or self.constant(number):
            return None
        return self.ends(branches[0])

    def ends(self, branch: TendonBranch) -> tuple[tuple[str, str], Array] | None:
        """The bodies that a straight branch between two spots joins, and the points (2, 3) in their axes; else None."""
        if branch.wrong or len(branch.spots) != 2:
            return None
        first, last = branch.spots
        points = [self.mechanism.part(self.called[spot.number]).local(spot.point) for spot in branch.spots]
        return (self.called[first.number], self.called[last.number]), np.array(points)

    def rope(self, number: int, at: int) -> str:
        """The name of the rope that measures a branch. Its length is free, until `say_length` gives other keys."""
        self.acting.add(number)
        if ("rope", number, at) in self.joint_names:
            return self.joint_names["rope", number, at]
        branch = self.branches(number)[at]
        name = self.joint_names["rope", number, at] = self._free_name(number, at, "rope")
        normal = _path_normal(branch, self._turns(branch)) if branch.normal is None else branch.normal
        keys: dict[str, Any] = {"path": [self._spot(spot) for spot in branch.spots], "normal": normal}
        if self.called[branch.carrier] != GROUND:
            keys["frame"] = self.called[branch.carrier]
        self.mechanism.joints[name] = Connection(name, "rope", keys={**keys, "free": True}, place=self.place(number))
        self.mechanism.tree.add(name)
        return name

    def say_length(self, joint: str, **keys: Any) -> None:
        """Set the keys of a measuring joint that fix or limit its length."""
        old = self.mechanism.joints[joint]
        others = {key: value for key, value in old.keys.items() if key not in LENGTH_KEYS}
        self.mechanism.joints[joint] = replace(old, keys={**others, **keys})

    def add_key(self, joint: str, key: str, value: Any) -> None:
        """Set another key of a joint."""
        old = self.mechanism.joints[joint]
        self.mechanism.joints[joint] = replace(old, keys={**old.keys, key: value})

    def is_held(self, number: int) -> bool:
        """Whether an equality fixes the length of the tendon's rope."""
        name = self.joint_names.get(("rope", number, 0), "")
        return "length" in self.mechanism.joints[name].keys if name else False

    def measured(self, number: int, *, dry: bool = False) -> MeasuringCoordinate | str:
        """A coordinate that determines a tendon's length, or the reason why there is none. With `dry` it must be one on
        which dry friction may act."""
        if wrong := self.wrong(number):
            return wrong
        branches = self.branches(number)
        self.acting.add(number)
        if len(branches) == 1 and self.ends(branches[0]):
            return MeasuringCoordinate(
                self._telescopes(number, 0)[0][0], "length", branches[0].weight, self.constant(number)
            )
        if len(branches) == 1 and (self.bends(number) or not dry):
            if dry:
                return "a rope has no dry friction"
            return MeasuringCoordinate(self.rope(number, 0), "length", branches[0].weight, self.constant(number))
        if self.bends(number):
            return "it has several branches, of which some bend around shapes"
        return self.slider(number)

    def sum(self, number: int) -> TendonSum | str:
        """The coordinates whose sum is a tendon's length, and which couplers accept; or the reason why there are
        none."""
        if wrong := self.wrong(number):
            return wrong
        if not is_path(self.compiled, number):
            by_joint = {joint: self.coordinate(joint) for joint in self.joints(number)}
            if None in by_joint.values():
                return "it goes over a joint that has no coordinate of its own"
            weights = {".".join(by_joint[joint] or ()): weight for joint, weight in self.joints(number).items()}
            self.acting.add(number)
            return TendonSum(weights, self.length(number))
        branches = self.branches(number)
        self.acting.add(number)
        if self.bends(number):
            return "the length of a rope around shapes cannot be coupled"
        weights, constant = {}, self.length(number)
        for at, branch in enumerate(branches):
            for name, length in self._telescopes(number, at):
                weights[f"{name}.length"] = branch.weight
                constant -= branch.weight * length
        return TendonSum(weights, constant)

    def slider(self, number: int) -> MeasuringCoordinate | str:
        """A massless body on a slide that a coupler moves: its displacement is the change of the tendon's length since
        the start. Or the reason why there is none."""
        if ("slider", number, 0) in self.joint_names:
            return MeasuringCoordinate(self.joint_names["slider", number, 0], "displacement", 1.0, self.length(number))
        coupled = self.sum(number)
        if isinstance(coupled, str):
            return coupled
        name = self.name(number)
        joint, row = self.names.unused(f"{name}_slider"), self.names.unused(f"{name}_sum")
        self.joint_names["slider", number, 0] = joint
        body = ImportedNames(frozenset([*self.mechanism.parts, GROUND])).unused(joint)
        zero, axis, place = np.zeros(3), self._in_plane(number), self.place(number)
        velocity = float(self.compiled.data.ten_velocity[number]) * axis
        self.mechanism.insert(ImportedBody(body, 0.0, np.zeros((3, 3)), zero, np.eye(3), place, velocity), "")
        self.mechanism.join(joint, "prismatic", (GROUND, body), zero, axis, place=place)
        of = {**coupled.weights, f"{joint}.displacement": -1.0}
        self.mechanism.joints[row] = Connection(row, "coupler", keys={"of": of}, place=place)
        self.mechanism.followers[row] = (body, joint)
        return MeasuringCoordinate(joint, "displacement", 1.0, self.length(number))

    def _telescopes(self, number: int, at: int) -> list[tuple[str, float]]:
        """The telescopes for the straight parts of a branch between different bodies, with their lengths in m."""
        branch, telescopes = self.branches(number)[at], []
        for part, (start, end) in enumerate(pairwise(branch.spots), 1):
            bodies = (self.called[start.number], self.called[end.number])
            if bodies[0] == bodies[1]:
                continue
            key = (f"line_{part}", number, at)
            if key not in self.joint_names:
                name = self._free_name(number, at, key[0])
                self.joint_names[key] = name
                ends = [self.mechanism.part(body) for body in bodies]
                points = np.array([end.local(spot.point) for end, spot in zip(ends, (start, end), strict=True)])
                joint = Connection(name, "telescope", bodies, points, place=self.place(number))
                self.mechanism.joints[name] = joint
                self.mechanism.tree.add(name)
            telescopes.append((self.joint_names[key], float(np.linalg.norm(end.point - start.point))))
        return telescopes

    def _turns(self, branch: TendonBranch) -> list[Array]:
        """The global axes of the hinges between the bodies of a branch and the ground."""
        model, data = self.compiled.model, self.compiled.data
        joints = sorted({joint for spot in branch.spots for joint in above(model, spot.number)})
        return [np.array(data.xaxis[joint]) for joint in joints if int(model.jnt_type[joint]) == HINGE]

    def _in_plane(self, number: int) -> Array:
        """A direction for a slide, in the plane of the motion where there is one: that of the first part of a path. For
        a sum of joints it is the global axis most normal to the axis of the first joint."""
        for branch in self.branches(number):
            way = branch.spots[1].point - branch.spots[0].point
            return np.asarray(way / np.linalg.norm(way))
        axis = self.compiled.data.xaxis[next(iter(self.joints(number)))]
        return np.eye(3)[int(np.argmin(np.abs(axis)))]

    def _spot(self, spot: Spot) -> dict[str, Any]:
        body = self.called[spot.number]
        at = self.mechanism.part(body).local(spot.point)
        place: Any = at if body == GROUND else {body: at}
        if not spot.radius:
            return {"point": body, "at": place}
        side = "left" if spot.left else "right"
        return {"sheave": body, "at": place, "radius": Quantity(spot.radius, "m"), "bends": side}

    def _moves(self, branch: TendonBranch) -> bool:
        return len({self.called[spot.number] for spot in branch.spots}) > 1

    def _free_name(self, number: int, at: int, what: str) -> str:
        """A free name for a joint of a tendon's branch; the only rope of a tendon has the tendon's name."""
        name = self.name(number)
        if len(self.branches(number)) > 1:
            name = f"{name}_{at + 1}"
        return self.names.unused(name if what == "rope" else f"{name}_{what}")


def _path_normal(branch: TendonBranch, turns: Sequence[Array]) -> Array:
    """A normal for a path without circles: any direction that is not along a part of it. An axis of a hinge comes
    first, since the mechanism may be planar about it."""
    ways = np.array([end.point - start.point for start, end in pairwise(branch.spots)])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    able = [*turns, *np.eye(3)]
    along = [float(np.abs(ways @ normal).max()) for normal in able]
    best = next((at for at, size in enumerate(along) if size < EXACT), int(np.argmin(along)))
    return np.asarray(able[best])
