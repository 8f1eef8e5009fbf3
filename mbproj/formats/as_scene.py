"""Writes a mechanism as a readable scene: with names, origins and units, and with parameters for repeated numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.errors import InputError, Place, Problem
from mbproj.formats.geometry import quaternion
from mbproj.formats.mechanism import Bare, Connection, ImportedBody, ImportedMechanism, Quantity, Same
from mbproj.formats.yaml_text import WIDTH, flow, lines

#: Points (in m, relative to their size) and axes of two bodies that differ by less are the same.
AGREE = 2e-13
#: A number that occurs at least this often becomes a parameter.
OFTEN = 4
#: The keys whose numbers may become parameters.
SHARED = ("mass", "stiffness", "damping", "coefficient", "reflected_inertia", "torque", "force")


def scene_text(mechanism: ImportedMechanism, version: str) -> str:
    """The text of the scene; its lines have at most 100 characters, unless names are longer."""
    names = _parameters(mechanism)
    text = list(_head(mechanism, version))
    if names:
        text += lines("parameters", {name: quantity for quantity, name in names.items()}, 0)
    adjust = f", adjust_joints: {mechanism.adjust}" if mechanism.adjust else ""
    text.append(f"simulation: {{duration: 10 s, tolerance: 1.0e-8, integrator: dopri5, output_step: 10 ms{adjust}}}")
    text.append("bodies:")
    for part in mechanism.parts.values():
        text += lines(part.name, _with_names(_body(part), names), 2, _origin(part.place, mechanism.file))
    for title, loops in (("joints", False), ("loops", True)):
        chosen = [joint for joint in mechanism.joints.values() if (joint.name not in mechanism.tree) is loops]
        if chosen and not loops:
            text.append("joints:")
        elif chosen:
            text += ["joints:"] if not mechanism.tree else []
            text.append(f"  # These close {title}, or couple coordinates.")
        for joint in chosen:
            entry = _with_names(_joint(mechanism, joint), names)
            text += lines(joint.name, entry, 2, _origin(joint.place, mechanism.file))
    if mechanism.signals:
        text.append("signals:")
        for name, signal in mechanism.signals.items():
            text += lines(name, signal, 2)
    if mechanism.states:
        text.append("states:")
        for name, state in mechanism.states.items():
            text += lines(name, state, 2)
    if mechanism.forces:
        text.append("forces:")
        for name, force in mechanism.forces.items():
            text += lines(name, _with_names(force, names), 2)
    if mechanism.motions:
        text.append("motions:")
        for name, motion in mechanism.motions.items():
            text += lines(name, motion, 2)
    if mechanism.markers:
        text.append("markers:")
        for name, (body, point) in mechanism.markers.items():
            text += lines(name, {"body": body, "location": {body: point}}, 2)
    return "\n".join(text) + "\n"


def _head(mechanism: ImportedMechanism, version: str) -> Iterator[str]:
    origin = f"# Imported by mbproj {version} from {mechanism.kind},"
    file = flow(mechanism.file)
    yield from [f"{origin} {file}"] if len(origin) + len(file) < WIDTH else [origin, f"#   {file}"]
    yield f"# {len(mechanism.parts)} bodies, {len(mechanism.joints)} joints. Comments give the lines of the model."
    yield "mbproj: 1"
    yield f"title: {flow(mechanism.title)}"
    yield f"gravity: {flow(mechanism.gravity)}  # m/s^2"


def _origin(place: Place | None, file: str) -> str:
    """The text for the place of an element in the model's file."""
    if place is None or place.line is None:
        return ""
    return f"line {place.line}" if place.file == file else f"{place.file}:{place.line}"


def _body(part: ImportedBody) -> dict[str, Any]:
    entry: dict[str, Any] = {"mass": Quantity(part.mass, "kg"), "inertia": _inertia(part.inertia)}
    entry["position"] = part.position
    turned = quaternion(part.rotation)
    if np.abs(turned[1:]).max() > 1e-15:
        entry["orientation"] = {"quaternion": turned}
    if part.velocity.any():
        entry["velocity"] = part.velocity
    if part.angular_velocity.any():
        entry["angular_velocity"] = part.angular_velocity
    if part.look:
        entry["appearance"] = part.look
    return entry


def _inertia(inertia: Array) -> Array:
    """The three moments where all products of inertia vanish, else all six elements, as a scene gives them."""
    scale = np.abs(inertia).max()
    mixed = np.array([inertia[0, 1], inertia[0, 2], inertia[1, 2]])
    if (np.abs(mixed) <= 1e-15 * scale).all():
        return np.diag(inertia)
    return np.concatenate([np.diag(inertia), mixed])


def _joint(mechanism: ImportedMechanism, joint: Connection) -> dict[str, Any]:
    """The entry of a joint in the scene: with one global point and axis where both bodies agree, else in each body's
    axes."""
    entry: dict[str, Any] = {"type": joint.type}
    if joint.points is None:
        return entry | dict(joint.keys)
    entry["bodies"] = list(joint.bodies)
    ends = [mechanism.part(body) for body in joint.bodies]
    places = np.array([end.position + end.rotation @ point for end, point in zip(ends, joint.points, strict=True)])
    closed = _agree(places, max(1.0, float(np.abs(places).max())))
    key = "axes" if joint.type == "universal" else "axis"
    axes = None
    if joint.axes is not None:
        axes = np.array([end.rotation @ axis for end, axis in zip(ends, joint.axes, strict=True)])
        if key == "axis":
            closed = closed and _agree(axes, 1.0)
    if joint.turns is not None:
        turned = [end.rotation @ turn for end, turn in zip(ends, joint.turns, strict=True)]
        closed = closed and _agree(np.array(turned), 1.0)
    if joint.type in ("distance", "telescope"):
        entry["locations"] = dict(zip(joint.bodies, joint.points, strict=True))
    elif closed:
        entry["location"] = places[0]
        if axes is not None:
            entry[key] = [*axes] if key == "axes" else axes[0]
    else:
        entry |= _by_body(joint, key)
    return entry | dict(joint.keys)


def _agree(pair: Array, scale: float) -> bool:
    return bool(np.abs(pair[0] - pair[1]).max() <= AGREE * scale)


def _by_body(joint: Connection, key: str) -> dict[str, Any]:
    """The keys with the points and axes of a joint by body, each in that body's axes."""
    assert joint.points is not None
    entry: dict[str, Any] = {"location": dict(zip(joint.bodies, joint.points, strict=True))}
    if joint.axes is not None:
        entry[key] = dict(zip(joint.bodies, joint.axes, strict=True))
    if joint.turns is not None:
        entry["axes"] = {
            body: {"quaternion": quaternion(turn)} for body, turn in zip(joint.bodies, joint.turns, strict=True)
        }
    return entry


def _parameters(mechanism: ImportedMechanism) -> dict[Quantity, str]:
    """The numbers that occur often, each with the name of its parameter."""
    count: Counter[tuple[str, Quantity]] = Counter()
    for entry in [*(_body(part) for part in mechanism.parts.values()), *mechanism.forces.values()]:
        count.update(_quantities(entry))
    for joint in mechanism.joints.values():
        count.update(_quantities(joint.keys))
    parameters: dict[Quantity, str] = {}
    used: Counter[str] = Counter()
    for (key, quantity), often in count.items():
        if often >= OFTEN and quantity.value and quantity not in parameters:
            used[key] += 1
            parameters[quantity] = key if used[key] == 1 else f"{key}_{used[key]}"
    return parameters


def _quantities(entry: Mapping[str, Any]) -> Iterator[tuple[str, Quantity]]:
    for key, value in entry.items():
        if isinstance(value, Quantity) and key in SHARED:
            yield key, value
        elif isinstance(value, Mapping):
            yield from _quantities(value)


def _with_names(entry: Mapping[str, Any], names: Mapping[Quantity, str]) -> dict[str, Any]:
    """The entry with names of parameters in place of their numbers."""
    shared: dict[str, Any] = {}
    for key, value in entry.items():
        if isinstance(value, Quantity) and key in SHARED and value in names:
            shared[key] = Bare(names[value])
        else:
            shared[key] = _with_names(value, names) if isinstance(value, Mapping) else value
    return shared


# --- Faults that keep an imported scene from running ------------------------------------------------------------------
# Couplers that it refuses, loops of rounded numbers, open loops.


#: Gaps of loops up to this, in m or rad, come from rounded numbers of the model: 0.1 mm.
ROUNDED = 1e-4


def without_refused(mechanism: ImportedMechanism, version: str) -> tuple[str, list[Problem]]:
    """The text of the scene without the couplers that its compilation refuses, and the other problems of compiling
    it."""
    from mbproj.equations.assembly.compiled import compile_system, needed, rounded_up
    from mbproj.model.compile.mechanism import initial_guess
    from mbproj.scene.scene import read_scene_text

    _say_open(mechanism)
    _join_limits(mechanism)
    while True:
        text = scene_text(mechanism, version)
        try:
            scene = read_scene_text(text, mechanism.file)
            system = compile_system(scene)
        except InputError as error:
            couplers = [name for name, joint in mechanism.joints.items() if joint.type == "coupler"]
            refused = {
                name: problem.message
                for problem in error.problems
                for name in couplers
                if f"'{name}'" in problem.message
            }
            if not refused:
                return text, list(error.problems)
            for name, why in refused.items():
                joint = mechanism.joints.pop(name)
                _drop_follower(mechanism, name)
                mechanism.say(f"coupler '{name}'", joint.place, f"left out: {why}", Same.NO)
        else:
            size = needed(system, initial_guess(scene, system).q)
            if 0.0 < size <= ROUNDED:
                mechanism.adjust = rounded_up(size)
                what = f"close where joints move by up to {1e6 * size:.3g} um: the scene has adjust_joints"
                mechanism.say("loops of rounded numbers", None, what, Same.YES)
                text = scene_text(mechanism, version)
            return text, []


def _drop_follower(mechanism: ImportedMechanism, coupler: str) -> None:
    """Remove the massless body that only this coupler moves, its joint, and the forces on this joint."""
    body, joint = mechanism.followers.pop(coupler, ("", ""))
    if body:
        del mechanism.parts[body], mechanism.joints[joint]
        mechanism.forces = {name: force for name, force in mechanism.forces.items() if force.get("joint") != joint}


def _join_limits(mechanism: ImportedMechanism) -> None:
    """Give one of two coupled coordinates the limits of both. Two rigid stops that close at one time would share a load
    in an undetermined way."""
    for coupler in [joint for joint in mechanism.joints.values() if joint.type == "coupler"]:
        of, constant = dict(coupler.keys["of"]), float(coupler.keys.get("constant", 0.0))
        if len(of) != 2 or "function" in coupler.keys or not all(of.values()):
            continue
        (follower, weight), (leader, other) = of.items()
        follower_limit, leader_limit = _limit_of(mechanism, follower), _limit_of(mechanism, leader)
        if follower_limit is None or leader_limit is None:
            continue
        ends = sorted((constant - weight * end) / other for end in _ends(follower_limit))
        low, high = (
            choose(pair) for choose, pair in zip((max, min), zip(ends, _ends(leader_limit), strict=True), strict=True)
        )
        if not low <= 0.0 <= high or low == high:  # the pose is beyond the limit of the other coordinate
            continue
        unit = next(end.unit for end in leader_limit if end is not None)
        both = [Quantity(end, unit) if np.isfinite(end) else None for end in (low, high)]
        _set_limit(mechanism, leader, both)
        _set_limit(mechanism, follower, None)
        what = f"joined with that of '{leader}': '{coupler.name}' couples them"
        mechanism.say(f"limit of '{follower}'", coupler.place, what, Same.YES)


_Range = list[Quantity | None]


def _limit_of(mechanism: ImportedMechanism, name: str) -> _Range | None:
    joint, _, coordinate = name.partition(".")
    limit = mechanism.joints[joint].keys.get("limits", {}).get(coordinate)
    return None if limit is None else limit["range"]


def _ends(limit: _Range) -> list[float]:
    return [sign * np.inf if end is None else end.value for sign, end in zip((-1.0, 1.0), limit, strict=True)]


def _set_limit(mechanism: ImportedMechanism, name: str, limit: _Range | None) -> None:
    joint, _, coordinate = name.partition(".")
    keys = dict(mechanism.joints[joint].keys)
    limits = {key: value for key, value in keys.pop("limits").items() if key != coordinate or limit is not None}
    if limit is not None:
        limits[coordinate] = limits[coordinate] | {"range": limit}
    keys |= {"limits": limits} if limits else {}
    mechanism.joints[joint] = replace(mechanism.joints[joint], keys=keys)


def _say_open(mechanism: ImportedMechanism) -> None:
    """Add a row on the loops that are open where the model begins: the assembly of a run closes them."""
    loops = [
        joint for joint in mechanism.joints.values() if joint.name not in mechanism.tree and joint.type != "distance"
    ]
    gaps = [_gap(mechanism, joint) for joint in loops if joint.points is not None]
    opened = [(apart, turned) for apart, turned in gaps if max(apart, turned) > ROUNDED]
    if opened:
        apart, turned = np.max(opened, axis=0)
        what = f"up to {apart:.2g} m and {np.degrees(turned):.3g} deg apart: the scene is assembled from there;"
        what += " 'mbproj branches' lists other assemblies"
        mechanism.say(f"{len(opened)} of {len(gaps)} loops, open where the model begins", None, what, Same.YES)


def _gap(mechanism: ImportedMechanism, joint: Connection) -> tuple[float, float]:
    """The distance of the two ends of a joint in m, and the angle between them in rad."""
    assert joint.points is not None
    first, second = (mechanism.part(body) for body in joint.bodies)
    ends = [end.position + end.rotation @ at for end, at in zip((first, second), joint.points, strict=True)]
    turned = 0.0
    if joint.turns is not None:
        across = (first.rotation @ joint.turns[0]).T @ (second.rotation @ joint.turns[1])
        turned = float(np.arccos(np.clip(0.5 * (np.trace(across) - 1.0), -1.0, 1.0)))
    elif joint.axes is not None and joint.type != "universal":
        axes = first.rotation @ joint.axes[0], second.rotation @ joint.axes[1]
        turned = float(np.arctan2(np.linalg.norm(np.cross(*axes)), axes[0] @ axes[1]))
    return float(np.linalg.norm(ends[1] - ends[0])), turned
