"""Loops of an MJCF model: points and frames that are held together, and joints that follow others."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.polynomial import Polynomial

from mbproj.base.arrays import Array
from mbproj.base.errors import Place
from mbproj.formats.geometry import Frame, from_quaternion
from mbproj.formats.mechanism import Bare, Connection, ImportedMechanism, ImportedNames, Quantity, Same
from mbproj.formats.mjcf.compiled import CompiledMjcf
from mbproj.formats.mjcf.joints import Called
from mbproj.formats.mjcf.tendon_paths import ModelTendons, TendonSum
from mbproj.formats.yaml_text import number

CONNECT, WELD, JOINT, TENDON = range(4)
#: MuJoCo's default softness of an equality: its time constant in s and its least impedance. A softer one differs
#: visibly from a rigid joint.
TIME_CONSTANT, IMPEDANCE = 0.02, 0.9
WORDS = {CONNECT: "connect", WELD: "weld", JOINT: "joint", TENDON: "tendon"}


def add_equalities(tendons: ModelTendons) -> None:
    """Add a joint for each equality that is active."""
    compiled, mechanism = tendons.compiled, tendons.mechanism
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
            _add_joint(compiled, mechanism, tendons.called, tendons.names, at, place, shown)
        elif kind in (JOINT, TENDON):
            _coupled(tendons, at, place, shown)
        else:
            mechanism.say(shown, place, "left out: a scene has no flexible bodies", Same.NO)


def _add_joint(
    compiled: CompiledMjcf,
    mechanism: ImportedMechanism,
    called: Called,
    names: ImportedNames,
    at: int,
    place: Place | None,
    shown: str,
) -> None:
    """Add the joint of an equality that holds a point (connect) or a frame (weld) of two bodies together."""
    import mujoco

    model, data = compiled.model, compiled.data
    numbers = [int(model.eq_obj1id[at]), int(model.eq_obj2id[at])]
    values = model.eq_data[at]
    weld = int(model.eq_type[at]) == WELD
    if int(model.eq_objtype[at]) == int(mujoco.mjtObj.mjOBJ_SITE):
        frames = [Frame(data.site_xpos[each], data.site_xmat[each].reshape(3, 3)) for each in numbers]
        numbers = [int(model.site_bodyid[each]) for each in numbers]
        if weld:
            values = np.zeros(11)
            values[6] = 1.0
    else:
        frames = [Frame(data.xpos[each], data.xmat[each].reshape(3, 3)) for each in numbers]
    bodies = (called[numbers[0]], called[numbers[1]])
    if bodies[0] == bodies[1]:
        mechanism.say(shown, place, f"left out: both its ends are on '{bodies[0]}'", Same.YES)
        return
    inner = _frames_held(values, weld)
    points, turns = np.empty((2, 3)), np.empty((2, 3, 3))
    for side, (frame, local, body) in enumerate(zip(frames, inner, bodies, strict=True)):
        held, part = frame.then(local), mechanism.part(body)
        points[side], turns[side] = part.local(held.position), part.rotation.T @ held.rotation
    free_turn = weld and float(model.eq_data[at][10]) == 0.0
    kind = "fixed" if weld and not free_turn else "spherical"
    name = names.unused(compiled.name("eq", at) or f"loop_{at + 1}")
    joint = Connection(name, kind, bodies, points, None, turns if kind == "fixed" else None, {}, place)
    mechanism.joints[name] = joint
    _say_soft(compiled, mechanism, at, shown, place, f"{kind} joint")


def _say_soft(
    compiled: CompiledMjcf, mechanism: ImportedMechanism, at: int, shown: str, place: Place | None, becomes: str
) -> None:
    """Add the row on an equality, which is soft in MuJoCo and rigid in the scene. The motion counts as the same, unless
    the model makes the equality softer than MuJoCo's default."""
    constant, impedance = float(compiled.model.eq_solref[at][0]), float(compiled.model.eq_solimp[at][0])
    if 0.0 < constant <= TIME_CONSTANT and impedance >= IMPEDANCE:
        mechanism.say(shown, place, f"a soft constraint in MuJoCo, a {becomes} in the scene", Same.YES)
    else:
        what = f"a spring by its solref or solimp in MuJoCo, a rigid {becomes} in the scene"
        mechanism.say(shown, place, what, Same.NO)


def _frames_held(values: Array, weld: bool) -> tuple[Frame, Frame]:
    """The frames in each body that an equality holds together. A weld gives its anchor in body 2, and the place of that
    in body 1 with the orientation of body 2."""
    if not weld:
        return Frame(values[0:3], np.eye(3)), Frame(values[3:6], np.eye(3))
    return Frame(values[3:6], from_quaternion(values[6:10])), Frame(values[0:3], np.eye(3))


def _coupled(tendons: ModelTendons, at: int, place: Place | None, shown: str) -> None:
    """Add the coupler of an equality of two joints or two tendons: y - y₀ = a₀ + a₁ (x - x₀) + .. + a₄ (x - x₀)⁴."""
    compiled, mechanism = tendons.compiled, tendons.mechanism
    model = compiled.model
    of_tendons = int(model.eq_type[at]) == TENDON
    numbers = [int(each) for each in (model.eq_obj1id[at], model.eq_obj2id[at]) if each >= 0]
    if of_tendons and all(tendons.is_constant(each) for each in numbers):
        mechanism.say(shown, place, "left out: nothing changes the length of its tendons", Same.YES)
        return
    if of_tendons and len(numbers) == 1 and _fix_length(tendons, at, numbers[0], place, shown):
        return
    curve = Polynomial(model.eq_data[at][: 5 if len(numbers) == 2 else 1])
    bent = bool(np.any(curve.coef[2:]))
    y, *others = (_sum(tendons, each, of_tendons, whole=False) for each in numbers)
    x = _sum(tendons, numbers[1], of_tendons, whole=bent) if others else TendonSum({}, 0.0)
    for each in (y, x):
        if isinstance(each, str):
            mechanism.say(shown, place, f"left out: {each}", Same.NO)
    if isinstance(y, str) or isinstance(x, str):
        return
    scale = next(iter(x.weights.values()), 1.0) if len(x.weights) == 1 else 1.0
    line = curve(Polynomial([x.constant, scale])) - y.constant
    name = tendons.names.unused(compiled.name("eq", at) or f"coupler_{at + 1}")
    mechanism.joints[name] = Connection(name, "coupler", keys=_row(y.weights, x.weights, line), place=place)
    _say_soft(compiled, mechanism, at, shown, place, "coupler")


def _sum(tendons: ModelTendons, number: int, of_tendons: bool, *, whole: bool) -> TendonSum | str:
    """The distance of a joint or a tendon from its reference, as a sum of the scene's coordinates and a constant. With
    `whole` the sum has one coordinate only. Else the reason why there is none."""
    model, data = tendons.compiled.model, tendons.compiled.data
    if not of_tendons:
        at, coordinate = int(model.jnt_qposadr[number]), tendons.coordinate(number)
        if coordinate is None:
            return "it couples a joint that has no coordinate of its own"
        return TendonSum({".".join(coordinate): 1.0}, float(data.qpos[at] - model.qpos0[at]))
    tendon_sum, rest = tendons.sum(number), float(model.tendon_length0[number])
    if whole and isinstance(tendon_sum, TendonSum) and len(tendon_sum.weights) > 1:
        measured = tendons.slider(number)
        if isinstance(measured, str):
            return measured
        return TendonSum({f"{measured.joint}.{measured.coordinate}": 1.0}, measured.constant - rest)
    return tendon_sum if isinstance(tendon_sum, str) else TendonSum(tendon_sum.weights, tendon_sum.constant - rest)


def _fix_length(tendons: ModelTendons, at: int, number: int, place: Place | None, shown: str) -> bool:
    """Make a distance joint, or a rope of fixed length, of a tendon over sites whose length an equality fixes. Return
    whether that is possible."""
    compiled, mechanism = tendons.compiled, tendons.mechanism
    branches = tendons.branches(number)
    if len(branches) != 1 or tendons.wrong(number):
        return False
    whole = float(compiled.model.tendon_length0[number] + compiled.model.eq_data[at][0])
    length = Quantity((whole - tendons.constant(number)) / branches[0].weight, "m")
    line = tendons.ends(branches[0])
    if line is None:
        tendons.say_length(tendons.rope(number, 0), length=length)
        mechanism.tree.discard(tendons.rope(number, 0))
        _say_soft(compiled, mechanism, at, shown, place, "rope")
        return True
    name = tendons.names.unused(compiled.name("eq", at) or f"loop_{at + 1}")
    mechanism.joints[name] = Connection(name, "distance", line[0], line[1], keys={"length": length}, place=place)
    tendons.acting.add(number)
    _say_soft(compiled, mechanism, at, shown, place, "distance joint")
    return True


def _row(y: Mapping[str, float], x: Mapping[str, float], curve: Polynomial) -> dict[str, object]:
    """The keys of a coupler: Σ k s = constant where the curve is a straight line, else with a function of the first
    coordinate."""
    coefficients = [float(each) for each in curve.coef]
    absolute = any(name.endswith(".length") for name in (*y, *x))  # the others count from the pose
    if len(coefficients) < 3 or not np.any(coefficients[2:]):
        slope = coefficients[1] if len(coefficients) > 1 else 0.0
        scale = slope if len(x) != 1 else slope / next(iter(x.values()))
        of = dict(y) | {name: -scale * weight for name, weight in x.items() if slope}
        keys: dict[str, object] = {"of": of}
        if coefficients[0] or absolute:
            keys["constant"] = coefficients[0]
        return keys
    (first,) = x
    terms = " + ".join(f"({number(c)})*s**{power}" for power, c in enumerate(coefficients) if c and power)
    keys = {"of": {first: 0.0} | dict(y), "function": Bare(terms)}
    if coefficients[0]:
        keys["constant"] = coefficients[0]
    return keys
