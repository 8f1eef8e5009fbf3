"""Faults that keep an imported scene from running: couplers that it refuses, loops of rounded numbers, open loops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.errors import InputError, Problem
from mbproj.formats.as_scene import scene_text
from mbproj.formats.mechanism import Connection, ImportedMechanism, Quantity, Same

#: Gaps of loops up to this, in m or rad, come from rounded numbers of the model: 0.1 mm.
ROUNDED = 1e-4


def without_refused(mechanism: ImportedMechanism, version: str) -> tuple[str, list[Problem]]:
    """The text of the scene without the couplers that its compilation refuses, and the other problems of compiling
    it."""
    from mbproj.dynamics.assembly.adjust import compile_system, needed, rounded_up
    from mbproj.model import initial_guess
    from mbproj.scene import read_scene_text

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
        own, kept = _limit_of(mechanism, follower), _limit_of(mechanism, leader)
        if own is None or kept is None:
            continue
        ends = sorted((constant - weight * end) / other for end in _ends(own))
        low, high = (choose(pair) for choose, pair in zip((max, min), zip(ends, _ends(kept), strict=True), strict=True))
        if not low <= 0.0 <= high or low == high:  # the pose is beyond the limit of the other coordinate
            continue
        unit = next(end.unit for end in kept if end is not None)
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
