"""Planar scenes, and the rows and columns of the equations that planar coordinates have."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from mbproj import Scene
from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.equations.assembly.compiled import compile_system
from mbproj.joints.table import JOINTS
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.euler_parameters import product
from mbproj.model.planar.plane import PlanarSet, Plane
from mbproj.model.planar.reduction import NotPlanar, planar_reduction
from mbproj.model.primitive_set import Binding, PrimitiveSet, bind
from mbproj.model.system import System
from mbproj.scene.fields.rotations import from_matrix
from mbproj.scene.records import Body, Joint, Pair
from tests.support import PARAMETERS, random_body, random_coupling, scene_of

# Mechanisms drawn in a plane of any normal, and some that only look as if they were.

Point = tuple[float, float]
NORMAL = (0.0, 0.0, 1.0)


def turns(seed: int) -> list[np.ndarray]:
    """Axes of planes: the x-y plane, the y-z plane seen from behind, and one of random normal."""
    return [np.eye(3), np.array([[0.0, 0, -1], [0, 1, 0], [1, 0, 0]]), _random_turn(seed), _random_turn(seed + 100)]


def _random_turn(seed: int) -> np.ndarray:
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return turn * np.sign(np.linalg.det(turn))


class Drawing:
    """Places bodies and joints by coordinates in a plane, each body at a depth and in an orientation of its own."""

    def __init__(self, seed: int, turn: np.ndarray | None = None) -> None:
        self.rng = np.random.default_rng(seed)
        self.turn = _random_turn(seed) if turn is None else turn

    def place(self, point: Point, depth: float = 0.7) -> tuple[float, float, float]:
        x, y, z = self.turn @ np.array([*point, depth])
        return float(x), float(y), float(z)

    def direction(self, vector: tuple[float, ...]) -> tuple[float, float, float]:
        return self.place((vector[0], vector[1]), vector[2])

    def body(self, name: str, centre: Point) -> Body:
        position = self.place(centre, float(self.rng.normal()))
        body = random_body(self.rng, name)
        w, x, y, z = product(np.array(from_matrix(self.turn.tolist())), np.array(body.orientation)).tolist()
        return dataclasses.replace(body, position=position, orientation=(w, x, y, z))

    def joint(
        self,
        name: str,
        kind: str,
        bodies: tuple[str, str],
        at: Point,
        to: Point | None = None,
        axes: tuple[tuple[float, ...], ...] = (NORMAL, NORMAL),
        lift: float = 0.0,
    ) -> Joint:
        """A joint at a point, its second point at `to`, which lies higher by `lift`."""
        directions = Pair(self.direction(axes[0]), self.direction(axes[-1]))
        points = Pair(self.place(at), self.place(to or at, 0.7 + lift))
        parameters = {"pitch": PARAMETERS["pitch"]} if kind == "screw" else {}
        own = None if JOINTS[kind].frame == "point" else directions
        return Joint(name, kind, bodies, points, own, parameters=parameters, reaction=JOINTS[kind].merges)

    def scene(self, bodies: list[Body], joints: list[Joint]) -> Scene:
        return scene_of(bodies, joints)


def _chain(d: Drawing) -> Scene:
    joints = [d.joint("A", "revolute", ("ground", "a"), (0, 0)), d.joint("B", "revolute", ("a", "b"), (1, 0.3))]
    return d.scene([d.body("a", (0.5, 0)), d.body("b", (1.5, 0))], joints)


def _branches_of_planar_joints(d: Drawing) -> Scene:
    joints = [
        d.joint("A", "planar", ("ground", "a"), (0, 0)),
        d.joint("B", "revolute", ("a", "b"), (1, 0.3)),
        d.joint("C", "planar", ("a", "c"), (0.2, 0.1)),
    ]
    return d.scene([d.body("a", (0.5, 0)), d.body("b", (1.5, 0)), d.body("c", (0, 2))], joints)


def _loop_of_distances(d: Drawing) -> Scene:
    joints = [
        d.joint("A", "revolute", ("ground", "a"), (0, 0)),
        d.joint("B", "revolute", ("ground", "b"), (2, 0)),
        d.joint("rod", "distance", ("a", "b"), (0.2, 1), (1.9, 1.5)),
    ]
    return d.scene([d.body("a", (0.1, 0.5)), d.body("b", (2, 0.6))], joints)


def _gears(d: Drawing) -> Scene:
    joints = [
        d.joint("A", "revolute", ("ground", "a"), (0, 0)),
        d.joint("B", "revolute", ("ground", "b"), (2, 0), axes=((0, 0, -1),)),
        d.joint("C", "revolute", ("b", "c"), (2, 1)),
        random_coupling("G", "gear", ("A", "B"), ("a", "b")),
    ]
    return d.scene([d.body("a", (0.1, 0.2)), d.body("b", (2, 0.1)), d.body("c", (2, 1.5))], joints)


def _cylinder_on_a_plane(d: Drawing) -> Scene:
    joints = [
        d.joint("A", "cylindrical", ("ground", "a"), (0, 0)),
        d.joint("B", "point_in_plane", ("ground", "a"), (1, 0)),
        d.joint("C", "cylindrical", ("a", "b"), (1, 1)),
        d.joint("D", "planar", ("ground", "b"), (2, 1)),
    ]
    return d.scene([d.body("a", (0.5, 0)), d.body("b", (1.5, 1))], joints)


def _four_bar(kinds: tuple[str, str]) -> Callable[[Drawing], Scene]:
    def build(d: Drawing) -> Scene:
        axes = {"revolute": (NORMAL,), "spherical": (NORMAL,), "universal": ((0.6, 0.8, 0), NORMAL)}
        joints = [
            d.joint("A", "revolute", ("ground", "a"), (0, 0)),
            d.joint("B", kinds[0], ("a", "b"), (0.2, 1), axes=axes[kinds[0]]),
            d.joint("C", kinds[1], ("b", "c"), (2, 1.5), axes=axes[kinds[1]]),
            d.joint("D", "revolute", ("ground", "c"), (2.2, 0.1)),
        ]
        return d.scene([d.body("a", (0.1, 0.5)), d.body("b", (1, 1.2)), d.body("c", (2, 0.7))], joints)

    return build


def _rods_and_a_slot(d: Drawing) -> Scene:
    joints = [
        d.joint("A", "planar", ("ground", "a"), (0, 0)),
        d.joint("rod", "revolute_spherical", ("ground", "a"), (0, 1), (0.9, 1.2)),
        d.joint("slot", "point_on_line", ("ground", "a"), (0.3, 0.2), axes=((0.8, -0.6, 0),)),
    ]
    return d.scene([d.body("a", (0.5, 0))], joints)


def _slider_crank(d: Drawing) -> Scene:
    joints = [
        d.joint("A", "revolute", ("ground", "a"), (0, 0)),
        d.joint("B", "revolute", ("a", "b"), (0.2, 1)),
        d.joint("C", "revolute", ("b", "c"), (2, 0.3)),
        d.joint("D", "prismatic", ("ground", "c"), (2, 0.3), axes=((0.8, 0.6, 0),)),
    ]
    return d.scene([d.body("a", (0.1, 0.5)), d.body("b", (1, 0.6)), d.body("c", (2.1, 0.4))], joints)


def _table(d: Drawing) -> Scene:
    """Two slides across each other: no joint has the normal as its axis."""
    joints = [
        d.joint("X", "prismatic", ("ground", "a"), (0, 0), axes=((0.8, 0.6, 0),)),
        d.joint("Y", "prismatic", ("a", "b"), (0.2, 1), axes=((0.1**0.5, 0.9**0.5, 0),)),
    ]
    return d.scene([d.body("a", (0.1, 0.5)), d.body("b", (1, 0.6))], joints)


def _welded(d: Drawing) -> Scene:
    joints = [
        d.joint("A", "revolute", ("ground", "a"), (0, 0)),
        d.joint("F", "fixed", ("a", "b"), (1, 0.3)),
        d.joint("C", "cylindrical", ("b", "c"), (2, 1), axes=((0.8, 0.6, 0),)),
        d.joint("D", "planar", ("ground", "c"), (2, 1)),
    ]
    return d.scene([d.body("a", (0.5, 0)), d.body("b", (1.5, 0)), d.body("c", (2, 1.5))], joints)


def chain(drawing: Drawing, kinds: list[str]) -> Scene:
    """An open chain from the ground with joints of these kinds, their axes along the normal."""
    bodies = [drawing.body(f"body{number}", (float(number), 0.5)) for number in range(len(kinds))]
    names = ["ground", *(body.name for body in bodies)]
    joints = [
        drawing.joint(f"J{number}", kind, (names[number], names[number + 1]), (number - 0.5, 0.2))
        for number, kind in enumerate(kinds)
    ]
    return drawing.scene(bodies, joints)


#: Planar mechanisms by name.
SCENES: dict[str, Callable[[Drawing], Scene]] = {
    "chain": _chain,
    "planar joints": _branches_of_planar_joints,
    "loop of distances": _loop_of_distances,
    "gears": _gears,
    "cylinder on a plane": _cylinder_on_a_plane,
    "four-bar": _four_bar(("revolute", "revolute")),
    "regular four-bar": _four_bar(("spherical", "universal")),
    "rods and a slot": _rods_and_a_slot,
    "slider-crank": _slider_crank,
    "table": _table,
    "welded": _welded,
}
#: Those with rows that are in combination outside only where the joint is closed.
CLOSED_ONLY = {"slider-crank", "table", "welded"}


def _with(kind: str, axes: tuple[tuple[float, ...], ...] = (NORMAL,), lift: float = 0.0) -> Callable[[Drawing], Scene]:
    """A pendulum of two bars whose second joint is of this kind."""

    def build(d: Drawing) -> Scene:
        scene = _chain(d)
        second = d.joint("B", kind, ("a", "b"), (1, 0.3), (1.2, 0.4) if lift else None, axes, lift)
        return dataclasses.replace(scene, joints=(scene.joints[0], second))

    return build


def _free_body_beside(d: Drawing) -> Scene:
    scene = _chain(d)
    return dataclasses.replace(scene, bodies=(*scene.bodies, d.body("free", (3, 3))))


def _rod_between_depths(d: Drawing) -> Scene:
    scene = _loop_of_distances(d)
    rod = d.joint("rod", "distance", ("a", "b"), (0.2, 1), (1.9, 1.5), lift=1e-6)
    return dataclasses.replace(scene, joints=(*scene.joints[:2], rod))


def _balls(d: Drawing) -> Scene:
    joints = [d.joint("A", "spherical", ("ground", "a"), (0, 0)), d.joint("B", "spherical", ("a", "b"), (1, 0.3))]
    return d.scene([d.body("a", (0.5, 0)), d.body("b", (1.5, 0))], joints)


_TILTED = (0.0, 1e-6, 1.0)
#: Scenes that are not planar, with the beginning of the reason.
REFUSED: dict[str, tuple[Callable[[Drawing], Scene], str]] = {
    "free body": (_free_body_beside, "nothing but symmetry keeps body 'free' in the plane"),
    "ball on a pendulum": (_with("spherical"), "nothing but symmetry keeps body 'b' in the plane"),
    "balls only": (_balls, "nothing but symmetry can keep the bodies in a plane: no joint has an axis"),
    "screw": (_with("screw"), "joint 'B' couples coordinates that are not in the plane"),
    "axis tilted by a millionth": (_with("revolute", (_TILTED,)), "joint 'B' is tilted"),
    "slide along the normal": (_with("cylindrical"), "nothing but symmetry keeps body 'b' in the plane"),
    "universal joint": (_with("universal", (NORMAL, (1, 0, 0))), "nothing but symmetry keeps body 'b' in the plane"),
    "turn about a line in the plane": (_with("revolute", ((1, 0, 0),)), "nothing but symmetry keeps body"),
    "rod between depths": (_rod_between_depths, "joint 'rod' keeps a distance between points at different depths"),
    "point on a tilted plane": (_with("point_in_plane", ((0, 0.6, 0.8),)), "joint 'B' is tilted"),
}


def reduced(scene: Scene) -> tuple[System, np.ndarray, Plane | NotPlanar]:
    """The system, the pose of the scene, and what it reduces to there."""
    system = compile_system(scene)
    q = initial_guess(scene, system).q
    return system, q, planar_reduction(system, q)


def planar(scene: Scene) -> tuple[System, np.ndarray, Plane]:
    """The same of a scene that must be planar."""
    system, q, plane = reduced(scene)
    assert isinstance(plane, Plane), plane
    return system, q, plane


# C, C_p and γ in the coordinates of the plane, by the primitives of `joints.primitives` on vectors (x, y, 0).
#
# No row is defined a second time: the plane selects rows and columns. The kernel is tested against these.


@dataclass(frozen=True, eq=False)
class _Embedded:
    """A planar set as a spatial one with all in the plane z = 0; `kept` (m,) are its rows but for coincidence in z."""

    bound: PrimitiveSet
    kept: Integers


def planar_constraint(plane: Plane, p: Numbers) -> Numbers:
    """C of the joints' rows in the plane, (..., m), at p (..., 3n)."""
    return planar_value(plane.joints, p)


def planar_jacobian(plane: Plane, p: Array) -> Array:
    """C_p of the joints' rows in the plane, (m, 3n), at one p (3n,)."""
    embedded = _embedded(plane.joints)
    bound, bodies = embedded.bound, len(plane.mass)
    x, arm = _attached(bound, p)
    gradient, slot = bound.gradient_entries(x), bound.entry_slot
    entries = np.empty((len(slot), 3))
    entries[:, :2] = bound.is_point[slot, None] * gradient[:, :2]
    entries[:, 2] = np.sum(gradient * _turned(arm)[slot], axis=-1)
    total = np.zeros((bound.size, bodies + 1, 3))
    np.add.at(total, (bound.entry_row, bound.body[slot]), entries)
    return total[embedded.kept, :bodies].reshape(len(embedded.kept), -1)


def planar_gamma(plane: Plane, p: Numbers, u: Numbers) -> Numbers:
    """γ of the joints' rows in the plane, (..., m): C'' = C_p p'' - γ along a motion with p' = u (..., 3n)."""
    embedded = _embedded(plane.joints)
    bound = embedded.bound
    x, arm = _attached(bound, p)
    rates = _by_body(u)[..., bound.body, :]
    velocity = rates * [1.0, 1.0, 0.0] * bound.is_point[:, None]
    spin = rates[..., 2:]
    bias = bound.derivative_along(bound.gradient_entries(x), -(spin**2) * arm)
    return -(bias + bound.curvature(x, velocity + spin * _turned(arm)))[..., embedded.kept]


def planar_value(planar: PlanarSet, p: Numbers) -> Numbers:
    """The values of a planar set, (..., m), at p (..., 3n): C of joints, or what coordinates are."""
    embedded = _embedded(planar)
    x, _ = _attached(embedded.bound, p)
    return embedded.bound.value(x)[..., embedded.kept] - planar.offset


def _embedded(planar: PlanarSet) -> _Embedded:
    bindings, kept, first = [], [], 0
    ends = np.append(planar.row, planar.size)
    for index, primitive in enumerate(planar.primitives):
        slots = planar.first_slot[index] + np.arange(len(primitive.slots))
        attachments = tuple((int(planar.body[slot]), 1, np.array([*planar.local[slot], 0.0])) for slot in slots)
        bindings.append(Binding(primitive, int(planar.owner[index]), attachments))
        kept.append(first + np.arange(ends[index + 1] - ends[index]))
        first += primitive.rows
    return _Embedded(bind(bindings), np.concatenate([np.zeros(0, dtype=np.intp), *kept]))


def _attached(bound: PrimitiveSet, p: Numbers) -> tuple[Numbers, Numbers]:
    """Points and vectors (..., S, 3), and what of them turns with the body."""
    place = _by_body(p)[..., bound.body, :]
    cosine, sine = np.cos(place[..., 2:]), np.sin(place[..., 2:])
    arm = cosine * bound.local + sine * _turned(bound.local)
    return arm + place * [1.0, 1.0, 0.0] * bound.is_point[:, None], arm


def _turned(vectors: Numbers) -> Numbers:
    """A quarter turn of (x, y, 0): (-y, x, 0)."""
    return np.stack([-vectors[..., 1], vectors[..., 0], np.zeros_like(vectors[..., 2])], axis=-1)


def _by_body(flat: Numbers) -> Numbers:
    """(..., 3n) as (..., n+1, 3), the ground last and at rest."""
    rows = flat.reshape(*flat.shape[:-1], -1, 3)
    return np.concatenate([rows, np.zeros((*rows.shape[:-2], 1, 3), dtype=rows.dtype)], axis=-2)
