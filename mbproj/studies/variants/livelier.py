"""A scene that moves faster, or whose springs or dampers are stiffer."""

from __future__ import annotations

from dataclasses import replace

from mbproj.errors import InputError, Problem
from mbproj.functions.program import TIME
from mbproj.scene.records import BodyForce, Bushing, Force, JointForce, Law, Motion, Scene, Vector
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
    """Every stiffness times a factor; dampers, tables and functions stay."""
    return _with_laws(scene, "stiffness", factor)


def with_damping(scene: Scene, factor: float) -> Scene:
    """Every damping times a factor; springs, tables and functions stay."""
    return _with_laws(scene, "damping", factor)


def _with_laws(scene: Scene, of: str, factor: float) -> Scene:
    """The `stiffness` or the `damping` of every law and bushing times a factor."""
    if not any(_has(force, of) for force in scene.forces):
        what = f"no force of the scene has a '{of}' to vary"
        raise InputError(Problem(what, hint="add a spring_damper, or vary something else"))

    k, c = (factor, 1.0) if of == "stiffness" else (1.0, factor)

    def scaled(law: Law) -> Law:
        return replace(law, stiffness=k * law.stiffness, damping=c * law.damping)

    def changed(force: Force) -> Force:
        if isinstance(force, BodyForce):
            return force
        if isinstance(force, JointForce):
            return replace(force, laws={name: scaled(law) for name, law in force.laws.items()})
        if isinstance(force, Bushing):
            (k_t, k_r), (c_t, c_r) = force.stiffness, force.damping
            stiffness = scaled_matrix(k, k_t), scaled_matrix(k, k_r)
            return replace(force, stiffness=stiffness, damping=(scaled_matrix(c, c_t), scaled_matrix(c, c_r)))
        return replace(force, law=scaled(force.law))

    return replace(scene, forces=tuple(map(changed, scene.forces)))


def _has(force: Force, of: str) -> bool:
    """Whether a force has any stiffness, or damping."""
    if isinstance(force, BodyForce):
        return False
    if isinstance(force, Bushing):
        return any(any(row) for matrix in getattr(force, of) for row in matrix)
    laws = force.laws.values() if isinstance(force, JointForce) else [force.law]
    return any(getattr(law, of) > 0.0 for law in laws)
