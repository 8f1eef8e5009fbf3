"""The springs, dampers, friction, inertias and limits on joint coordinates, in the form that other formats have."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from mbproj.dataclass import dataclass
from mbproj.elements import Kind
from mbproj.formats.mechanism import Same
from mbproj.joints import JOINTS
from mbproj.scene.blocks.elements import SPRINGS
from mbproj.scene.friction import DryFriction
from mbproj.scene.read import Scene
from mbproj.scene.records import Joint, JointForce, Law
from mbproj.scene.stops import Limit

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
    return next(name for name, own in units.items() if unit in (None, own))


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
