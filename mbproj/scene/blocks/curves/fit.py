"""Rules on what is on a curve: a roller fits it, an open one has limits, nothing acts along a closed one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from mbproj.joints import JOINTS
from mbproj.scene.fields.containers import Check, Complaint
from mbproj.scene.records import Joint, KeyPath

if TYPE_CHECKING:
    from mbproj.functions.curves.track import Track

#: The joint that holds both ways what another type lets lift off.
HOLDS = {"cam_contact": "cam", "flat_contact": "flat_follower"}
#: What is less bent is straight: the size of a curve over its largest radius of curvature.
STRAIGHT = 1e-6


def fit_curves(
    curves: Mapping[str, Track], joints: Mapping[str, Joint], forces: Mapping[str, Any], motions: Mapping[str, Any]
) -> Iterator[Complaint]:
    """A check that what is on a curve fits it."""
    for joint in joints.values():
        track = curves.get(str(joint.parameters.get("curve")))
        if track is not None:
            lifts = "gap" in JOINTS[joint.type].coordinates
            yield from _lifts(track, joint, forces, motions) if lifts else ()
            if JOINTS[joint.type].frame == "face":
                yield from _under_face(track, joint)
                continue
            yield from _on_curve(track, joint)
            yield from _rolls(track, joint, forces)
            if track.line.closed and not lifts:
                yield from _round_and_round(joint, forces, motions)


def _on_curve(curve: Track, joint: Joint) -> Iterator[Complaint]:
    path: KeyPath = ("joints", joint.name)
    side, given = joint.parameters.get("side"), joint.parameters.get("roller")
    able = ("outside", "inside") if curve.line.closed else ("left", "right")
    if side is not None and side not in able:
        kind = "closed" if curve.line.closed else "open"
        yield Complaint((*path, "side"), f"curve '{curve.name}' is {kind}", f"give {' or '.join(able)}")
        return
    radius = curve.roller if given is None else given
    if joint.type != "slot" and radius and side is None and not curve.line.closed:
        yield Complaint(path, "a roller on an open curve needs its 'side'", "give left or right, along the curve")
        return
    if not curve.line.closed and joint.type != "cam_contact":
        limit, length = joint.limits.get("displacement"), curve.line.length
        low, high = (None, None) if limit is None else (limit.low, limit.high)
        if low is None or high is None or low < 0.0 or high > length:
            hint = f"give limits: {{displacement: {{range: [0, {length:.6g} m], rigid: true}}}}, or less of it"
            at = path if limit is None else (*path, "limits", "displacement")
            yield Complaint(at, f"joint '{joint.name}' may leave its curve, which ends", hint)
    if joint.type != "slot":
        distance = curve.distance(side, radius)
        yield from _fits(curve, joint, distance, radius)


def _under_face(curve: Track, joint: Joint) -> Iterator[Complaint]:
    """A flat face goes round what is closed, and convex everywhere: it lies on what is straight."""
    from mbproj.functions.curves.soundness import least_bent
    from mbproj.scene.blocks.curves.made import place

    path: KeyPath = ("joints", joint.name, "curve")
    if not curve.line.closed:
        hint = "close it, or use a joint of type 'cam'"
        yield Complaint(path, f"curve '{curve.name}' is open: a flat face may pass its end", hint)
    elif curve.roller:
        hint = "leave its 'roller' out, or give flat: true"
        yield Complaint(path, f"curve '{curve.name}' was made for a roller, not for a flat face", hint)
    elif (found := least_bent(curve.line)).found <= STRAIGHT:
        said = f"curve '{curve.name}' is not convex at {place(found)}: a flat face does not touch it there alone"
        yield Complaint(path, said, "make it for the face: flat: true with a 'lift', or use a roller")


def _lifts(curve: Track, joint: Joint, forces: Mapping[str, Any], motions: Mapping[str, Any]) -> Iterator[Complaint]:
    """What may lift off has a limit that keeps it out of the profile, and nothing else acts along its gap."""
    path: KeyPath = ("joints", joint.name)
    if not curve.line.closed:
        yield Complaint((*path, "curve"), f"curve '{curve.name}' is open: what lifts off may pass its end", "close it")
    limit = joint.limits.get("gap")
    if limit is None or limit.low is None:
        at = path if limit is None else (*path, "limits", "gap")
        said = f"nothing keeps joint '{joint.name}' from passing through its curve"
        yield Complaint(at, said, "give limits: {gap: {range: [0, null], rigid: true}}, or a stiffness")
    for block, items in (("forces", forces), ("motions", motions)):
        for item in items.values():
            if getattr(item, "joint", None) == joint.name:
                hint = f"a joint of type '{HOLDS[joint.type]}' holds both ways; a stiffness of the limit is a spring"
                said = f"'{item.name}' acts along a gap, which its limits alone keep"
                yield Complaint((block, item.name), said, hint)


def _rolls(curve: Track, joint: Joint, forces: Mapping[str, Any]) -> Iterator[Complaint]:
    """A roller rolls: what it carries is no measure of friction along its curve."""
    if joint.type == "slot" or not joint.parameters.get("roller", curve.roller):
        return
    for force in forces.values():
        dry = getattr(force, "coulomb", {}) if getattr(force, "joint", None) == joint.name else {}
        for coordinate, each in dry.items():
            if each.bearing is not None:
                path = ("forces", force.name, "coulomb", *([coordinate] if coordinate else []), "coefficient")
                said = f"joint '{joint.name}' has a roller, which rolls: what it carries does not resist it"
                yield Complaint(path, said, "give a constant 'force', or friction to the roller's pin")


def _fits(curve: Track, joint: Joint, distance: float, radius: float) -> Iterator[Complaint]:
    from mbproj.functions.curves.soundness import largest_roller, touches_twice, undercut
    from mbproj.scene.blocks.curves.made import place

    found = undercut(curve.line, distance) or touches_twice(curve.line, distance) if distance else None
    if found is None:
        return
    most = largest_roller(curve.line, curve.is_left(joint.parameters.get("side")), curve.roller)
    key = ("roller",) if "roller" in joint.parameters else ("curve",)
    said = f"a roller of {radius:.4g} m does not fit curve '{curve.name}' at {place(found)}"
    yield Complaint(("joints", joint.name, *key), said, f"the largest that does is {most:.4g} m")


def _round_and_round(joint: Joint, forces: Mapping[str, Any], motions: Mapping[str, Any]) -> Iterator[Complaint]:
    """What goes by the displacement along a closed curve, which begins anew with each round."""
    hint = "act on another coordinate, or open the curve"
    for what in ("limits", "reflected_inertia"):
        if "displacement" in getattr(joint, what):
            said = "the displacement along a closed curve begins anew with each round"
            yield Complaint(("joints", joint.name, what), said, hint)
    for block, items in (("forces", forces), ("motions", motions)):
        for item in items.values():
            if getattr(item, "joint", None) == joint.name and not (_turns(item) or _only_rubs(item)):
                said = f"'{item.name}' acts along a closed curve, whose displacement begins anew with each round"
                yield Complaint((block, item.name), said, hint)


def _turns(item: Any) -> bool:
    """Whether a force or motion acts on what counts laps or turns alone."""
    names = {getattr(item, "coordinate", None), *getattr(item, "laws", ()), *getattr(item, "coulomb", ())} - {None}
    return bool(names) and names <= {"lap", "angle"}


def _only_rubs(item: Any) -> bool:
    """Whether a force is dry friction alone, which goes by how fast a coordinate changes."""
    return bool(getattr(item, "coulomb", ())) and not getattr(item, "laws", ())


CURVE_CHECK = Check(("curves", "joints"), fit_curves, besides=("forces", "motions"))
