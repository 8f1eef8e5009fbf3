"""Coordinates that a force acts along: those of joints, lines between points, lengths of ropes, and sums of these."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.formats.mechanism import Bare, ImportedMechanism, ImportedNames
from mbproj.formats.mjcf.drives import free_symbol
from mbproj.formats.mjcf.joints import HINGE, SLIDE
from mbproj.formats.mjcf.laws import summed
from mbproj.formats.mjcf.tendons.measured import ModelTendons
from mbproj.formats.mjcf.tendons.paths import is_path

#: The reason for the table where a scene has no force along a coordinate of the model.
NOTHING = "a scene has no force along what it pulls"


@dataclass(frozen=True, eq=False)
class ActuatedCoordinate:
    """A coordinate s that an actuator acts along, with length = factor (start + s). `entry` has the first keys of its
    force in the scene; `s`, `force` and `free` are the scene's words for the coordinate, the force and the free
    length. `unit` is that of s."""

    entry: Mapping[str, Any]
    s: str
    force: str
    free: str
    unit: str
    factor: float
    start: float


def along_of(tendons: ModelTendons, number: int) -> list[ActuatedCoordinate] | str:
    """The coordinates that an actuator acts along, or the reason why there are none."""
    import mujoco

    model, of = tendons.compiled.model, mujoco.mjtTrn
    kind, what = int(model.actuator_trntype[number]), int(model.actuator_trnid[number][0])
    gear = float(model.actuator_gear[tendons.compiled.output(number)][0])
    if kind in (int(of.mjTRN_JOINT), int(of.mjTRN_JOINTINPARENT)):
        return _of_joints(tendons, {what: 1.0}, gear)
    if kind == int(of.mjTRN_TENDON):
        return along_tendon(tendons, what, gear)
    return NOTHING


def along_tendon(tendons: ModelTendons, number: int, factor: float = 1.0) -> list[ActuatedCoordinate] | str:
    """The coordinates whose sum is the length of a tendon: lines between two sites, ropes, or those of joints. Else the
    reason why there are none."""
    if not is_path(tendons.compiled, number):
        return _of_joints(tendons, tendons.joints(number), factor)
    if wrong := tendons.wrong(number):
        return wrong
    coordinates: list[ActuatedCoordinate] = []
    tendons.acting.add(number)
    for at, branch in enumerate(tendons.branches(number)):
        line, weight = tendons.ends(branch), factor * branch.weight
        start = tendons.constant(number) / branch.weight if not at else 0.0
        if line is None:
            rope = {"type": "linear_spring_damper", "joint": tendons.rope(number, at), "coordinate": "length"}
            coordinates.append(
                ActuatedCoordinate(rope, "displacement", "force", "free_displacement", "m", weight, start)
            )
        else:
            rod = {"type": "spring_damper", "bodies": list(line[0]), "locations": dict(zip(*line, strict=True))}
            coordinates.append(ActuatedCoordinate(rod, "l", "force", "free_length", "m", weight, start))
    return coordinates or "nothing changes its length"


def _of_joints(tendons: ModelTendons, weights: Mapping[int, float], factor: float) -> list[ActuatedCoordinate] | str:
    """The coordinates of joints, with their weights; or the reason where a joint has none."""
    coordinates = [_on_joint(tendons, joint, factor * weight) for joint, weight in weights.items()]
    known = [each for each in coordinates if each is not None]
    return known if known and len(known) == len(coordinates) else NOTHING


def _on_joint(tendons: ModelTendons, joint: int, factor: float) -> ActuatedCoordinate | None:
    model = tendons.compiled.model
    turns = int(model.jnt_type[joint]) == HINGE
    where = tendons.coordinate(joint)
    if where is None or int(model.jnt_type[joint]) not in (HINGE, SLIDE):
        return None
    entry: dict[str, Any] = {"type": "torsion_spring_damper" if turns else "linear_spring_damper", "joint": where[0]}
    if where[1] not in ("angle", "displacement") or tendons.mechanism.joints[where[0]].type == "cylindrical":
        entry["coordinate"] = where[1]
    s, force = ("angle", "torque") if turns else ("displacement", "force")
    start = float(tendons.compiled.data.qpos[model.jnt_qposadr[joint]])
    return ActuatedCoordinate(entry, s, force, f"free_{s}", "rad" if turns else "m", factor, start)


def length_of(along: list[ActuatedCoordinate], names: list[str]) -> tuple[str, str]:
    """The expressions of the length that the coordinates sum up to, and of its rate; `names` are those of the forces
    along the coordinates."""
    seen = []
    for each, name in zip(along, names, strict=True):
        of = (
            f"{each.entry['joint']}.{each.entry.get('coordinate', each.s)}"
            if "joint" in each.entry
            else f"{name}.length"
        )
        seen.append(of.replace("-", "_"))
    start = (sum(each.factor * each.start for each in along), "1")
    return summed([start, *_terms(along, seen, "")]), summed(_terms(along, seen, "_dot"))


def _terms(along: list[ActuatedCoordinate], seen: list[str], ending: str) -> list[tuple[float, str]]:
    return [(each.factor, name + ending) for each, name in zip(along, seen, strict=True)]


def names_along(mechanism: ImportedMechanism, name: str, along: list[ActuatedCoordinate]) -> list[str]:
    """Free names for the forces along the coordinates."""
    names: list[str] = []
    for _ in along:
        names.append(ImportedNames(frozenset([*mechanism.forces, *names])).unused(name))
    return names


def act_along(
    mechanism: ImportedMechanism, name: str, along: list[ActuatedCoordinate], names: list[str], force: str
) -> None:
    """Add a signal with the expression `force`, and forces along each coordinate that are factor times the signal."""
    signal = free_symbol(mechanism, f"{name}_force")
    mechanism.signals[signal] = Bare(force)
    for own, each in zip(names, along, strict=True):
        mechanism.forces[own] = {**each.entry, each.force: Bare(summed([(each.factor, signal)]))}
