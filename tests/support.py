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


def made(kind: type[Primitive]) -> Primitive:
    """One of this kind with parameters that differ."""
    return kind(**{name: 0.7 + 0.2 * at for at, name in enumerate(kind.parameters)})


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


def on_track(
    track: Track, point: tuple[float, ...], z: np.ndarray, across: np.ndarray, rng: np.random.Generator, radius: float
) -> Pair:
    """A point, the origin of a curve in the plane normal to z with its x nearest to `across`, and the centre of a
    roller on the curve, outside."""
    x = unit(across - (across @ z) * z)
    at = rng.uniform(track.line.start, track.line.end, 1)
    (u,), (w,) = (place := track.line.derivatives(at, track.line.at(at)))[0]
    aside = track.distance(None, radius) * unit(place[1, :, 0])
    u, w = u - aside[1], w + aside[0]
    there = np.array(point) + u * x + w * np.cross(z, x)
    return Pair(point, tuple(float(each) for each in there))


def under_face(
    track: Track,
    point: tuple[float, ...],
    z: np.ndarray,
    across: np.ndarray,
    normal: np.ndarray,
    rng: np.random.Generator,
) -> tuple[float, ...]:
    """A point of a face with this normal that touches a curve in the plane normal to z, its x nearest to `across`."""
    x = unit(across - (across @ z) * z)
    frame = np.array([x, np.cross(z, x)])
    s, piece = track.line.facing((frame @ normal)[None, :])
    (u,), (w,) = track.line.derivatives(s, piece)[0]
    aside = rng.normal() * np.cross(z, normal) + rng.normal() * z
    return tuple(map(float, np.array(point) + u * frame[0] + w * frame[1] + aside))


def on_wire(
    track: SpaceTrack, point: tuple[float, ...], z: np.ndarray, across: np.ndarray, rng: np.random.Generator
) -> Pair:
    """The origin of a curve in space, its z given and its x nearest to `across`, and a point of it."""
    x = unit(across - (across @ z) * z)
    at = int(rng.integers(len(track.line.places.s)))
    there = np.array(point) + track.line.places.point[at] @ np.array([x, np.cross(z, x), z])
    return Pair(point, tuple(map(float, there)))


def touching(
    tracks: tuple[Track, Track], point: tuple[float, ...], z: np.ndarray, across: np.ndarray, rng: np.random.Generator
) -> Pair:
    """The origins of two closed convex curves that touch in the plane normal to z, their x nearest to `across`."""
    x = unit(across - (across @ z) * z)
    normal = unit(rng.normal(size=2))
    places = [
        track.line.derivatives(*track.line.facing(e[None, :]))[0, :, 0]
        for track, e in zip(tracks, (normal, -normal), strict=True)
    ]
    u, w = places[0] - places[1]
    return Pair(point, tuple(map(float, np.array(point) + u * x + w * np.cross(z, x))))


def random_joint(rng: np.random.Generator, name: str, kind: str, bodies: tuple[str, str]) -> Joint:
    """A joint of this type between two bodies, closed at the scene's pose; a fixed one is kept as a constraint."""
    point, first = vector(rng), unit(rng.normal(size=3))
    if JOINTS[kind].frame == "path":
        return random_rope(rng, name, bodies, np.array(point), first)
    second = unit(np.cross(first, rng.normal(size=3))) if JOINTS[kind].frame == "axes" else first
    axes, across = None, None
    if JOINTS[kind].frame != "point":
        axes = Pair(tuple(float(x) for x in first), tuple(float(x) for x in second))
    points = Pair(point, vector(rng) if JOINTS[kind].separate else point)
    if JOINTS[kind].is_on_plane:
        axis = unit(rng.normal(size=3)) if JOINTS[kind].has_axis else first
        axis = unit(np.cross(first, axis)) if JOINTS[kind].frame == "line" else axis
        axes = Pair(tuple(map(float, first)), tuple(map(float, axis)))
        height = 0.3 * (np.linalg.norm(np.cross(first, axis)) if JOINTS[kind].has_axis else 1.0)
        if "semi_axes" in JOINTS[kind].parameters:
            across = vector(rng)
            height = reach(first, axis, np.array(across), parameter("semi_axes", JOINTS[kind].parameters["semi_axes"]))
        aside = np.cross(first, rng.normal(size=3))
        points = Pair(point, tuple(map(float, np.array(point) + aside + height * first)))
    own = JOINTS[kind].parameters
    parameters = {name: parameter(name, own[name]) for name in JOINTS[kind].required_parameters}
    if across is None and JOINTS[kind].x_axis == "required":
        across = vector(rng)
    x_axis = across and Pair(across, across)
    if JOINTS[kind].frame == "face":
        normal = tuple(map(float, unit(np.cross(first, rng.normal(size=3)))))
        axes = Pair(axes.first, normal)
        points = Pair(point, under_face(parameters["curve"], point, first, np.array(across), np.array(normal), rng))
    elif JOINTS[kind].sketch == "wire":
        points = on_wire(parameters["curve"], point, first, np.array(across), rng)
    elif "curves" in own:
        parameters = {"curves": parameter("curves", own["curves"])}
        points = touching(parameters["curves"], point, first, np.array(across), rng)
    elif "curve" in own:
        points = on_track(parameters["curve"], point, first, np.array(across), rng, parameters.get("roller", 0.0))
    return Joint(name, kind, bodies, points, axes, parameters=parameters, reaction=True, x_axis=x_axis)


def reach(normal: np.ndarray, axis: np.ndarray, across: np.ndarray, semi_axes: tuple[float, ...]) -> float:
    """How far the centre of an ellipsoid is above its lowest point: the first semi-axis is nearest to `across`."""
    x = unit(across - (across @ axis) * axis)
    return float(np.linalg.norm(np.array(semi_axes) * (np.array([x, np.cross(axis, x), axis]) @ normal)))


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
