"""What several tests need: random mechanisms from the joint table, a recorder in memory, the shipped mechanisms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from mbproj import Scene
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import State, assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.functions.plane_curve import CamFollower, Rise, ellipse, of_law, polar, polyline, through
from mbproj.functions.space_curve import SpaceTrack, Track, through_space
from mbproj.joints.primitives.basic import Primitive
from mbproj.joints.primitives.plane_curves import (
    Arc,
    Face,
    FacePlace,
    FaceSlip,
    Gap,
    Lap,
    PlaceOnFirst,
    PlaceOnSecond,
    Profile,
    SlipOfTwo,
)
from mbproj.joints.primitives.space_curves import BesideFirst, BesideSecond, SpaceArc
from mbproj.joints.table import JOINTS, TWO_ANGLES, Parameter, Ratio
from mbproj.model.compile.frames import SYMBOLS, local_frames
from mbproj.model.compile.joints import primitive_of
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.system import System
from mbproj.scene.blocks.ropes import Node
from mbproj.scene.blocks.ropes import Path as RopePath
from mbproj.scene.records import Body, Coupled, Joint, Marker, OfBody, Pair

# Curves of each form, primitives on them, and primitives with numbers.

CORNERS = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.6), (0.0, 1.0)]
RISES = [
    Rise(2.0 * pi / 3.0, 0.3, "cycloidal"),
    Rise(pi / 3.0, 0.3, "dwell"),
    Rise(2.0 * pi / 3.0, 0.0, "modified_sine"),
    Rise(pi / 3.0, 0.0, "dwell"),
]
TABLE = [(0.0, 1.0), (0.5 * pi, 1.2), (pi, 1.0), (4.5, 0.9), (2.0 * pi, 1.0)]


#: Of sizes about 1 m.
LINES = {
    "spline": through([(1.0, 0.0), (0.2, 0.8), (-0.7, 0.3), (-0.4, -0.8)], closed=True),
    "open spline": through([(0.0, 0.0), (1.0, 0.2), (2.0, 0.0)], closed=False),
    "ellipse": ellipse((0.7, 0.4)),
    "large": ellipse((3.0, 2.8)),
    "polyline": polyline(CORNERS, 0.1, closed=True),
    "open polyline": polyline(CORNERS[:3], 0.1, closed=False),
    "table": polar(TABLE),
    "roller": of_law(0.6, RISES, CamFollower("roller", 0.1), clockwise=False),
    "clockwise": of_law(0.6, RISES, CamFollower("point"), clockwise=True),
    "flat": of_law(0.9, RISES, CamFollower("flat"), clockwise=False),
    "flat, clockwise": through([(1.0, 0.0), (0.1, -0.9), (-0.8, 0.1), (0.0, 0.8)], closed=True),
}
WIRES = {
    "wire": through_space([(1.0, 0.0, 0.2), (0.2, 0.8, -0.3), (-0.7, 0.3, 0.4), (-0.4, -0.8, 0.0)], closed=True),
    "open wire": through_space([(0.0, 0.0, 0.0), (1.0, 0.2, 0.3), (2.0, 0.0, -0.1)], closed=False),
}


def made(kind: type[Primitive]) -> Primitive:
    """One of this kind with parameters that differ, on curves where it follows any."""
    signs = {name: -1.0 for name in kind.parameters if "side" in name}
    numbers = {name: 0.7 + 0.2 * at for at, name in enumerate(kind.parameters)} | signs
    curves = {"curve": (LINES["ellipse"],), "two curves": (LINES["ellipse"], LINES["flat"])}
    return kind(*{**curves, "space curve": (WIRES["wire"],)}.get(kind.follows, ()), **numbers)


ON_CURVES = {
    "first beside a wire": BesideFirst(WIRES["wire"]),
    "second beside a wire": BesideSecond(WIRES["wire"]),
    "along a wire": SpaceArc(WIRES["wire"]),
    "outside": Profile(LINES["spline"], side=-1.0, reach=0.1),
    "inside": Profile(LINES["ellipse"], side=1.0),
    "held": Profile(LINES["ellipse"], piece=0, side=-1.0, reach=0.2),
    "arc": Arc(LINES["roller"]),
    "lap": Lap(LINES["spline"], offset=-0.1, scale=0.8),
    "lap on a piece": Lap(LINES["ellipse"], piece=0, offset=0.1, scale=1.3),
    "face": Face(LINES["flat"]),
    "face of an ellipse": Face(LINES["ellipse"]),
    "place on a face": FacePlace(LINES["flat"]),
    "place on a face, clockwise": FacePlace(LINES["flat, clockwise"]),
    "slip of a face": FaceSlip(LINES["flat"]),
    "slip of a face, clockwise": FaceSlip(LINES["flat, clockwise"]),
    "face on a piece": Face(LINES["ellipse"], piece=0),
    "two curves": Gap(LINES["ellipse"], LINES["flat"], side=-1.0, other_side=-1.0, reach=0.1),
    "one in the other": Gap(LINES["large"], LINES["ellipse"], side=1.0, other_side=-1.0),
    "two curves on pieces": Gap(LINES["ellipse"], LINES["large"], piece=0, other_piece=0, side=-1.0, other_side=-1.0),
    "place on the first": PlaceOnFirst(LINES["ellipse"], LINES["flat"], side=-1.0, other_side=-1.0),
    "place on the second": PlaceOnSecond(LINES["flat"], LINES["flat, clockwise"], side=-1.0, other_side=1.0),
    "slip of two": SlipOfTwo(LINES["ellipse"], LINES["flat"], side=-1.0, other_side=-1.0),
    "slip of two, clockwise": SlipOfTwo(LINES["flat"], LINES["flat, clockwise"], side=-1.0, other_side=1.0),
    "place on the first, hollow": PlaceOnFirst(LINES["spline"], LINES["ellipse"], side=-1.0, other_side=-1.0),
    "arc of an open one": Arc(LINES["open polyline"]),
}


# What several tests need: random mechanisms from the joint table, a recorder in memory, the shipped mechanisms.

ROOT = Path(__file__).parents[1]
DATA = Path(__file__).parent / "data"
MECHANISMS = sorted((ROOT / "mechanisms").glob("*.yaml"))
#: Rows that follow from the others at every pose, by mechanism; the others have none.
REDUNDANT = {"bennett": 3, "bricard": 1, "locomotive": 7, "n_four_bar": 6, "steered_car": 3}
#: With a body that has neither mass nor inertia.
MASSLESS = ("massless_coupler",)


def vector(rng: np.random.Generator, scale: float = 1.0) -> tuple[float, float, float]:
    x, y, z = scale * rng.normal(size=3)
    return float(x), float(y), float(z)


def unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def random_body(rng: np.random.Generator, name: str) -> Body:
    """A body of random pose and motion; its moments obey the triangle inequality."""
    a, b, c = rng.uniform(0.1, 1.0, size=3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    inertia = turn @ np.diag([b + c, a + c, a + b]) @ turn.T
    inertia = 0.5 * (inertia + inertia.T)
    orientation = tuple(float(x) for x in unit(rng.normal(size=4)))
    return Body(
        name,
        mass=float(rng.uniform(0.5, 2.0)),
        inertia=tuple(tuple(float(x) for x in row) for row in inertia),
        position=vector(rng),
        orientation=orientation,
        velocity=vector(rng),
        angular_velocity=vector(rng),
    )


PARAMETERS = {"pitch": 0.4, "length": 1.3, "slots": 5.0}


def parameter(name: str, given: Parameter) -> float | tuple[float, ...] | Track | SpaceTrack | tuple[Track, ...]:
    """A value of a parameter of the joint table."""
    if given.may_be == "curve" and given.many:
        return Track("ellipse", LINES["ellipse"]), Track("flat", LINES["flat"])
    if given.may_be == "curve":
        return Track("spline", LINES["spline"])
    if given.may_be == "space_curve":
        return SpaceTrack("wire", WIRES["wire"])
    if given.may_be == "convex":
        return Track("flat", LINES["flat"], flat=True)
    if given.many is None:
        return PARAMETERS.get(name, 0.3)
    larger = 100.0 if given.may_be == "teeth" else 1.0
    sign = 1.0 if given.may_be == "positive" else -1.0
    return tuple(larger * sign**at * (0.2 + 0.15 * at) for at in range(given.many))


def random_joint(rng: np.random.Generator, name: str, kind: str, bodies: tuple[str, str]) -> Joint:
    """A joint of this type between two bodies, closed at the scene's pose; a fixed one is kept as a constraint."""
    point, first = vector(rng), unit(rng.normal(size=3))
    of = JOINTS[kind]
    if of.frame == "path":
        return random_rope(rng, name, bodies, np.array(point), first)
    across_axis = of.frame in ("axes", "face", "line")
    second = unit(np.cross(first, rng.normal(size=3))) if across_axis else first
    second = unit(rng.normal(size=3)) if of.has_axis and not across_axis else second
    axes = None if of.frame == "point" else Pair(tuple(map(float, first)), tuple(map(float, second)))
    parameters = {name: parameter(name, of.parameters[name]) for name in of.required_parameters}
    x_axis = Pair(across := vector(rng), across) if of.x_axis == "required" else None
    apart = of.separate or of.is_on_plane
    points = Pair(point, vector(rng) if apart else point)
    joint = Joint(name, kind, bodies, points, axes, parameters=parameters, reaction=True, x_axis=x_axis)
    return closed(joint) if apart else joint


def closed(joint: Joint) -> Joint:
    """The joint with its second point moved as little as closes those rows that keep no value of the scene's pose."""
    kept = JOINTS[joint.type].constant_rows
    here = {body: (np.zeros(3), np.eye(3)) for body in joint.bodies}
    for _ in range(50):
        symbols = dict(zip(SYMBOLS, local_frames([joint], here)[0], strict=True))
        left, slopes = list[float](), list[np.ndarray]()
        for number, row in enumerate(JOINTS[joint.type].rows):
            primitive = primitive_of(row, joint)
            wanted = joint.parameters.get(kept.get(number) or "", 0.0)
            if (number in kept and not wanted) or not primitive.integrable:
                continue
            x = np.array([[symbols[each.lstrip("-")] * (-1.0 if each[0] == "-" else 1.0) for each in row[1:]]])
            slope = primitive.gradient(x)[0, :, [at for at, each in enumerate(row[1:]) if each == "p2"]].sum(axis=0)
            left += (primitive.value(x)[0] - wanted).tolist()
            slopes += [*slope]
        if not left or np.abs(left).max() < 1e-15:
            break
        step = np.linalg.lstsq(np.array(slopes), np.array(left), rcond=1e-9)[0]
        second = tuple(map(float, np.array(joint.points.second) - step))
        joint = replace(joint, points=Pair(joint.points.first, second))
    return joint


def random_rope(
    rng: np.random.Generator, name: str, bodies: tuple[str, str], point: np.ndarray, normal: np.ndarray
) -> Joint:
    """A rope from a point of the first body over a sheave of the second one to another point of the first."""
    along = unit(np.cross(normal, rng.normal(size=3)))
    across = np.cross(normal, along)
    places = [point, point + 1.2 * along, point + 0.4 * along + 0.9 * across]
    first, centre, last = (tuple(map(float, place)) for place in places)
    nodes = (
        Node("point", bodies[0], OfBody(bodies[0], first)),
        Node("sheave", bodies[1], OfBody(bodies[1], centre), radius=0.1, left=True),
        Node("point", bodies[0], OfBody(bodies[0], last)),
    )
    path = RopePath(nodes, tuple(map(float, normal)), frame=bodies[0])
    return Joint(name, "rope", bodies, Pair(first, centre), parameters={"path": path})


#: A joint that has what is coupled.
OWN = {"angle": "revolute", "along": "prismatic"}


def random_coupling(name: str, kind: str, couples: tuple[str, ...], bodies: tuple[str, str]) -> Joint:
    """A joint of this type on the coordinates of others; a coupler on sums of angles."""
    nowhere = Pair((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    own = JOINTS[kind].parameters
    parameters = {name: parameter(name, own[name]) for name in JOINTS[kind].required_parameters}
    weights, period, function = (JOINTS[kind].coupling or (lambda: Ratio((2.0, -3.0), None)))(**parameters)
    names = {"angle": "angle", "along": "displacement"}
    of = zip(couples, JOINTS[kind].couples or TWO_ANGLES, weights, strict=True)
    coupled = Coupled({f"{joint}.{names[each]}": weight for joint, each, weight in of}, function, period=period)
    return Joint(name, kind, bodies, nowhere, parameters=parameters, couples=coupled)


def scene_of(bodies: list[Body], joints: list[Joint], markers: list[Marker] | None = None, **changes: Any) -> Scene:
    """A scene without a file."""
    defaults: dict[str, Any] = {
        "title": "",
        "gravity": (0.3, -0.2, -9.8),
        "parameters": {},
        "settings": Settings(duration=0.1, step=0.01),
        "text": "",
        "path": None,
        "overrides": {},
        "places": {},
    }
    return Scene(bodies=tuple(bodies), joints=tuple(joints), markers=tuple(markers or []), **(defaults | changes))


def random_chain(seed: int, kinds: list[str]) -> Scene:
    """A chain from the ground with these joints, closed at its pose, moving at random.

    A gear is a revolute joint in the chain that is coupled to the one before it; so are others that couple, with as
    many before them as they want.
    """
    rng = np.random.default_rng(seed)
    bodies = [random_body(rng, f"body{number}") for number in range(len(kinds))]
    names = ["ground", *(body.name for body in bodies)]
    joints, couplings = [], []
    for number, kind in enumerate(kinds):
        wanted = [OWN[each] for each in JOINTS[kind].couples or TWO_ANGLES]
        couples = JOINTS[kind].frame == "joints"
        own = wanted[number % len(wanted)] if couples else kind
        ends = (names[number], names[number + 1])
        joints.append(random_joint(rng, f"J{number}", own, ends))
        last = joints[-len(wanted) :]
        if couples and [joint.type for joint in last] == wanted:
            couplings.append(random_coupling(f"G{number}", kind, tuple(joint.name for joint in last), ends))
    return scene_of(bodies, [*joints, *couplings], [Marker("end", bodies[-1].name, vector(rng))])


def with_flywheels(scene: Scene, size: float = 1.0) -> Scene:
    """The scene with a reflected inertia of 0.1 to 2 times this size on each coordinate of its joints."""
    rng = np.random.default_rng(len(scene.joints))
    joints = [
        replace(
            joint,
            reflected_inertia={name: size * float(rng.uniform(0.1, 2.0)) for name in JOINTS[joint.type].coordinates},
        )
        for joint in scene.joints
    ]
    return replace(scene, joints=tuple(joints))


class Recorder:
    """Keeps the blocks of a run in memory."""

    def __init__(self) -> None:
        self.blocks: list[Mapping[str, np.ndarray]] = []

    def write(self, block: Mapping[str, np.ndarray]) -> None:
        self.blocks.append(block)

    def __getitem__(self, path: str) -> np.ndarray:
        return np.concatenate([block[path] for block in self.blocks])


def assembled(scene: Scene) -> tuple[System, State]:
    """The System of a scene, and its start with closed joints."""
    system = compile_system(scene)
    return system, assemble(system, initial_guess(scene, system))
