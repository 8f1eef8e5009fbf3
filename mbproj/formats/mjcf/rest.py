"""What else stands in an MJCF model: actuators, contacts, tendons, keyframes. Each is said, or used on request."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.formats.chains import Coordinates, free_name
from mbproj.formats.mechanism import Mechanism, Quantity, Same, Wishes
from mbproj.formats.mjcf.compiled import Compiled
from mbproj.formats.mjcf.joints import FREE, HINGE, joint_name
from mbproj.formats.mjcf.looks import CAPSULE, PLANE, SPHERE
from mbproj.formats.mjcf.parts import Called
from mbproj.formats.mjcf.tendons import add_tendons
from mbproj.scene.records import GROUND


def say_rest(
    compiled: Compiled, mechanism: Mechanism, called: Called, coordinates: Coordinates, wishes: Wishes
) -> None:
    """Rows on all that is no body, no joint and no loop."""
    _actuators(compiled, mechanism, called, coordinates, wishes)
    _contacts(compiled, mechanism, called, wishes)
    add_tendons(compiled, mechanism, called)
    _keyframes(compiled, mechanism, wishes)
    _surroundings(compiled, mechanism)


def _actuators(
    compiled: Compiled, mechanism: Mechanism, called: Called, coordinates: Coordinates, wishes: Wishes
) -> None:
    """A servo's law is force = gain ctrl + b₀ + b₁ length + b₂ velocity; on request it holds its `ctrl` as a spring."""
    import mujoco

    model, data = compiled.model, compiled.data
    for number in range(model.nu):
        name = compiled.name("actuator", number) or f"actuator_{number}"
        place = compiled.place_in("actuator", name)
        gain, bias = model.actuator_gainprm[number], model.actuator_biasprm[number]
        affine = int(model.actuator_biastype[number]) == int(mujoco.mjtBias.mjBIAS_AFFINE)
        joint = int(model.actuator_trnid[number][0])
        on_joint = int(model.actuator_trntype[number]) == int(mujoco.mjtTrn.mjTRN_JOINT)
        where = coordinates.get(joint_name(compiled, joint, called[int(model.jnt_bodyid[joint])])) if on_joint else None
        shown = f"actuator '{name}'"
        fixed = int(model.actuator_dyntype[number]) == int(mujoco.mjtDyn.mjDYN_NONE)
        own = int(model.actuator_biastype[number]) != int(mujoco.mjtBias.mjBIAS_NONE)
        for word, values in (
            ("armature", getattr(model, "actuator_armature", None)),
            ("damping", getattr(model, "actuator_damping", None)),
        ):
            if values is not None and np.any(values[number]):
                mechanism.say(f"{word} of {shown}", place, "left out: give it to the joint", Same.NO)
        if not own or (affine and not bias[:3].any()):
            mechanism.say(shown, place, "left out: it exerts nothing without a control signal", Same.UNTIL)
        elif not wishes.hold:
            what = "left out: a servo needs a control signal; --hold makes a spring and a damper of it"
            mechanism.say(shown, place, what, Same.NO)
        elif where is None or not fixed or (not bias[1] and (bias[0] or gain[0] * data.ctrl[number])):
            what = "left out: it has states, pushes without a spring, or acts on no coordinate of a joint"
            mechanism.say(shown, place, what, Same.NO)
        else:
            gear = float(model.actuator_gear[number][0])
            stiffness, damping = -float(bias[1]) * gear**2, -float(bias[2]) * gear**2
            push = gear * (float(gain[0]) * float(data.ctrl[number]) + float(bias[0]))
            at = float(data.qpos[model.jnt_qposadr[joint]])
            turns = int(model.jnt_type[joint]) == HINGE
            _hold(mechanism, name, where, turns, stiffness, damping, (push / stiffness if stiffness else 0.0) - at)
            mechanism.say(
                shown, place, "holds its control signal of the keyframe, or 0: a spring and a damper", Same.UNTIL
            )


def _hold(
    mechanism: Mechanism, name: str, where: tuple[str, str], turns: bool, stiffness: float, damping: float, rest: float
) -> None:
    entry: dict[str, Any] = {"type": "torsion_spring_damper" if turns else "linear_spring_damper", "joint": where[0]}
    if where[1] not in ("angle", "displacement") or mechanism.joints[where[0]].type == "cylindrical":
        entry["coordinate"] = where[1]
    if stiffness:
        entry["stiffness"] = Quantity(stiffness, "N*m/rad" if turns else "N/m")
        entry["free_angle" if turns else "free_displacement"] = Quantity(rest, "rad" if turns else "m")
    if damping:
        entry["damping"] = Quantity(damping, "N*m*s/rad" if turns else "N*s/m")
    mechanism.forces[free_name(mechanism, name)] = entry


def _contacts(compiled: Compiled, mechanism: Mechanism, called: Called, wishes: Wishes) -> None:
    """Shapes that may touch. On request a sphere, or the end of a capsule, above a plane of the ground is a stop."""
    model = compiled.model
    touching = np.flatnonzero((model.geom_contype != 0) | (model.geom_conaffinity != 0))
    moving = [geom for geom in touching if called[int(model.geom_bodyid[geom])] != GROUND]
    if not moving or compiled.disables("CONTACT"):
        return
    stops = 0
    planes = [geom for geom in touching if int(model.geom_type[geom]) == PLANE and geom not in moving]
    for plane in planes if wishes.contacts else []:
        stops += sum(_stops(compiled, mechanism, called, int(geom), int(plane)) for geom in moving)
    what = "left out: shapes pass through each other"
    if planes and not wishes.contacts:
        what += "; --contacts makes stops of spheres and capsules above planes"
    elif stops:
        what = (
            f"{stops} spheres above planes are rigid stops without friction; all other shapes pass through each other"
        )
    mechanism.say(f"contacts of {len(moving)} shapes", None, what, Same.UNTIL)


def _stops(compiled: Compiled, mechanism: Mechanism, called: Called, geom: int, plane: int) -> int:
    model, data = compiled.model, compiled.data
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    matrix = data.geom_xmat[geom].reshape(3, 3)
    shifts = {SPHERE: [0.0], CAPSULE: [-size[1], size[1]]}.get(kind, [])
    body = called[int(model.geom_bodyid[geom])]
    normal, origin = data.geom_xmat[plane].reshape(3, 3)[:, 2], data.geom_xpos[plane]
    for shift in shifts:
        centre = data.geom_xpos[geom] + shift * matrix[:, 2]
        name = free_name(mechanism, f"{compiled.name('geom', geom) or body}_on_plane")
        mechanism.forces[name] = {
            "type": "stop",
            "plane": {"body": GROUND, "location": np.array(origin), "normal": np.array(normal)},
            "point": {"body": body, "location": {body: mechanism.parts[body].local(centre)}},
            "radius": Quantity(float(size[0]), "m"),
            "rigid": True,
        }
    return len(shifts)


def _keyframes(compiled: Compiled, mechanism: Mechanism, wishes: Wishes) -> None:
    model = compiled.model
    names = [model.key(number).name or str(number) for number in range(model.nkey)]
    if names:
        begins = f"begins at '{wishes.key}'" if wishes.key else "begins at the model's reference pose"
        what = f"the scene {begins}; --at takes one of {', '.join(names[:8])}"
        mechanism.say(f"{len(names)} keyframes", None, what, Same.YES)


def _surroundings(compiled: Compiled, mechanism: Mechanism) -> None:
    """A medium, and parts that only look or measure."""
    model = compiled.model
    option = next((e for e in compiled.source.root.all("option")), None)
    place = option.place if option else None
    if model.opt.density or model.opt.viscosity:
        mechanism.say("medium with density or viscosity", place, "left out: a scene has none", Same.NO)
    if model.nu and np.any(model.jnt_actfrclimited[model.jnt_type != FREE]):
        mechanism.say("limits of actuators' forces", None, "left out", Same.UNTIL)
    for count, what in ((model.nsensor, "sensors"), (model.ncam, "cameras")):
        if count:
            mechanism.say(f"{count} {what}", None, "left out: they have no say in the motion", Same.YES)
    if model.nflex:
        what = "left out: a scene has no flexible bodies, and their parts move apart"
        mechanism.say(f"{model.nflex} flexible bodies", None, what, Same.NO)
    if model.nplugin:
        mechanism.say(f"{model.nplugin} plugins", None, "left out", Same.NO)
