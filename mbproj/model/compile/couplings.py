"""Constraint rows and primitives that take more from a scene than points and axes: rows that couple joint coordinates,
joints that follow curves, and gears whose teeth load bearings.

All is in SI units and radians. What is made here is described in mbproj.joints.primitives and mbproj.model.couplings.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.program import COORDINATE, Op
from mbproj.functions.space_curve import Track
from mbproj.functions.standard import Curve
from mbproj.joints.primitives.coupling import COORDINATES, Coupling
from mbproj.joints.primitives.plane_curves import Gap, Lap, OnCurve, TwoCurves
from mbproj.joints.table import JOINTS
from mbproj.model.compile.frames import local_frames, poses_of
from mbproj.model.couplings import Toothed, Touching
from mbproj.model.primitive_set import Binding
from mbproj.scene.records import GROUND, Coupled, Joint, JointForce
from mbproj.scene.scene import Scene

# --- Rows that couple joint coordinates, such as those of threads, teeth and belts ------------------------------------

#: The name of a coordinate that can be coupled, such as "angle", by the class of its primitive.
_NAME_OF = {type(primitive): name for name, primitive in COORDINATES.items()}


def row_binding(where: str, coupled: Coupled, constant: float, parts: Sequence[Binding], owner: int) -> Binding:
    """Return the row Σ kᵢ sᵢ - f(s₀) = constant of `coupled`. `parts` are its coordinates sᵢ bound to bodies, in order;
    `owner` is the number of the row's joint. The row acts on the slots of all parts. Its reaction is the one on the
    second body of the last coordinate. Raises InputError, which names `where`, if f has edges or alters with a turn."""
    slots = [(body, side if part is parts[-1] else 1, local) for part in parts for body, side, local in part.slots]
    primitive = _coupling(where, coupled, parts)
    whole_periods = primitive.period * np.round(constant / primitive.period) if primitive.period else 0.0
    return Binding(primitive, owner, tuple(slots), float(constant - whole_periods))


def _coupling(where: str, coupled: Coupled, parts: Sequence[Binding]) -> Coupling:
    """Return the primitive of a row. A pose tells angles only up to whole turns, and so the row only up to what turns
    change in it: that has to be whole multiples of one period, such as a tooth. Without a period of its own the row has
    the largest one. Raises InputError where there is none, or the function does not repeat by it."""
    kinds, weights = tuple(_NAME_OF[type(part.primitive)] for part in parts), tuple(coupled.of.values())
    # The change of the row by a turn of each angle, and of the function by a turn of the first, over 2π.
    changes = [abs(weight) for weight, kind in zip(weights, kinds, strict=True) if kind == "angle" and weight]
    of_angle = kinds[0] == "angle"
    curve = None if coupled.function is None else _curve(where, coupled, of_angle)
    if curve is not None and of_angle:
        value, slope, _ = (part.real for part in curve(np.linspace(-np.pi, np.pi, 17)))
        growth = abs(float(value[-1] - value[0])) / (2.0 * np.pi)
        changes += [growth] if growth > THRESHOLDS.same_written * np.abs([value, slope]).max() else []
    period = coupled.period
    if period is None:
        measure = common_measure(changes)
        if measure is None:
            what = f"{where} couples several angles whose turns have no common measure"
            raise InputError(Problem(what, hint="give weights whose ratios are those of whole numbers"))
        period = 2.0 * np.pi * measure
    if curve is not None and of_angle and not curve.repeats(2.0 * np.pi, period):
        hint = "let it repeat with each turn, or change by as much in each"
        raise InputError(Problem(f"the function of {where} changes with a turn", hint=hint))
    return Coupling(kinds, weights, period, curve)


def _curve(where: str, coupled: Coupled, of_angle: bool) -> Curve:
    """Return the function of a row as a curve. Raises InputError where it names other channels or has edges."""
    assert coupled.function is not None
    if any(step.op is Op.VARIABLE and step.operand != COORDINATE for step in coupled.function.code):
        raise InputError(Problem(f"the function of {where} names more than its first coordinate", hint="add a force"))
    curve = Curve(coupled.function)
    for low, high in _intervals_searched(of_angle):
        edges = curve.edges(low, high)
        if edges:
            what = f"the function of {where} has edges, at s = {edges[0]:.6g}"
            raise InputError(Problem(what, hint="give one whose slope does not jump"))
    return curve


def _intervals_searched(of_angle: bool) -> Iterator[tuple[float, float]]:
    """The intervals in which a function is searched for edges: more than one turn of an angle, in rad. For a length, in
    m, each power of ten is an interval of its own, because large values of a function hide small jumps."""
    if of_angle:
        return iter([(-4.0, 4.0)])
    far = 10.0 ** np.arange(-THRESHOLDS.edge_decades, THRESHOLDS.edge_decades + 1)
    return pairwise([*(-far[::-1]).tolist(), *far.tolist()])


def common_measure(sizes: Sequence[float]) -> float | None:
    """Return the largest number of which all these positive sizes are whole multiples; 0 for no sizes, None where there
    is no such number."""
    if not sizes:
        return 0.0
    from fractions import Fraction  # imported late: with decimal it takes 3 ms, and only couplings need it

    largest = max(sizes)
    parts = [Fraction(size / largest).limit_denominator(THRESHOLDS.largest_ratio) for size in sizes]
    if any(abs(float(part) - size / largest) > THRESHOLDS.rounding for part, size in zip(parts, sizes, strict=True)):
        return None
    whole = math.lcm(*(part.denominator for part in parts))
    return largest * math.gcd(*(int(part * whole) for part in parts)) / whole


# --- The primitives of joints that follow curves ----------------------------------------------------------------------
# A `Track` has the line to follow, and the radius of the roller that the curve was made for, 0 for none. All distances
# are in m, to the left of the line.


def on_curve(kind: type[OnCurve], joint: Joint) -> OnCurve:
    """Return the primitive of this kind of a joint that follows a curve. A slot guides a point along the line of the
    curve. A cam guides a roller: its radius is the joint's or, where the joint gives none, the one of the curve."""
    track: Track = joint.parameters["curve"]
    if kind is Lap:
        return _lap(joint)
    if "reach" not in kind.parameters or "roller" not in JOINTS[joint.type].parameters:
        return kind(track.line)
    side, radius = joint.parameters.get("side"), joint.parameters.get("roller", track.roller)
    left = 1.0 if track.is_left(side) else -1.0
    return kind(track.line, side=left, reach=left * track.distance(side, radius))  # type: ignore[call-arg]


def two_curves(kind: type[TwoCurves], joint: Joint) -> TwoCurves:
    """Return the primitive of this kind of a joint at which two curves touch, by default on their outer sides. A curve
    that was made for a roller has its profile to the left, at a distance of the roller's radius."""
    tracks: tuple[Track, Track] = joint.parameters["curves"]
    sides = [
        1.0 if track.is_left(side) else -1.0
        for track, side in zip(tracks, joint.parameters.get("sides", (None, None)), strict=True)
    ]
    (first, second), (side, other_side) = (track.line for track in tracks), sides
    if kind is Gap:
        reach = side * tracks[0].roller + other_side * tracks[1].roller
        return Gap(first, second, side=side, other_side=other_side, reach=reach)
    return kind(first, second, side=side, other_side=other_side)


def touching_of(joints: Sequence[Joint], coordinates: Sequence[str]) -> tuple[Touching | None, tuple[str, ...]]:
    """Return the joints that follow curves as `Touching`, None without any, and their names. `coordinates` are the
    names of the system's coordinates; a joint's are one after another, "name.coordinate" each."""
    followers = []
    for joint in joints:
        curves = joint.parameters.get("curves", (joint.parameters.get("curve"),))
        if curves[0] is not None:
            first = next(at for at, name in enumerate(coordinates) if name.startswith(f"{joint.name}."))
            followers.append((joint.name, first, getattr(curves[0], "roller", 0.0)))
    if not followers:
        return None, ()
    names, first_of, offset = zip(*followers, strict=True)
    return Touching(first_of, offset), names


def rolling(joint: Joint) -> Coupling:
    """Return the row (m) that keeps a roller from slipping. It couples the way of the roller's centre along its curve
    and the turn of the roller times its radius."""
    lap, track = _lap(joint), joint.parameters["curve"]
    side = 1.0 if track.is_left(joint.parameters.get("side")) else -1.0
    period = 2.0 * np.pi / lap.scale if track.line.closed else 0.0
    return Coupling(("lap", "angle"), (1.0 / lap.scale, side * joint.parameters["roller"]), period, other=lap)


def _lap(joint: Joint) -> Lap:
    """Return the lap of a roller's centre: its way along the curve as an angle. A closed curve is one turn, an open one
    a quarter turn, so that its two ends are never the same angle."""
    track: Track = joint.parameters["curve"]
    offset = track.distance(joint.parameters.get("side"), joint.parameters["roller"])
    # The path of the centre is parallel to the curve: it is shorter by the offset times the angle by which that turns.
    length = track.line.length - offset * track.line.turn
    return Lap(track.line, offset=offset, scale=(2.0 if track.line.closed else 0.5) * np.pi / length)


# --- Gears whose teeth load bearings ----------------------------------------------------------------------------------


def toothed(scene: Scene, joints: Sequence[Joint], coordinates: Sequence[str]) -> tuple[Toothed, ...]:
    """Return the gears that have a pressure angle: the normal force of their teeth loads the wheels' bearings.
    `coordinates` are the names of the joints' coordinates. Raises InputError where such a load cannot be told."""
    number, gears = {joint.name: at for at, joint in enumerate(joints)}, []
    for joint in joints:
        angle = joint.parameters.get("pressure_angle")
        if angle is None or joint.couples is None:
            continue
        first, second = joint.couples.joints
        _check_bearings(scene, joint, joints[number[first]], joints[number[second]])
        bearings = number[first], number[second]
        angles = coordinates.index(f"{first}.angle"), coordinates.index(f"{second}.angle")
        gears.append(Toothed(number[joint.name], bearings, angles, joint.parameters["teeth"], angle))
    return tuple(gears)


def _check_bearings(scene: Scene, gear: Joint, first: Joint, second: Joint) -> None:
    """Raise InputError where the load of a gear's bearings, the joints `first` and `second`, cannot be told: axes are
    not parallel, or a wheel is the first body of its joint. Or a friction depends on it, which would lack the teeth."""
    place = scene.place("joints", gear.name, "pressure_angle")
    frames = local_frames([first, second], poses := poses_of(scene))
    axes = [frame[7] @ poses[joint.bodies[1]][1].T for frame, joint in zip(frames, (first, second), strict=True)]
    if float(np.linalg.norm(np.cross(*axes))) > THRESHOLDS.rounding:
        what = f"the axes of gear '{gear.name}' are not parallel: its pitch point is not known"
        raise InputError(Problem(what, place, "leave 'pressure_angle' out"))
    for joint in (first, second):
        if joint.bodies[1] == GROUND:
            what = f"the ground is the second body of joint '{joint.name}', and a wheel of gear '{gear.name}'"
            raise InputError(Problem(what, place, "give the wheel as the second body of its joint"))
        for force in scene.forces:
            dry = force.coulomb.values() if isinstance(force, JointForce) and force.joint == joint.name else ()
            if any(friction.bearing is not None for friction in dry):
                what = f"friction '{force.name}' depends on the load of joint '{joint.name}' without forces of teeth"
                raise InputError(Problem(what, place, "give it a constant 'torque', or leave 'pressure_angle' out"))
