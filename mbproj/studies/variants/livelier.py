"""Variants of a scene that move faster, or have stiffer springs or dampers."""

from __future__ import annotations

import math
from dataclasses import replace

from mbproj.elements import Kind
from mbproj.errors import InputError, Problem
from mbproj.functions.program import TIME
from mbproj.scene.blocks.elements import element_type
from mbproj.scene.expressions.units import DAMPING, STIFFNESS, TORSION_DAMPING, TORSION_STIFFNESS
from mbproj.scene.fields.quantities import dimension_of
from mbproj.scene.read import Scene
from mbproj.scene.records import BodyForce, Bushing, Force, JointForce, Law, Motion, Vector
from mbproj.scene.stops import DistanceStop, Limit, PlaneStop, StopLaw
from mbproj.studies.variants.programs import with_argument
from mbproj.studies.variants.rescaled import scaled_matrix


def with_speed(scene: Scene, factor: float) -> Scene:
    """Multiply the start's velocities and the speed of all motions by a factor. Gravity and forces stay."""
    moving = any(any(body.velocity) or any(body.angular_velocity) for body in scene.bodies)
    if not (moving or scene.motions or any(any(joint.speed.values()) for joint in scene.joints)):
        what = "the scene starts at rest and has no motions: there is no speed to vary"
        raise InputError(Problem(what, hint="give a joint a 'speed', or a body a 'velocity'"))

    def faster(vector: Vector) -> Vector:
        x, y, z = vector
        return factor * x, factor * y, factor * z

    def driven(motion: Motion) -> Motion:
        return replace(motion, function=with_argument(motion.function, TIME, factor))

    return replace(
        scene,
        bodies=tuple(
            replace(body, velocity=faster(body.velocity), angular_velocity=faster(body.angular_velocity))
            for body in scene.bodies
        ),
        joints=tuple(
            replace(joint, speed={name: factor * value for name, value in joint.speed.items()})
            for joint in scene.joints
        ),
        motions=tuple(map(driven, scene.motions)),
    )


def with_stiffness(scene: Scene, factor: float) -> Scene:
    """Multiply every stiffness by a factor, also those of stops. Dampers, tables and functions stay."""
    return _with_laws(scene, "stiffness", factor)


def with_damping(scene: Scene, factor: float) -> Scene:
    """Multiply every damping by a factor. Springs, tables and functions stay."""
    return _with_laws(scene, "damping", factor)


def _with_laws(scene: Scene, of: str, factor: float) -> Scene:
    """Multiply the `stiffness` or the `damping` of every law, bushing and compliant stop by a factor. `of` names
    which."""
    limits = [limit.law for joint in scene.joints for limit in joint.limits.values()]
    if not any(_has(force, of) for force in scene.forces) and not any(_gives(law, of) for law in limits):
        what = f"no force of the scene has a '{of}' to vary"
        raise InputError(Problem(what, hint="add a spring_damper, or vary something else"))

    k, c = (factor, 1.0) if of == "stiffness" else (1.0, factor)

    def scaled(law: Law) -> Law:
        return replace(law, stiffness=k * law.stiffness, damping=c * law.damping)

    def stopping(law: StopLaw) -> StopLaw:
        damping = None if law.damping is None else c * law.damping
        return replace(law, stiffness=k * law.stiffness, damping=damping)

    def element(kind: Kind | None) -> Kind | None:
        if kind is None:
            return None
        own = _in_units(kind, of)
        return replace(kind, values={**kind.values, **{name: factor * kind.values[name] for name in own}})

    def limit(old: Limit) -> Limit:
        return replace(old, law=stopping(old.law))

    def changed(force: Force) -> Force:
        if isinstance(force, BodyForce):
            return force
        if isinstance(force, DistanceStop):
            return replace(force, limit=limit(force.limit))
        if isinstance(force, PlaneStop):
            return replace(force, law=stopping(force.law))
        if isinstance(force, JointForce):
            laws = {name: scaled(law) for name, law in force.laws.items()}
            return replace(force, laws=laws, element=element(force.element))
        if isinstance(force, Bushing):
            (k_t, k_r), (c_t, c_r) = force.stiffness, force.damping
            stiffness = scaled_matrix(k, k_t), scaled_matrix(k, k_r)
            return replace(force, stiffness=stiffness, damping=(scaled_matrix(c, c_t), scaled_matrix(c, c_r)))
        return replace(force, law=scaled(force.law), element=element(force.element))

    return replace(
        scene,
        forces=tuple(map(changed, scene.forces)),
        joints=tuple(
            replace(joint, limits={name: limit(old) for name, old in joint.limits.items()}) for joint in scene.joints
        ),
    )


def _gives(law: StopLaw, of: str) -> bool:
    """Whether a stop has a finite, positive stiffness, or damping."""
    value = getattr(law, of)
    return value is not None and 0.0 < value < math.inf


def _in_units(kind: Kind, of: str) -> list[str]:
    """The names of an element's numbers that are a stiffness, or a damping, by their units; torsional ones included."""
    able = (STIFFNESS, TORSION_STIFFNESS) if of == "stiffness" else (DAMPING, TORSION_DAMPING)
    units = element_type(kind.type).units
    return [
        name
        for name, value in kind.values.items()
        if isinstance(value, float) and dimension_of(units[name]) in able and value
    ]


def _has(force: Force, of: str) -> bool:
    """Whether a force has any stiffness, or damping."""
    if isinstance(force, BodyForce):
        return False
    if isinstance(force, Bushing):
        return any(any(row) for matrix in getattr(force, of) for row in matrix)
    if isinstance(force, DistanceStop | PlaneStop):
        return _gives(force.limit.law if isinstance(force, DistanceStop) else force.law, of)
    if force.element is not None:
        return bool(_in_units(force.element, of))
    laws = force.laws.values() if isinstance(force, JointForce) else [force.law]
    return any(getattr(law, of) > 0.0 for law in laws)
