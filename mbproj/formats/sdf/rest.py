"""Rows on the other parts of an SDF: further worlds and models, shapes, sensors, plug-ins, data of physics engines."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mbproj.formats.mechanism import ImportedMechanism, Same
from mbproj.formats.sdf.frames import SdfFrames
from mbproj.formats.sdf.joints import SdfJoint
from mbproj.formats.sdf.scopes import FRAMES, Scope, text
from mbproj.formats.xml import XmlElement

#: Tags in a world, a model, a link or a joint: those read, those without effect on the motion, those of joints only.
READ = (
    *("pose", "static", "gravity", "inertial", "visual", "collision"),
    *("parent", "child", "axis", "axis2", "name", "uri"),
)
ONLY_SHOWN = (
    *("light", "scene", "gui", "audio", "road", "spherical_coordinates", "physics", "self_collide", "sensor"),
    *("allow_auto_disable", "must_be_base_link", "enable_wind", "projector", "audio_source", "audio_sink", "material"),
    *("battery", "particle_emitter", "magnetic_field", "placement_frame", "gripper", "license", "wind", "atmosphere"),
)
OF_JOINTS = ("screw_thread_pitch", "thread_pitch", "gearbox_ratio", "gearbox_reference_body", "reference_body")
OF_ROTORS = ("drake:rotor_inertia", "drake:gear_ratio")
#: Words in the names of plug-ins that only draw, measure, or act on request.
HARMLESS = (
    *("apply-link-wrench", "joint-state-publisher", "pose-publisher", "scene-broadcaster", "user-commands"),
    *("physics", "sensors", "imu"),
)


def say_rest(
    mechanism: ImportedMechanism,
    scope: Scope,
    others: list[XmlElement],
    frames: SdfFrames,
    joints: Iterable[SdfJoint],
    meet: bool,
) -> None:
    """Add rows on all parts except links, joints and frames."""
    for other in others:
        what = f"left out: the scene is that of '{scope.name}'"
        mechanism.say(f"{other.tag} '{other.get('name')}'", other.place, what, Same.NO)
    models = list(scope.walk())
    links = [(name, element) for model in models for name, element in model.all("link")]
    touching = sum(len(link.all("collision")) for _, link in links)
    if touching:
        mechanism.say(f"{touching} collision shapes", None, "left out: shapes pass through each other", Same.UNTIL)
    for model in models:
        _say_elements(mechanism, model.rest)
    for _, link in links:
        _say_elements(mechanism, link.children)
    for joint in joints:
        _say_elements(mechanism, [each for each in joint.element.children if each.tag not in (*OF_JOINTS, *OF_ROTORS)])
        if not meet:
            _say_apart(mechanism, frames, joint)


def _say_elements(mechanism: ImportedMechanism, elements: Iterable[XmlElement]) -> None:
    for element in elements:
        if element.tag in READ or element.tag in (*FRAMES, *ONLY_SHOWN) or element.tag == "model":
            continue
        if element.tag == "kinematic" and text_of(element) in ("false", "0"):
            continue
        shown, file = f"<{element.tag}>", element.get("filename")
        what, same = "left out: it is not read, and may act on the motion", Same.NO
        if element.tag == "plugin":
            shown = f"plug-in '{file}'"
            if any(word in file.lower() for word in HARMLESS):
                what, same = "left out: it shows, or acts on request", Same.YES
        mechanism.say(shown, element.place, what, same)


def text_of(element: XmlElement) -> str:
    """The text of an element in small letters."""
    return element.text.strip().lower()


def _say_apart(mechanism: ImportedMechanism, frames: SdfFrames, joint: SdfJoint) -> None:
    """Add a row on a joint whose named frame of the parent is elsewhere: SDF puts the joint at its child."""
    named = text(joint.element, "parent")
    if named in ("world", "__root__") or joint.scope.frames.get(named) is None:
        return
    if joint.scope.frames[named].tag != "frame" or joint.element.first("pose") is not None:
        return
    parent = frames.pose(joint.scope, named, joint.place)
    child = frames.pose(joint.scope, joint.element.get("name"), joint.place)
    apart = float(np.linalg.norm(parent.position - child.position))
    if apart > 1e-9:
        what = f"stands at its child, as SDF says; its parent's '{named}' is {apart:.4g} m away: --meet joins both"
        mechanism.say(f"joint '{joint.name}'", joint.place, what, Same.YES)
