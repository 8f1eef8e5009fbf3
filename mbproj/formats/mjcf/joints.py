"""Joints of an MJCF model: hinges, slides, balls, free ones, and several between two bodies."""

from __future__ import annotations

import numpy as np

from mbproj.errors import Place
from mbproj.formats.chains import Coordinates, Single, Twist, connect, span
from mbproj.formats.mechanism import Mechanism, Names, Part, Same
from mbproj.formats.mjcf.compiled import Compiled
from mbproj.formats.mjcf.parts import Called

FREE, BALL, SLIDE, HINGE = range(4)


def add_joints(
    compiled: Compiled, mechanism: Mechanism, called: Called, names: Names, coordinates: Coordinates
) -> None:
    """Connects each body that moves with its parent; `coordinates` then has those of hinges and slides by name."""
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
                names.own(f"{child}_weld"), "fixed", (parent, child), compiled.data.xpos[number], place=place
            )
        elif kinds[0] == FREE:
            _say_free(compiled, mechanism, first, child)
        elif BALL in kinds:
            _ball(compiled, mechanism, kinds, number, (parent, child), names, coordinates)
        else:
            singles = [single(compiled, mechanism, first + at, child) for at in range(count)]
            connect(mechanism, (parent, child), singles, names.own, coordinates)


def single(compiled: Compiled, mechanism: Mechanism, number: int, child: str) -> Single:
    """A hinge or a slide with what acts on its coordinate, which counts from the pose of the start."""
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
    for poly, called in ((model.jnt_stiffnesspoly[number], "stiffness"), (model.dof_dampingpoly[dof], "damping")):
        if np.any(poly):
            what = f"its {called} that is not linear is left out"
            mechanism.say(f"joint '{name}'", place, what, Same.NO)
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


def joint_name(compiled: Compiled, number: int, child: str) -> str:
    """Its name, or one from its body."""
    name = compiled.name("jnt", number)
    if name:
        return name
    model = compiled.model
    first = int(model.body_jntadr[model.jnt_bodyid[number]])
    alone = int(model.body_jntnum[model.jnt_bodyid[number]]) == 1
    return f"{child}_joint" if alone else f"{child}_joint_{number - first + 1}"


def start_of(compiled: Compiled, called: Called) -> dict[str, float]:
    """The model's coordinates of hinges and slides at the pose of the start, by name."""
    model, found = compiled.model, {}
    for number in range(model.njnt):
        if int(model.jnt_type[number]) in (HINGE, SLIDE):
            name = joint_name(compiled, number, called[int(model.jnt_bodyid[number])])
            found[name] = float(compiled.data.qpos[model.jnt_qposadr[number]])
    return found


def _say_free(compiled: Compiled, mechanism: Mechanism, number: int, child: str) -> None:
    """A free joint is no joint in a scene; what acts on its coordinates has no counterpart."""
    model, dof = compiled.model, int(compiled.model.jnt_dofadr[number])
    place = compiled.place("jnt", number) or compiled.place("body", int(model.jnt_bodyid[number]))
    for values, what in (
        (model.dof_damping, "damping"),
        (model.dof_frictionloss, "dry friction"),
        (model.dof_armature, "armature"),
    ):
        if np.any(values[dof : dof + 6]):
            mechanism.say(f"{what} of the free body '{child}'", place, "left out: it acts on no joint", Same.NO)


def _ball(
    compiled: Compiled,
    mechanism: Mechanism,
    kinds: list[int],
    number: int,
    bodies: tuple[str, str],
    names: Names,
    coordinates: Coordinates,
) -> None:
    """A ball alone, or slides before one: massless bodies between."""
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
        massless = Part(between, 0.0, np.zeros((3, 3)), data.xanchor[ball].copy(), carried.rotation)
        sign = 1.0 if of == "before" else -1.0
        twist = Twist.of(mechanism.part(parent if of == "before" else child))
        for each in chain:
            twist = twist.then(each, sign)
        mechanism.insert(twist.on(massless), bodies[1])
        ends = (parent, between) if of == "before" else (between, child)
        connect(mechanism, ends, chain, names.own, coordinates)
        parent, child = (between, child) if of == "before" else (parent, between)
    name = names.own(joint_name(compiled, ball, bodies[1]))
    place = compiled.place("jnt", ball) or compiled.place("body", number)
    mechanism.join(name, "spherical", (parent, child), data.xanchor[ball], place=place)
    _say_ball(compiled, mechanism, ball, name, place, (parent, child))


def _say_ball(
    compiled: Compiled, mechanism: Mechanism, ball: int, name: str, place: Place | None, ends: tuple[str, str]
) -> None:
    """A ball's spring acts along the rotation vector, as a bushing does; its damping does so near the pose only."""
    model = compiled.model
    dof, at = int(model.jnt_dofadr[ball]), int(model.jnt_qposadr[ball])
    stiffness, damping = float(model.jnt_stiffness[ball]), float(model.dof_damping[dof])
    at_rest = np.abs(model.qpos_spring[at : at + 4] - compiled.data.qpos[at : at + 4]).max() < 1e-12
    if (stiffness or damping) and at_rest:
        entry = {"type": "bushing", "bodies": list(ends), "location": compiled.data.xanchor[ball].copy()}
        if stiffness:
            entry["stiffness"] = {"rotation": [stiffness] * 3}
        if damping:
            entry["damping"] = {"rotation": [damping] * 3}
            what = "acts on the rate of the rotation vector: as MuJoCo's for small angles"
            mechanism.say(f"damping of the ball '{name}'", place, what, Same.NO)
        mechanism.forces[f"{name}_spring"] = entry
    elif stiffness or damping:
        mechanism.say(f"spring of the ball '{name}'", place, "left out: it has no force at another pose", Same.NO)
    if model.jnt_limited[ball]:
        mechanism.say(f"limit of the ball '{name}'", place, "left out: a spherical joint has none", Same.NO)
    for values, what in ((model.dof_frictionloss, "dry friction"), (model.dof_armature, "armature")):
        if values[dof]:
            mechanism.say(f"{what} of the ball '{name}'", place, "left out: a spherical joint has none", Same.NO)
