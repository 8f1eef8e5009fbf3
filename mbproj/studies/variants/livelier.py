"""A scene that moves faster, or whose springs are stiffer."""

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
    if not any(_is_elastic(force) for force in scene.forces):
        what = "no force of the scene has a 'stiffness' to vary"
        raise InputError(Problem(what, hint="add a spring_damper, or vary something else"))

    def stiffer(law: Law) -> Law:
        return replace(law, stiffness=factor * law.stiffness)

    def changed(force: Force) -> Force:
        if isinstance(force, BodyForce):
            return force
        if isinstance(force, JointForce):
            return replace(force, laws={name: stiffer(law) for name, law in force.laws.items()})
        if isinstance(force, Bushing):
            translation, rotation = (scaled_matrix(factor, matrix) for matrix in force.stiffness)
            return replace(force, stiffness=(translation, rotation))
        return replace(force, law=stiffer(force.law))

    return replace(scene, forces=tuple(map(changed, scene.forces)))


def _is_elastic(force: Force) -> bool:
    """Whether a force has a stiffness."""
    if isinstance(force, BodyForce):
        return False
    if isinstance(force, Bushing):
        return any(any(row) for matrix in force.stiffness for row in matrix)
    laws = force.laws.values() if isinstance(force, JointForce) else [force.law]
    return any(law.stiffness > 0.0 for law in laws)
