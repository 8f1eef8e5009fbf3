"""Joints of an MJCF model: hinges, slides, balls, free ones, and several between two bodies."""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.errors import Place, shortened
from mbproj.formats.chains import BodyTwist, Coordinates, Single, connect, span
from mbproj.formats.geometry import from_quaternion, quaternion
from mbproj.formats.mechanism import ImportedBody, ImportedMechanism, ImportedNames, Same
from mbproj.formats.mjcf.compiled import CompiledMjcf
from mbproj.scene.fields.rotations import to_matrix
from mbproj.scene.records import GROUND

# --- Bodies of an MJCF model ------------------------------------------------------------------------------------------
# Those that move, with their inertia in body axes; those that do not are the ground.


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


# --- Joints of an MJCF model ------------------------------------------------------------------------------------------


FREE, BALL, SLIDE, HINGE = range(4)


def add_joints(
    compiled: CompiledMjcf, mechanism: ImportedMechanism, called: Called, names: ImportedNames, coordinates: Coordinates
) -> None:
    """Connect each body that moves with its parent. `coordinates` gets those of hinges and slides, by name."""
    model = compiled.model
    for number in range(1, model.nbody):
        child = called[number]
        parent = called[int(model.body_parentid[number])]
        if child == parent:
            continue
        first, count = int(model.body_jntadr[number]), int(model.body_jntnum[number])
        kinds = [int(model.jnt_type[first + at]) for at in range(count)]
        if not count:
            place = compiled.place("body", number)
            mechanism.join(
                names.unused(f"{child}_weld"), "fixed", (parent, child), compiled.data.xpos[number], place=place
            )
        elif kinds[0] == FREE:
            _say_free(compiled, mechanism, first, child)
        elif BALL in kinds:
            _ball(compiled, mechanism, kinds, number, (parent, child), names, coordinates)
        else:
            singles = [single(compiled, mechanism, first + at, child) for at in range(count)]
            connect(mechanism, (parent, child), singles, names.unused, coordinates)


def single(compiled: CompiledMjcf, mechanism: ImportedMechanism, number: int, child: str) -> Single:
    """A hinge or a slide with all that acts on its coordinate, which counts from the pose of the start."""
    model, data = compiled.model, compiled.data
    dof, at = int(model.jnt_dofadr[number]), float(data.qpos[model.jnt_qposadr[number]])
    turns = int(model.jnt_type[number]) == HINGE
    name = joint_name(compiled, number, child)
    place = compiled.place("jnt", number) or compiled.place("body", int(model.jnt_bodyid[number]))
    limits = None
    if model.jnt_limited[number]:
        low, high = (float(each) - at for each in model.jnt_range[number])
        limits = span(mechanism, name, place, low, high)
        if limits is not None:
            what = "a stiff spring in MuJoCo, a rigid stop in the scene"
            mechanism.say(f"limit of joint '{name}'", place, what, Same.UNTIL)
    for word, at_word, called in (("jnt_stiffness", number, "stiffness"), ("dof_damping", dof, "damping")):
        if compiled.bent(word, at_word):
            what = f"its {called} that is not linear is left out"
            mechanism.say(f"joint '{name}'", place, what, Same.NO)
    _say_yield(compiled, mechanism, number, f"joint '{name}'", place)
    spring = float(model.qpos_spring[model.jnt_qposadr[number]]) - at
    stiffness = float(model.jnt_stiffness[number])
    return Single(
        name,
        turns,
        np.array(data.xanchor[number]),
        np.array(data.xaxis[number]),
        limits,
        stiffness,
        spring if stiffness else 0.0,
        float(model.dof_damping[dof]),
        float(model.dof_frictionloss[dof]),
        float(model.dof_armature[dof]),
        float(data.qvel[dof]),
        place,
    )


def _say_yield(
    compiled: CompiledMjcf, mechanism: ImportedMechanism, number: int, element: str, place: Place | None
) -> None:
    """Add a row on a spring that yields, as those of older versions of MuJoCo do not."""
    yields = getattr(compiled.model, "jnt_springyield", None)
    if yields is not None and yields[number] and compiled.model.jnt_stiffness[number]:
        what = "left out: the scene's spring stays elastic where MuJoCo's yields"
        mechanism.say(f"springyield of {element}", place, what, Same.UNTIL)


def joint_name(compiled: CompiledMjcf, number: int, child: str) -> str:
    """The name of a joint, or one made from the name of its body `child` where it has none."""
    name = compiled.name("jnt", number)
    if name:
        return name
    model = compiled.model
    first = int(model.body_jntadr[model.jnt_bodyid[number]])
    alone = int(model.body_jntnum[model.jnt_bodyid[number]]) == 1
    return f"{child}_joint" if alone else f"{child}_joint_{number - first + 1}"


def start_of(compiled: CompiledMjcf, called: Called) -> dict[str, float]:
    """The model's coordinates of hinges and slides at the pose of the start, by name, in rad and m."""
    model, start = compiled.model, {}
    for number in range(model.njnt):
        if int(model.jnt_type[number]) in (HINGE, SLIDE):
            name = joint_name(compiled, number, called[int(model.jnt_bodyid[number])])
            start[name] = float(compiled.data.qpos[model.jnt_qposadr[number]])
    return start


def _say_free(compiled: CompiledMjcf, mechanism: ImportedMechanism, number: int, child: str) -> None:
    """Add rows on a free joint, which a scene does not need. Springs and other effects on its coordinates are left
    out."""
    model, dof = compiled.model, int(compiled.model.jnt_dofadr[number])
    place = compiled.place("jnt", number) or compiled.place("body", int(model.jnt_bodyid[number]))
    if model.jnt_stiffness[number] or compiled.bent("jnt_stiffness", number):
        mechanism.say(f"spring of the free body '{child}'", place, "left out: it acts on no joint", Same.NO)
    for values, what in (
        (model.dof_damping, "damping"),
        (model.dof_frictionloss, "dry friction"),
        (model.dof_armature, "armature"),
    ):
        if np.any(values[dof : dof + 6]) or (what == "damping" and compiled.bent("dof_damping", dof)):
            mechanism.say(f"{what} of the free body '{child}'", place, "left out: it acts on no joint", Same.NO)


def _ball(
    compiled: CompiledMjcf,
    mechanism: ImportedMechanism,
    kinds: list[int],
    number: int,
    bodies: tuple[str, str],
    names: ImportedNames,
    coordinates: Coordinates,
) -> None:
    """Connect two bodies by a ball, or by slides and then a ball, with massless bodies between."""
    model, data = compiled.model, compiled.data
    first = int(model.body_jntadr[number])
    ball = first + kinds.index(BALL)
    before = [single(compiled, mechanism, first + at, bodies[1]) for at in range(kinds.index(BALL))]
    after = [single(compiled, mechanism, ball + 1 + at, bodies[1]) for at in range(len(kinds) - len(before) - 1)]
    parent, child = bodies
    carried = mechanism.part(child)
    for chain, of in ((before, "before"), (after, "after")):
        if not chain:
            continue
        between = f"{child}_{of}_ball"
        massless = ImportedBody(between, 0.0, np.zeros((3, 3)), data.xanchor[ball].copy(), carried.rotation)
        sign = 1.0 if of == "before" else -1.0
        twist = BodyTwist.of(mechanism.part(parent if of == "before" else child))
        for each in chain:
            twist = twist.then(each, sign)
        mechanism.insert(twist.give_to(massless), bodies[1])
        ends = (parent, between) if of == "before" else (between, child)
        connect(mechanism, ends, chain, names.unused, coordinates)
        parent, child = (between, child) if of == "before" else (parent, between)
    name = names.unused(joint_name(compiled, ball, bodies[1]))
    place = compiled.place("jnt", ball) or compiled.place("body", number)
    mechanism.join(name, "spherical", (parent, child), data.xanchor[ball], place=place)
    _on_ball(compiled, mechanism, ball, name, place, (parent, child))


def _on_ball(
    compiled: CompiledMjcf,
    mechanism: ImportedMechanism,
    ball: int,
    name: str,
    place: Place | None,
    ends: tuple[str, str],
) -> None:
    """Add a bushing for the spring and the damping of a ball, which act on the rotation vector and the angular
    velocity."""
    model = compiled.model
    dof, body = int(model.jnt_dofadr[ball]), int(model.jnt_bodyid[ball])
    stiffness, damping = float(model.jnt_stiffness[ball]), float(model.dof_damping[dof])
    turned = _from_rest(compiled, ball)
    first = int(model.body_jntadr[body])
    kinds = model.jnt_type[first : first + int(model.body_jntnum[body])]
    if stiffness and turned is not None and HINGE in kinds:
        mechanism.say(f"spring of the ball '{name}'", place, "left out: it has no force at another pose", Same.NO)
        stiffness = 0.0
    if stiffness or damping:
        entry = {"type": "bushing", "bodies": list(ends), "location": compiled.data.xanchor[ball].copy()}
        if stiffness and turned is not None:
            to_first, to_second = (mechanism.part(end).rotation.T for end in ends)
            entry["axes"] = {
                ends[0]: {"quaternion": quaternion(to_first @ turned)},
                ends[1]: {"quaternion": quaternion(to_second)},
            }
        for key, size in (("stiffness", stiffness), ("damping", damping)):
            if size:
                entry[key] = {"rotation": [size] * 3}
        mechanism.forces[f"{name}_spring" if stiffness else f"{name}_damper"] = entry
    for word, at_word, called in (("jnt_stiffness", ball, "stiffness"), ("dof_damping", dof, "damping")):
        if compiled.bent(word, at_word):
            what = f"its {called} that is not linear is left out"
            mechanism.say(f"ball '{name}'", place, what, Same.NO)
    _say_yield(compiled, mechanism, ball, f"ball '{name}'", place)
    if model.jnt_limited[ball]:
        mechanism.say(f"limit of the ball '{name}'", place, "left out: a spherical joint has none", Same.NO)
    for values, what in ((model.dof_frictionloss, "dry friction"), (model.dof_armature, "armature")):
        if values[dof]:
            mechanism.say(f"{what} of the ball '{name}'", place, "left out: a spherical joint has none", Same.NO)


def _from_rest(compiled: CompiledMjcf, ball: int) -> Array | None:
    """The global orientation (3, 3), where the ball's spring is at rest, of a frame on the body that has the global
    axes at the present pose. None where the spring is at rest there."""
    model, at = compiled.model, int(compiled.model.jnt_qposadr[ball])
    rest, now = (np.array(to_matrix(tuple(values[at : at + 4]))) for values in (model.qpos_spring, compiled.data.qpos))
    if np.abs(rest - now).max() < 1e-12:
        return None
    carried = compiled.data.xmat[int(model.jnt_bodyid[ball])].reshape(3, 3)
    return np.asarray(carried @ now.T @ rest @ carried.T)
