"""Loops of an MJCF model: points and frames that are held together, and joints that follow others."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.polynomial import Polynomial

from mbproj.arrays import Array
from mbproj.errors import Place
from mbproj.formats.chains import Coordinates
from mbproj.formats.geometry import IDENTITY, Pose, from_quaternion
from mbproj.formats.mechanism import Bare, Connection, Mechanism, Names, Quantity, Same
from mbproj.formats.mjcf.along import tendon_weights, two_points
from mbproj.formats.mjcf.compiled import Compiled
from mbproj.formats.mjcf.joints import joint_name
from mbproj.formats.mjcf.parts import Called
from mbproj.formats.yaml_text import number

CONNECT, WELD, JOINT, TENDON = range(4)
#: MuJoCo's own softness of an equality: its time constant in s and its least impedance. A softer one gives way visibly.
TIME_CONSTANT, IMPEDANCE = 0.02, 0.9
WORDS = {CONNECT: "connect", WELD: "weld", JOINT: "joint", TENDON: "tendon"}


def add_equalities(
    compiled: Compiled, mechanism: Mechanism, called: Called, names: Names, coordinates: Coordinates
) -> None:
    """Adds a joint for each equality that is active."""
    model = compiled.model
    elements = [e for section in compiled.source.root.all("equality") for e in section.children]
    for at in range(model.neq):
        kind = int(model.eq_type[at])
        word = WORDS.get(kind, "flex")
        place = elements[at].place if len(elements) == model.neq else None
        shown = f"equality '{compiled.name('eq', at) or at}' ({word})"
        if not model.eq_active0[at]:
            mechanism.say(shown, place, "left out: it is not active at the start", Same.YES)
        elif kind in (CONNECT, WELD):
            _held(compiled, mechanism, called, names, at, place, shown)
        elif kind in (JOINT, TENDON):
            _coupled(compiled, mechanism, called, names, coordinates, at, place, shown)
        else:
            mechanism.say(shown, place, "left out: a scene has no flexible bodies", Same.NO)


def _held(
    compiled: Compiled, mechanism: Mechanism, called: Called, names: Names, at: int, place: Place | None, shown: str
) -> None:
    """A point (connect) or a frame (weld) of each of two bodies."""
    import mujoco

    model, data = compiled.model, compiled.data
    numbers = [int(model.eq_obj1id[at]), int(model.eq_obj2id[at])]
    values = model.eq_data[at]
    weld = int(model.eq_type[at]) == WELD
    if int(model.eq_objtype[at]) == int(mujoco.mjtObj.mjOBJ_SITE):
        frames = [Pose(data.site_xpos[each], data.site_xmat[each].reshape(3, 3)) for each in numbers]
        numbers = [int(model.site_bodyid[each]) for each in numbers]
        if weld:
            values = np.zeros(11)
            values[6] = 1.0
    else:
        frames = [Pose(data.xpos[each], data.xmat[each].reshape(3, 3)) for each in numbers]
    bodies = (called[numbers[0]], called[numbers[1]])
    if bodies[0] == bodies[1]:
        mechanism.say(shown, place, f"left out: both its ends are on '{bodies[0]}'", Same.YES)
        return
    inner = _frames_held(values, weld)
    points, turns = np.empty((2, 3)), np.empty((2, 3, 3))
    for side, (frame, own, body) in enumerate(zip(frames, inner, bodies, strict=True)):
        held, part = frame.then(own), mechanism.part(body)
        points[side], turns[side] = part.local(held.position), part.rotation.T @ held.rotation
    free_turn = weld and float(model.eq_data[at][10]) == 0.0
    kind = "fixed" if weld and not free_turn else "spherical"
    name = names.own(compiled.name("eq", at) or f"loop_{at + 1}")
    joint = Connection(name, kind, bodies, points, None, turns if kind == "fixed" else None, {}, place)
    mechanism.joints[name] = joint
    _say_soft(compiled, mechanism, at, shown, place, f"{kind} joint")


def _say_soft(compiled: Compiled, mechanism: Mechanism, at: int, shown: str, place: Place | None, becomes: str) -> None:
    """An equality gives way in MuJoCo, and not in the scene: the same motion, unless the model makes it softer."""
    constant, impedance = float(compiled.model.eq_solref[at][0]), float(compiled.model.eq_solimp[at][0])
    if 0.0 < constant <= TIME_CONSTANT and impedance >= IMPEDANCE:
        mechanism.say(shown, place, f"a soft constraint in MuJoCo, a {becomes} in the scene", Same.YES)
    else:
        what = f"a spring by its solref or solimp in MuJoCo, a rigid {becomes} in the scene"
        mechanism.say(shown, place, what, Same.NO)


def _frames_held(values: Array, weld: bool) -> tuple[Pose, Pose]:
    """The frames in each body that meet. Of a weld: relpose of body 2 in body 1, and an anchor in body 2."""
    if not weld:
        return Pose(values[0:3], np.eye(3)), Pose(values[3:6], np.eye(3))
    anchor = Pose(values[0:3], np.eye(3))
    relative = Pose(values[3:6], from_quaternion(values[6:10])) if values[6:10].any() else IDENTITY
    return relative.then(anchor), anchor


def _coupled(
    compiled: Compiled,
    mechanism: Mechanism,
    called: Called,
    names: Names,
    coordinates: Coordinates,
    at: int,
    place: Place | None,
    shown: str,
) -> None:
    """y - y₀ = a₀ + a₁ (x - x₀) + .. + a₄ (x - x₀)⁴ of two joints, or tendons that are sums of joint coordinates."""
    model = compiled.model
    tendons = int(model.eq_type[at]) == TENDON
    if tendons and _rod(compiled, mechanism, called, names, at, place):
        return
    sums = []
    for each in (int(model.eq_obj1id[at]), int(model.eq_obj2id[at])):
        found = tendon_weights(compiled, each) if tendons else {each: 1.0}
        if each >= 0 and found is None:
            mechanism.say(shown, place, "left out: a scene has no ropes over sites or pulleys", Same.NO)
            return
        sums.append(found or {} if each >= 0 else {})
    y, x = sums
    polynomial = Polynomial(model.eq_data[at][: 5 if x else 1])
    if len(x) > 1 and np.any(polynomial.coef[2:]):
        mechanism.say(shown, place, "left out: it is not linear in several coordinates", Same.NO)
        return
    off = {joint: _off(compiled, joint) for joint in {**y, **x}}
    sign = next(iter(x.values()), 1.0)
    curve = polynomial(Polynomial([0.0, 1.0])) - sum(weight * off[joint] for joint, weight in y.items())
    shift = sum(weight * off[joint] for joint, weight in x.items())
    curve = curve(Polynomial([shift, sign])) if len(x) <= 1 else curve(Polynomial([shift, 1.0]))
    names_of = {joint: _coordinate(compiled, called, coordinates, joint) for joint in off}
    if None in names_of.values():
        mechanism.say(shown, place, "left out: it couples a joint that has no coordinate of its own", Same.NO)
        return
    keys = _row({names_of[j]: w for j, w in y.items()}, {names_of[j]: w for j, w in x.items()}, curve)  # type: ignore[misc]
    name = names.own(compiled.name("eq", at) or f"coupler_{at + 1}")
    mechanism.joints[name] = Connection(name, "coupler", keys=keys, place=place)
    _say_soft(compiled, mechanism, at, shown, place, "coupler")


def _rod(compiled: Compiled, mechanism: Mechanism, called: Called, names: Names, at: int, place: Place | None) -> bool:
    """Whether a tendon between two points that keeps its length makes a distance joint."""
    model, number = compiled.model, int(compiled.model.eq_obj1id[at])
    found = two_points(compiled, mechanism, called, number)
    if found is None or int(model.eq_obj2id[at]) >= 0:
        return False
    length = float(model.tendon_length0[number] + model.eq_data[at][0])
    name = names.own(compiled.name("eq", at) or f"loop_{at + 1}")
    keys = {"length": Quantity(length, "m")}
    mechanism.joints[name] = Connection(name, "distance", found[0], found[1], keys=keys, place=place)
    shown = f"equality '{compiled.name('eq', at) or at}' (tendon)"
    _say_soft(compiled, mechanism, at, shown, place, "distance joint")
    return True


def _row(y: Mapping[str, float], x: Mapping[str, float], curve: Polynomial) -> dict[str, object]:
    """What a coupler is written as: Σ k s = constant where the curve is straight, else a function of the first."""
    coefficients = [float(each) for each in curve.coef]
    if len(coefficients) < 3 or not np.any(coefficients[2:]):
        slope = coefficients[1] if len(coefficients) > 1 else 0.0
        scale = slope if len(x) != 1 else slope / next(iter(x.values()))
        of = dict(y) | {name: -scale * weight for name, weight in x.items() if slope}
        keys: dict[str, object] = {"of": of}
        if coefficients[0]:
            keys["constant"] = coefficients[0]
        return keys
    (first,) = x
    terms = " + ".join(f"({number(c)})*s**{power}" for power, c in enumerate(coefficients) if c and power)
    keys = {"of": {first: 0.0} | dict(y), "function": Bare(terms)}
    if coefficients[0]:
        keys["constant"] = coefficients[0]
    return keys


def _off(compiled: Compiled, joint: int) -> float:
    """How far the pose of the start is from the reference of a hinge or a slide."""
    at = int(compiled.model.jnt_qposadr[joint])
    return float(compiled.data.qpos[at] - compiled.model.qpos0[at])


def _coordinate(compiled: Compiled, called: Called, coordinates: Coordinates, joint: int) -> str | None:
    name = joint_name(compiled, joint, called[int(compiled.model.jnt_bodyid[joint])])
    found = coordinates.get(name)
    return None if found is None else ".".join(found)
