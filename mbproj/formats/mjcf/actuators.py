"""Actuators of an MJCF model: left out and said, or on request what acts on a joint, a tendon, a site, a free body."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.formats.chains import Coordinates, free_name
from mbproj.formats.mechanism import Bare, Mechanism, Names, Quantity, Same, Wishes
from mbproj.formats.mjcf.compiled import Compiled
from mbproj.formats.mjcf.equalities import tendon_weights
from mbproj.formats.mjcf.joints import FREE, HINGE, SLIDE, joint_name
from mbproj.formats.mjcf.laws import Drive, Law, drive_of, law_of
from mbproj.formats.mjcf.parts import Called
from mbproj.formats.mjcf.tendons import two_points
from mbproj.formats.signals import refuse_unknown
from mbproj.formats.yaml_text import number as shown
from mbproj.scene.records import GROUND


@dataclass(frozen=True, eq=False)
class Along:
    """A coordinate s that an actuator acts along, with length = factor (start + s): what its force begins with, the
    words of the scene for s and the force, and units."""

    entry: Mapping[str, Any]
    s: str
    force: str
    free: str
    unit: str
    factor: float
    start: float


def add_actuators(
    compiled: Compiled, mechanism: Mechanism, called: Called, coordinates: Coordinates, wishes: Wishes
) -> None:
    """Each is left out, or acts with its signal where the user asks for that. Raises InputError at unknown names."""
    count = len(compiled.model.actuator_trntype)
    names = [compiled.name("actuator", number) or f"actuator_{number}" for number in range(count)]
    refuse_unknown(wishes.controls or {}, names, "actuator of the model")
    for number, name in enumerate(names):
        place, shown_name = compiled.place_in("actuator", name), f"actuator '{name}'"
        _say_unused(compiled, mechanism, number, shown_name, place)
        law = law_of(compiled, number)
        drive = drive_of(compiled, number, name, wishes.controls or {})
        if compiled.disables("ACTUATION"):
            mechanism.say(shown_name, place, "left out: the model turns actuators off", Same.YES)
        elif wishes.controls is None:
            still = isinstance(law, Law) and not law.pushes and isinstance(drive, Drive) and drive.constant == 0.0
            what = "left out: it exerts nothing without a control signal; --controls gives it one"
            if not still:
                what = "left out: --hold lets it act with the control signal of the start, --controls with another"
            mechanism.say(shown_name, place, what, Same.UNTIL if still else Same.NO)
        elif isinstance(law, str) or isinstance(drive, str):
            mechanism.say(shown_name, place, f"left out: {law if isinstance(law, str) else drive}", Same.NO)
        else:
            acts = _act(compiled, mechanism, called, coordinates, number, name, law, drive)
            what = (
                f"acts with the signal {drive.text}" if acts else "left out: a scene has no force along what it pulls"
            )
            mechanism.say(shown_name, place, what, Same.YES if acts else Same.NO)


def _say_unused(compiled: Compiled, mechanism: Mechanism, number: int, name: str, place: Place | None) -> None:
    for word in ("armature", "damping", "dampingpoly", "delay"):
        values = getattr(compiled.model, f"actuator_{word}", None)
        if values is not None and np.any(values[number]):
            mechanism.say(f"{word} of {name}", place, "left out: a scene has none of an actuator", Same.NO)


def _act(
    compiled: Compiled,
    mechanism: Mechanism,
    called: Called,
    coordinates: Coordinates,
    number: int,
    name: str,
    law: Law,
    drive: Drive,
) -> bool:
    """Adds what the actuator exerts; False where nothing in a scene does."""
    along = _along(compiled, mechanism, called, coordinates, number)
    if along is None:
        bodies = _on_body(compiled, mechanism, called, number)
        if bodies is None or law.range or law.gain[1:].any() or law.bias.any():
            return False
        for kind, entry, gear in bodies:
            vector = [_times(float(each) * law.gain[0], drive) for each in gear]
            if any(each != "0" for each in vector):
                force = {"type": kind, **entry, kind: [Bare(each) for each in vector]}
                mechanism.forces[free_name(mechanism, name if kind == "force" else f"{name}_torque")] = force
        return True
    if len(along) > 1 and (law.gain[1:].any() or law.bias[1:].any() or law.range):
        _act_on_sum(mechanism, name, along, law, drive)
        return True
    for each in along:
        for entry in _forces(each, law, drive):
            mechanism.forces[free_name(mechanism, name)] = {**each.entry, **entry}
    return True


def _act_on_sum(mechanism: Mechanism, name: str, along: list[Along], law: Law, drive: Drive) -> None:
    """One force by the sum of coordinates and its rate, a signal, which acts along each of them."""
    seen = [f"{each.entry['joint']}.{each.entry.get('coordinate', each.s)}".replace("-", "_") for each in along]
    length = _sum([(sum(each.factor * each.start for each in along), "1"), *_weighed(along, seen, "")])
    rate = _sum(_weighed(along, seen, "_dot"))
    terms = [(law.gain[0], drive.text), (law.bias[0], "1")]
    for at, text in ((1, length), (2, rate)):
        terms += [(law.gain[at], f"{drive.text}*({text})"), (law.bias[at], f"({text})")]
    text = _sum(terms)
    if law.range:
        text = f"min(max({text}, {shown(law.range[0])}), {shown(law.range[1])})"
    taken = frozenset([*mechanism.forces, *mechanism.signals])
    signal = Names(taken).own(f"{name}_force".replace("-", "_"))
    mechanism.signals[signal] = Bare(text)
    for each in along:
        mechanism.forces[free_name(mechanism, name)] = {
            **each.entry,
            each.force: Bare(f"{shown(each.factor)}*{signal}"),
        }


def _weighed(along: list[Along], seen: list[str], ending: str) -> list[tuple[float, str]]:
    return [(each.factor, name + ending) for each, name in zip(along, seen, strict=True)]


def _along(
    compiled: Compiled, mechanism: Mechanism, called: Called, coordinates: Coordinates, number: int
) -> list[Along] | None:
    """The coordinates that it acts along; None where it acts along none."""
    import mujoco

    model, of = compiled.model, mujoco.mjtTrn
    kind, what = int(model.actuator_trntype[number]), int(model.actuator_trnid[number][0])
    gear = float(model.actuator_gear[number][0])
    if kind in (int(of.mjTRN_JOINT), int(of.mjTRN_JOINTINPARENT)):
        weights: dict[int, float] | None = {what: 1.0}
    elif kind == int(of.mjTRN_TENDON):
        line = two_points(compiled, mechanism, called, what)
        if line is not None:
            entry = {"type": "spring_damper", "bodies": list(line[0]), "locations": dict(zip(*line, strict=True))}
            return [Along(entry, "l", "force", "free_length", "m", gear, 0.0)]
        weights = tendon_weights(compiled, what)
    else:
        return None
    found = [
        _on_joint(compiled, mechanism, called, coordinates, joint, gear * weight)
        for joint, weight in (weights or {}).items()
    ]
    known = [each for each in found if each is not None]
    return known if known and len(known) == len(found) else None


def _on_joint(
    compiled: Compiled, mechanism: Mechanism, called: Called, coordinates: Coordinates, joint: int, factor: float
) -> Along | None:
    model = compiled.model
    turns = int(model.jnt_type[joint]) == HINGE
    where = coordinates.get(joint_name(compiled, joint, called[int(model.jnt_bodyid[joint])]))
    if where is None or int(model.jnt_type[joint]) not in (HINGE, SLIDE):
        return None
    entry: dict[str, Any] = {"type": "torsion_spring_damper" if turns else "linear_spring_damper", "joint": where[0]}
    if where[1] not in ("angle", "displacement") or mechanism.joints[where[0]].type == "cylindrical":
        entry["coordinate"] = where[1]
    s, force = ("angle", "torque") if turns else ("displacement", "force")
    start = float(compiled.data.qpos[model.jnt_qposadr[joint]])
    return Along(entry, s, force, f"free_{s}", "rad" if turns else "m", factor, start)


def _forces(along: Along, law: Law, drive: Drive) -> list[dict[str, Any]]:
    """A spring with a damper, and what the signal adds; one function where the law is another or is limited."""
    scale = along.factor * np.array([1.0, along.factor, along.factor])
    shift = along.factor**2 * along.start
    (a, a_s, a_v), (b, b_s, b_v) = law.gain * scale, law.bias * scale
    a, b = a + law.gain[1] * shift, b + law.bias[1] * shift
    s, rate = along.s, f"{along.s}_dot"
    if law.range or a_s or a_v or b_s > 0.0 or b_v > 0.0 or (s == "l" and b_s):
        terms = [(a, drive.text), (a_s, f"{drive.text}*{s}"), (a_v, f"{drive.text}*{rate}"), (b, "1")]
        text = _sum([*terms, (b_s, s), (b_v, rate)])
        if law.range:
            low, high = sorted(along.factor * each for each in law.range)
            text = f"min(max({text}, {shown(low)}), {shown(high)})"
        return [{along.force: Bare(text)}]
    per = "N*m" if along.unit == "rad" else "N"
    found: list[dict[str, Any]] = []
    kept: dict[str, Any] = {}
    push, signal = (b, True) if drive.constant is None else (b + a * drive.constant, False)
    if b_s:
        kept["stiffness"] = Quantity(-b_s, f"{per}/rad" if along.unit == "rad" else "N/m")
        kept[along.free] = Quantity(push / -b_s, along.unit)
        push = 0.0
    if b_v:
        kept["damping"] = Quantity(-b_v, f"{per}*s/rad" if along.unit == "rad" else "N*s/m")
    if kept:
        found.append(kept)
    if push or signal:
        found.append({along.force: Bare(_sum([(a if signal else 0.0, drive.text), (push, "1")]))})
    return found


def _on_body(
    compiled: Compiled, mechanism: Mechanism, called: Called, number: int
) -> list[tuple[str, dict[str, Any], Any]] | None:
    """Force and torque on a body that a site, or a free joint, is pulled by: kind, place and axes, components."""
    import mujoco

    model, data, of = compiled.model, compiled.data, mujoco.mjtTrn
    kind, (what, reference) = int(model.actuator_trntype[number]), model.actuator_trnid[number]
    gear = np.array(model.actuator_gear[number])
    if kind == int(of.mjTRN_SITE) and reference < 0:
        body = called[int(model.site_bodyid[what])]
        if body == GROUND:
            return []
        part = mechanism.part(body)
        turn = part.rotation.T @ data.site_xmat[what].reshape(3, 3)
        at = {body: part.local(data.site_xpos[what])}
        force = {"body": body, "location": at, "axes": "body"}
        return [("force", force, turn @ gear[:3]), ("torque", {"body": body, "axes": "body"}, turn @ gear[3:])]
    if kind == int(of.mjTRN_JOINT) and int(model.jnt_type[what]) == FREE:
        body = called[int(model.jnt_bodyid[what])]
        at = {body: mechanism.part(body).local(data.xpos[int(model.jnt_bodyid[what])])}
        force = {"body": body, "location": at}
        return [("force", force, gear[:3]), ("torque", {"body": body, "axes": "body"}, gear[3:])]
    return None


def _times(factor: float, drive: Drive) -> str:
    if drive.constant is not None:
        return shown(factor * drive.constant)
    return f"{shown(factor)}*{drive.text}" if factor else "0"


def _sum(terms: list[tuple[float, str]]) -> str:
    """Σ factor × text, without terms that are zero."""
    parts = [shown(factor) if text == "1" else f"{shown(factor)}*{text}" for factor, text in terms if factor]
    return " + ".join(parts).replace("+ -", "- ") or "0"
