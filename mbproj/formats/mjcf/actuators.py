"""Actuators of an MJCF model: left out with a row of the table, or on request forces on joints, tendons and bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.base.errors import Place
from mbproj.formats.chains import free_name
from mbproj.formats.mechanism import Bare, ImportedMechanism, ImportOptions, Quantity, Same
from mbproj.formats.mjcf.compiled import CompiledMjcf, is_off
from mbproj.formats.mjcf.joints import FREE, Called
from mbproj.formats.mjcf.laws import (
    ActuatorDrive,
    ActuatorLaw,
    Muscle,
    add_states,
    drive_of,
    free_symbol,
    inputs_of,
    law_of,
    summed,
    within,
)
from mbproj.formats.mjcf.tendon_forces import ActuatedCoordinate, act_along, along_of, length_of, names_along
from mbproj.formats.mjcf.tendon_paths import ModelTendons
from mbproj.formats.signals import refuse_unknown
from mbproj.formats.yaml_text import number as shown
from mbproj.scene.records import GROUND


def add_actuators(tendons: ModelTendons, options: ImportOptions) -> None:
    """Add the actuators that the user asks for, each with its signal, and a row of the table on every one. Raises
    InputError at unknown names."""
    compiled, mechanism = tendons.compiled, tendons.mechanism
    count = len(compiled.model.actuator_trntype)
    names = [compiled.name("actuator", number) or f"actuator_{number}" for number in range(count)]
    able = [each for number, name in enumerate(names) for each in inputs_of(compiled, number, name)]
    refuse_unknown(options.controls or {}, able, "actuator of the model")
    for number, name in enumerate(names):
        place, shown_name = compiled.place_in("actuator", name), f"actuator '{name}'"
        _say_unused(compiled, mechanism, number, shown_name, place)
        law = law_of(compiled, number)
        drive: ActuatorDrive | str = ""
        if not isinstance(law, str):
            drive = drive_of(compiled, mechanism, number, name, law, options.controls or {})
        if off := is_off(compiled.model, number):
            mechanism.say(shown_name, place, f"left out: the model turns {off} off", Same.YES)
        elif options.controls is None:
            still = (
                isinstance(law, ActuatorLaw)
                and not law.pushes
                and isinstance(drive, ActuatorDrive)
                and drive.constant == 0.0
            )
            what = "left out: it exerts nothing without a control signal; --controls gives it one"
            if not still:
                what = "left out: --hold lets it act with the control signal of the start, --controls with another"
            mechanism.say(shown_name, place, what, Same.UNTIL if still else Same.NO)
        elif isinstance(law, str) or isinstance(drive, str):
            mechanism.say(shown_name, place, f"left out: {law if isinstance(law, str) else drive}", Same.NO)
        else:
            wrong = _act(tendons, number, name, law, drive)
            driven = f"the states {', '.join(each.name for each in drive.states)}" if drive.states else ""
            what = f"left out: {wrong}" if wrong else f"acts with {driven or f'the signal {drive.text}'}"
            mechanism.say(shown_name, place, what, Same.NO if wrong else Same.YES)


def _say_unused(
    compiled: CompiledMjcf, mechanism: ImportedMechanism, number: int, name: str, place: Place | None
) -> None:
    for word in ("armature", "damping", "dampingpoly", "delay"):
        values = getattr(compiled.model, f"actuator_{word}", None)
        acts = word != "delay" or not is_off(compiled.model, number)
        if values is not None and acts and np.any(values[number]):
            mechanism.say(f"{word} of {name}", place, "left out: a scene has none of an actuator", Same.NO)


def _act(tendons: ModelTendons, number: int, name: str, law: ActuatorLaw | Muscle, drive: ActuatorDrive) -> str:
    """Add the forces of an actuator, and return ""; or the reason why a scene has no such force."""
    mechanism, along = tendons.mechanism, along_of(tendons, number)
    if isinstance(along, str):
        bodies = _on_body(tendons.compiled, mechanism, tendons.called, number)
        if bodies is None or isinstance(law, Muscle) or not law.simple or law.pushes:
            return along
        add_states(mechanism, drive, "0")
        for kind, entry, gear in bodies:
            vector = [_times(float(each) * law.gain[0], drive) for each in gear]
            if any(each != "0" for each in vector):
                force = {"type": kind, **entry, kind: [Bare(each) for each in vector]}
                mechanism.forces[free_name(mechanism, name if kind == "force" else f"{name}_torque")] = force
        return ""
    if isinstance(law, Muscle) or drive.states or (len(along) > 1 and not law.simple):
        _act_by_signal(mechanism, name, along, law, drive)
        return ""
    for each in along:
        for entry in _forces(each, law, drive):
            mechanism.forces[free_name(mechanism, name)] = {**each.entry, **entry}
    return ""


def _act_by_signal(
    mechanism: ImportedMechanism,
    name: str,
    along: list[ActuatedCoordinate],
    law: ActuatorLaw | Muscle,
    drive: ActuatorDrive,
) -> None:
    """Add a force that depends on a sum of coordinates and its rate: a signal, and forces by it along each
    coordinate."""
    names = names_along(mechanism, name, along)
    length, rate = length_of(along, names)
    add_states(mechanism, drive, length)
    seen = {"length": f"({length})", "rate": f"({rate})"}
    scaled = law.scaled(length, rate) if isinstance(law, Muscle) else {}
    seen |= {word: free_symbol(mechanism, f"{name}_{word}") for word in scaled}
    act_along(mechanism, name, along, names, law.force(drive.text, seen["length"], seen["rate"]))
    for word, text in scaled.items():
        mechanism.signals[seen[word]] = Bare(text)


def _forces(along: ActuatedCoordinate, law: ActuatorLaw, drive: ActuatorDrive) -> list[dict[str, Any]]:
    """The keys of the forces along one coordinate: a spring with a damper, and the part of the signal. It is one
    function where the law is not linear, or is limited."""
    scale = along.factor * np.array([1.0, along.factor, along.factor])
    shift = along.factor**2 * along.start
    (a, a_s, a_v), (b, b_s, b_v) = law.gain * scale, law.bias * scale
    a, b = a + law.gain[1] * shift, b + law.bias[1] * shift
    s, rate = along.s, f"{along.s}_dot"
    if law.range or a_s or a_v or b_s > 0.0 or b_v > 0.0 or (s == "l" and b_s):
        terms = [(a, drive.text), (a_s, f"{drive.text}*{s}"), (a_v, f"{drive.text}*{rate}"), (b, "1")]
        text = summed([*terms, (b_s, s), (b_v, rate)])
        if law.range:
            low, high = sorted(along.factor * each for each in law.range)
            text = within(text, (low, high))
        return [{along.force: Bare(text)}]
    per = "N*m" if along.unit == "rad" else "N"
    forces: list[dict[str, Any]] = []
    spring: dict[str, Any] = {}
    push, signal = (b, True) if drive.constant is None else (b + a * drive.constant, False)
    if b_s:
        spring["stiffness"] = Quantity(-b_s, f"{per}/rad" if along.unit == "rad" else "N/m")
        spring[along.free] = Quantity(push / -b_s, along.unit)
        push = 0.0
    if b_v:
        spring["damping"] = Quantity(-b_v, f"{per}*s/rad" if along.unit == "rad" else "N*s/m")
    if spring:
        forces.append(spring)
    if push or signal:
        forces.append({along.force: Bare(summed([(a if signal else 0.0, drive.text), (push, "1")]))})
    return forces


def _on_body(
    compiled: CompiledMjcf, mechanism: ImportedMechanism, called: Called, number: int
) -> list[tuple[str, dict[str, Any], Any]] | None:
    """The force and the torque of an actuator on a site or a free joint, each as kind, place and axes, components; None
    for other actuators."""
    import mujoco

    model, data, of = compiled.model, compiled.data, mujoco.mjtTrn
    kind, (what, reference) = int(model.actuator_trntype[number]), model.actuator_trnid[number]
    gear = np.array(model.actuator_gear[compiled.output(number)])
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


def _times(factor: float, drive: ActuatorDrive) -> str:
    if drive.constant is not None:
        return shown(factor * drive.constant)
    return f"{shown(factor)}*{drive.text}" if factor else "0"
