"""Bodies of an MJCF model: those that move, with their inertia in body axes; those that do not are the ground."""

from __future__ import annotations

import numpy as np

from mbproj.errors import shortened
from mbproj.formats.geometry import from_quaternion
from mbproj.formats.mechanism import ImportedBody, ImportedMechanism, ImportedNames, Same
from mbproj.formats.mjcf.compiled import CompiledMjcf
from mbproj.scene.records import GROUND

#: The name in the scene of each body, by its number in the model.
Called = dict[int, str]


def add_parts(compiled: CompiledMjcf, mechanism: ImportedMechanism, names: ImportedNames) -> Called:
    """Add the bodies at the pose of the start, in the order of the model, which begins at the ground; return their
    names."""
    import mujoco

    model, data = compiled.model, compiled.data
    called: Called = {0: GROUND}
    still = []
    for number in range(1, model.nbody):
        if model.body_weldid[number] == 0:
            called[number] = GROUND
            still.append(compiled.name("body", number) or f"body_{number}")
            continue
        if not model.body_jntnum[number] and not model.body_mass[number] and not model.body_inertia[number].any():
            called[number] = called[int(model.body_parentid[number])]
            mechanism.mark(compiled.name("body", number) or f"body_{number}", called[number], data.xpos[number])
            continue
        called[number] = names.unused(compiled.name("body", number) or f"body_{number}")
        rotation = data.xmat[number].reshape(3, 3)
        inner = from_quaternion(model.body_iquat[number])
        inertia = inner @ np.diag(model.body_inertia[number]) @ inner.T
        velocity = np.zeros(6)  # angular, then that of the centre of mass, where mjOBJ_BODY has its origin
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, number, velocity, 0)
        mechanism.parts[called[number]] = ImportedBody(
            called[number],
            float(model.body_mass[number]),
            0.5 * (inertia + inertia.T),
            np.array(data.xipos[number]),
            np.array(rotation),
            compiled.place("body", number),
            velocity[3:].copy(),
            rotation.T @ velocity[:3],
        )
        _say_compensated(compiled, mechanism, number, called[number])
    if still:
        mechanism.say("bodies that cannot move", None, f"are part of the ground: {shortened(still, 5)}", Same.YES)
    return called


def _say_compensated(compiled: CompiledMjcf, mechanism: ImportedMechanism, number: int, name: str) -> None:
    """Add a constant force at the centre of mass for compensated gravity, with a row of the table."""
    part = float(compiled.model.body_gravcomp[number])
    if part:
        lift = -part * mechanism.parts[name].mass * mechanism.gravity
        mechanism.forces[f"{name}_compensation"] = {"type": "force", "body": name, "force": lift}
