"""Coordinates that a force acts along: those of joints, sums of them, and the line between two points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.formats.chains import Coordinates
from mbproj.formats.mechanism import Bare, Mechanism, Names
from mbproj.formats.mjcf.compiled import Compiled
from mbproj.formats.mjcf.drives import free_symbol
from mbproj.formats.mjcf.joints import HINGE, SLIDE, joint_name
from mbproj.formats.mjcf.laws import summed
from mbproj.formats.mjcf.parts import Called


@dataclass(frozen=True, eq=False)
class Along:
    """A coordinate s that an actuator acts along, with length = factor (start + s): what its force begins with, the
    words of the scene for s and the force, and units."""

    entry: Mapping[str, Any]
    s: str
    force: str
    free: str
    unit: str
    factor: float
    start: float


def along_of(
    compiled: Compiled, mechanism: Mechanism, called: Called, coordinates: Coordinates, number: int
) -> list[Along] | None:
    """The coordinates that an actuator acts along; None where it acts along none."""
    import mujoco

    model, of = compiled.model, mujoco.mjtTrn
    kind, what = int(model.actuator_trntype[number]), int(model.actuator_trnid[number][0])
    gear = float(model.actuator_gear[number][0])
    if kind in (int(of.mjTRN_JOINT), int(of.mjTRN_JOINTINPARENT)):
        return _of_joints(compiled, mechanism, called, coordinates, {what: 1.0}, gear)
    if kind == int(of.mjTRN_TENDON):
        return along_tendon(compiled, mechanism, called, coordinates, what, gear)
    return None


def along_tendon(
    compiled: Compiled,
    mechanism: Mechanism,
    called: Called,
    coordinates: Coordinates,
    number: int,
    factor: float = 1.0,
) -> list[Along] | None:
    """The line between two sites, or the coordinates in a sum; None of other tendons."""
    line = two_points(compiled, mechanism, called, number)
    if line is not None:
        entry = {"type": "spring_damper", "bodies": list(line[0]), "locations": dict(zip(*line, strict=True))}
        return [Along(entry, "l", "force", "free_length", "m", factor, 0.0)]
    weights = tendon_weights(compiled, number)
    return _of_joints(compiled, mechanism, called, coordinates, weights or {}, factor)


def _of_joints(
    compiled: Compiled,
    mechanism: Mechanism,
    called: Called,
    coordinates: Coordinates,
    weights: Mapping[int, float],
    factor: float,
) -> list[Along] | None:
    """The coordinates of joints with weights; None where one of them has none."""
    found = [
        _on_joint(compiled, mechanism, called, coordinates, joint, factor * weight) for joint, weight in weights.items()
    ]
    known = [each for each in found if each is not None]
    return known if known and len(known) == len(found) else None


def _on_joint(
    compiled: Compiled, mechanism: Mechanism, called: Called, coordinates: Coordinates, joint: int, factor: float
) -> Along | None:
    model = compiled.model
    turns = int(model.jnt_type[joint]) == HINGE
    where = coordinates.get(joint_name(compiled, joint, called[int(model.jnt_bodyid[joint])]))
    if where is None or int(model.jnt_type[joint]) not in (HINGE, SLIDE):
        return None
    entry: dict[str, Any] = {"type": "torsion_spring_damper" if turns else "linear_spring_damper", "joint": where[0]}
    if where[1] not in ("angle", "displacement") or mechanism.joints[where[0]].type == "cylindrical":
        entry["coordinate"] = where[1]
    s, force = ("angle", "torque") if turns else ("displacement", "force")
    start = float(compiled.data.qpos[model.jnt_qposadr[joint]])
    return Along(entry, s, force, f"free_{s}", "rad" if turns else "m", factor, start)


def length_of(along: list[Along], names: list[str]) -> tuple[str, str]:
    """The sum of the coordinates as an expression, and its rate; `names` are those of the forces along them."""
    seen = []
    for each, name in zip(along, names, strict=True):
        of = (
            f"{each.entry['joint']}.{each.entry.get('coordinate', each.s)}"
            if "joint" in each.entry
            else f"{name}.length"
        )
        seen.append(of.replace("-", "_"))
    start = (sum(each.factor * each.start for each in along), "1")
    return summed([start, *_weighed(along, seen, "")]), summed(_weighed(along, seen, "_dot"))


def _weighed(along: list[Along], seen: list[str], ending: str) -> list[tuple[float, str]]:
    return [(each.factor, name + ending) for each, name in zip(along, seen, strict=True)]


def names_along(mechanism: Mechanism, name: str, along: list[Along]) -> list[str]:
    """Names of the forces along the coordinates."""
    names: list[str] = []
    for _ in along:
        names.append(Names(frozenset([*mechanism.forces, *names])).own(name))
    return names


def act_along(mechanism: Mechanism, name: str, along: list[Along], names: list[str], force: str) -> None:
    """One force, a signal that all may read, acts along each coordinate by its factor."""
    signal = free_symbol(mechanism, f"{name}_force")
    mechanism.signals[signal] = Bare(force)
    for own, each in zip(names, along, strict=True):
        mechanism.forces[own] = {**each.entry, each.force: Bare(summed([(each.factor, signal)]))}


def two_points(
    compiled: Compiled, mechanism: Mechanism, called: Called, number: int
) -> tuple[tuple[str, str], Array] | None:
    """The bodies that a straight tendon between two sites joins, and a point (2, 3) in each; None of other tendons."""
    import mujoco

    model, data = compiled.model, compiled.data
    first, count = int(model.tendon_adr[number]), int(model.tendon_num[number])
    kinds = model.wrap_type[first : first + count]
    if count != 2 or any(kind != int(mujoco.mjtWrap.mjWRAP_SITE) for kind in kinds):
        return None
    sites = model.wrap_objid[first : first + 2]
    bodies = [called[int(model.site_bodyid[site])] for site in sites]
    if bodies[0] == bodies[1]:
        return None
    points = [mechanism.part(body).local(data.site_xpos[site]) for body, site in zip(bodies, sites, strict=True)]
    return (bodies[0], bodies[1]), np.array(points)


def tendon_weights(compiled: Compiled, number: int) -> dict[int, float] | None:
    """The weights of joints in a tendon; None where it goes over sites."""
    import mujoco

    model = compiled.model
    if number < 0:
        return None
    first = int(model.tendon_adr[number])
    found: dict[int, float] = {}
    for at in range(first, first + int(model.tendon_num[number])):
        if int(model.wrap_type[at]) != int(mujoco.mjtWrap.mjWRAP_JOINT):
            return None
        found[int(model.wrap_objid[at])] = float(model.wrap_prm[at])
    return found
