"""A scene that moves faster, or whose springs or dampers are stiffer."""

from __future__ import annotations

import math
from dataclasses import replace

from mbproj.errors import InputError, Problem
from mbproj.functions.program import TIME
from mbproj.scene.records import BodyForce, Bushing, Force, JointForce, Law, Motion, Scene, Vector
from mbproj.scene.stops import DistanceStop, Limit, PlaneStop, StopLaw
from mbproj.studies.variants.programs import with_argument
from mbproj.studies.variants.rescaled import scaled_matrix


def with_speed(scene: Scene, factor: float) -> Scene:
    """The start's velocities times a factor, and the motions so many times as fast; gravity and forces stay."""
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
    """Every stiffness times a factor, those of stops too; dampers, tables and functions stay."""
    return _with_laws(scene, "stiffness", factor)


def with_damping(scene: Scene, factor: float) -> Scene:
    """Every damping times a factor; springs, tables and functions stay."""
    return _with_laws(scene, "damping", factor)


def _with_laws(scene: Scene, of: str, factor: float) -> Scene:
    """The `stiffness` or the `damping` of every law, bushing and compliant stop times a factor."""
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
            return replace(force, laws={name: scaled(law) for name, law in force.laws.items()})
        if isinstance(force, Bushing):
            (k_t, k_r), (c_t, c_r) = force.stiffness, force.damping
            stiffness = scaled_matrix(k, k_t), scaled_matrix(k, k_r)
            return replace(force, stiffness=stiffness, damping=(scaled_matrix(c, c_t), scaled_matrix(c, c_r)))
        return replace(force, law=scaled(force.law))

    return replace(
        scene,
        forces=tuple(map(changed, scene.forces)),
        joints=tuple(
            replace(joint, limits={name: limit(old) for name, old in joint.limits.items()}) for joint in scene.joints
        ),
    )


def _gives(law: StopLaw, of: str) -> bool:
    """Whether a stop has a stiffness that can vary, or a damping."""
    value = getattr(law, of)
    return value is not None and 0.0 < value < math.inf


def _has(force: Force, of: str) -> bool:
    """Whether a force has any stiffness, or damping."""
    if isinstance(force, BodyForce):
        return False
    if isinstance(force, Bushing):
        return any(any(row) for matrix in getattr(force, of) for row in matrix)
    if isinstance(force, DistanceStop | PlaneStop):
        return _gives(force.limit.law if isinstance(force, DistanceStop) else force.law, of)
    laws = force.laws.values() if isinstance(force, JointForce) else [force.law]
    return any(getattr(law, of) > 0.0 for law in laws)
