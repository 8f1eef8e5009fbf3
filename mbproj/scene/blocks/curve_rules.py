"""Rules on joints that follow a curve: rollers fit it, joints on open curves have limits, and nothing acts along closed
ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from mbproj.base.thresholds import THRESHOLDS
from mbproj.joints.table import JOINTS
from mbproj.scene.fields.fields import Complaint
from mbproj.scene.records import Joint, KeyPath

if TYPE_CHECKING:
    import numpy as np

    from mbproj.functions.plane_curve import PlaneCurve
    from mbproj.functions.space_curve import SpaceCurve, SpaceTrack, Track


# --- Rules on two curves that touch -----------------------------------------------------------------------------------
# Their sides, limits along open ones, and that one fits into the other.


def fit_two(tracks: Sequence[Track], joint: Joint) -> Iterator[Complaint]:
    """A check that the two curves of a joint can touch on the sides, and within the limits, that the joint gives."""
    path: KeyPath = ("joints", joint.name)
    sides = joint.parameters.get("sides")
    wrong = [*_wrong_sides(tracks, sides, path)]
    yield from wrong
    if wrong:
        return
    for number, track in enumerate(tracks):
        if track.line.closed:
            continue
        if f"displacement_{number + 1}" not in joint.limits:
            yield from _open(track, joint, number)
        else:
            yield from _passes_end_of_two(track, joint, number)
    yield from _hollow(tracks, joint)


def _wrong_sides(tracks: Sequence[Track], sides: tuple[str, ...] | None, path: KeyPath) -> Iterator[Complaint]:
    for number, track in enumerate(tracks):
        kind, able = ("closed", ("outside", "inside")) if track.line.closed else ("open", ("left", "right"))
        if sides is None and not track.line.closed:
            said = f"curve '{track.name}' is open: say on which side of it the other curve is"
            yield Complaint(path, said, "give sides: two of left, right, along each; outside, inside of closed ones")
            return
        if sides is not None and sides[number] not in able:
            yield Complaint((*path, "sides", number), f"curve '{track.name}' is {kind}", f"give {' or '.join(able)}")


def _open(track: Track, joint: Joint, number: int) -> Iterator[Complaint]:
    path: KeyPath = ("joints", joint.name)
    if joint.type == "curve_contact":
        yield Complaint(
            (*path, "curves", number),
            f"curve '{track.name}' is open: what lifts off may pass its end",
            "close it, or use a joint of type 'curve_on_curve'",
        )
        return
    hint = f"give limits: {{displacement_{number + 1}: {{range: [0, {track.line.length:.6g} m], rigid: true}}}}"
    yield Complaint(path, f"joint '{joint.name}' may leave curve '{track.name}', which ends", f"{hint}, or less of it")


def _passes_end_of_two(track: Track, joint: Joint, number: int) -> Iterator[Complaint]:
    name, length = f"displacement_{number + 1}", track.line.length
    low, high = joint.limits[name].low, joint.limits[name].high
    if low is None or high is None or low < 0.0 or high > length:
        said = f"joint '{joint.name}' may leave curve '{track.name}', which ends"
        yield Complaint(("joints", joint.name, "limits", name), said, f"give a range within [0, {length:.6g} m]")


def _hollow(tracks: Sequence[Track], joint: Joint) -> Iterator[Complaint]:
    """The complaint that the roundest part of one curve does not fit into a hollow of the other. Such curves would
    touch at several places."""
    from mbproj.functions.curve_soundness import At
    from mbproj.scene.blocks.curves import place

    sides = joint.parameters.get("sides", (None, None))
    bulges = [_bulge(track, side, joint, n) for n, (track, side) in enumerate(zip(tracks, sides, strict=True))]
    for number in (0, 1):
        (points, bulge), (_, other) = bulges[number], bulges[1 - number]
        worst = int(bulge.argmin())
        if bulge[worst] >= 0.0 or bulge[worst] + other.max() > 0.0:
            continue
        at, most = At(float(points[worst, 0]), float(points[worst, 1]), 0.0), float(other.max())
        said = f"curve '{tracks[number].name}' is hollow at {place(at)}, with a radius of {-1.0 / bulge[worst]:.4g} m"
        mate = f"curve '{tracks[1 - number].name}'"
        why = f"{mate} has one of {1.0 / most:.4g} m or more" if most > 0.0 else f"{mate} is hollow or straight"
        hint = "make it rounder there, or the hollow wider; look at the 'sides', too"
        yield Complaint(("joints", joint.name, "curves"), f"{said}: {why}, and does not fit into it", hint)
        return


def _bulge(track: Track, side: str | None, joint: Joint, number: int) -> tuple[np.ndarray, np.ndarray]:
    """The points (k, 2) in m where a curve may be touched within its limits, and the curvature (k,) of its profile
    there in 1/m: positive where it bulges towards the other curve, negative where it is hollow."""
    import numpy as np

    from mbproj.functions.curve_soundness import curvature

    places, κ = track.line.places, curvature(track.line)
    limit = joint.limits.get(f"displacement_{number + 1}")
    within = np.full(len(κ), True)
    if limit is not None:
        within &= places.length >= (0.0 if limit.low is None else limit.low) - track.line.length / len(κ)
        within &= places.length <= (np.inf if limit.high is None else limit.high) + track.line.length / len(κ)
    left = 1.0 if track.is_left(side) else -1.0
    return places.point[within], (-left * κ / (1.0 - κ * track.roller))[within]


# --- Rules on joints that follow a curve ------------------------------------------------------------------------------


#: The joint that holds the follower in both directions, by the one that lets it lift off.
HOLDS = {"cam_contact": "cam", "flat_contact": "flat_follower", "curve_contact": "curve_on_curve"}
#: A place of a curve counts as straight where its curvature times the size of the curve is at most this.
STRAIGHT = 1e-6


def fit_curves(
    curves: Mapping[str, Track | SpaceTrack],
    joints: Mapping[str, Joint],
    forces: Mapping[str, Any],
    motions: Mapping[str, Any],
) -> Iterator[Complaint]:
    """A check that joints which follow curves fit them, and that forces and motions along them are possible."""
    for joint in joints.values():
        wrong = [*_wrong_dimension(curves, joint)]
        yield from wrong
        if wrong:
            continue
        if (wire := curves.get(str(joint.parameters.get("curve")))) and _is_in_space(joint):
            yield from _passes_end(wire.line, joint)
            yield from _acts_along_closed(joint, {"displacement"} if wire.line.closed else set(), forces, motions)
            continue
        track: Any = curves.get(str(joint.parameters.get("curve")))
        lifts = "gap" in JOINTS[joint.type].coordinates
        both: list[Any] = [curves.get(name) for name in joint.parameters.get("curves", ())]
        if both and None not in both:
            yield from fit_two([each for each in both if each is not None], joint)
            yield from _gap_faults(joint, forces, motions) if lifts else ()
            closed = {f"displacement_{number}" for number, each in enumerate(both, 1) if each and each.line.closed}
            yield from _acts_along_closed(joint, closed, forces, motions) if not lifts else ()
        if track is not None:
            if lifts and not track.line.closed:
                said = f"curve '{track.name}' is open: what lifts off may pass its end"
                yield Complaint(("joints", joint.name, "curve"), said, "close it")
            yield from _gap_faults(joint, forces, motions) if lifts else ()
            if JOINTS[joint.type].frame == "face":
                yield from _under_face(track, joint)
                continue
            yield from _on_curve(track, joint)
            yield from _friction_of_roller(track, joint, forces)
            if track.line.closed and not lifts:
                yield from _acts_along_closed(joint, {"displacement"}, forces, motions)


def _on_curve(curve: Track, joint: Joint) -> Iterator[Complaint]:
    path: KeyPath = ("joints", joint.name)
    side, roller = joint.parameters.get("side"), joint.parameters.get("roller")
    able = ("outside", "inside") if curve.line.closed else ("left", "right")
    if side is not None and side not in able:
        kind = "closed" if curve.line.closed else "open"
        yield Complaint((*path, "side"), f"curve '{curve.name}' is {kind}", f"give {' or '.join(able)}")
        return
    radius = curve.roller if roller is None else roller
    rolls = "roller" in JOINTS[joint.type].parameters
    if rolls and radius and side is None and not curve.line.closed:
        yield Complaint(path, "a roller on an open curve needs its 'side'", "give left or right, along the curve")
        return
    if any(name == "surface" for name, *_ in JOINTS[joint.type].rows) and not curve.line.places.point[:, 0].max() > 0.0:
        said = f"curve '{curve.name}' is nowhere at x > 0, and its x is the distance from the axis"
        yield Complaint((*path, "curve"), said, "mirror it")
    if "gap" not in JOINTS[joint.type].coordinates:
        yield from _passes_end(curve.line, joint)
    if rolls:
        distance = curve.distance(side, radius)
        yield from _roller_too_large(curve, joint, distance, radius)


def _wrong_dimension(curves: Mapping[str, Track | SpaceTrack], joint: Joint) -> Iterator[Complaint]:
    """Complaints where a joint in space has a curve in a plane, or another joint has a curve in space."""
    if not joint.parameters.keys() & {"curve", "curves"}:
        return
    from mbproj.functions.space_curve import SpaceTrack

    wants_space = _is_in_space(joint)
    for key in ("curve", "curves"):
        names = joint.parameters.get(key, ())
        for name in (names,) if isinstance(names, str) else names:
            track = curves.get(name)
            if track is not None and isinstance(track, SpaceTrack) != wants_space:
                said = f"curve '{name}' is in a plane" if wants_space else f"curve '{name}' is in space"
                hint = "give 'space_points', or a 'slot'" if wants_space else "a joint of type 'space_slot' takes it"
                yield Complaint(("joints", joint.name, key), said, hint)


def _is_in_space(joint: Joint) -> bool:
    return any(each.may_be == "space_curve" for each in JOINTS[joint.type].parameters.values())


def _passes_end(line: PlaneCurve | SpaceCurve, joint: Joint) -> Iterator[Complaint]:
    """The complaint that a joint may leave an open curve, because its limits do not keep it within."""
    if line.closed:
        return
    path: KeyPath = ("joints", joint.name)
    limit, length = joint.limits.get("displacement"), line.length
    low, high = (None, None) if limit is None else (limit.low, limit.high)
    if low is None or high is None or low < 0.0 or high > length:
        hint = f"give limits: {{displacement: {{range: [0, {length:.6g} m], rigid: true}}}}, or less of it"
        at = path if limit is None else (*path, "limits", "displacement")
        yield Complaint(at, f"joint '{joint.name}' may leave its curve, which ends", hint)


def _under_face(curve: Track, joint: Joint) -> Iterator[Complaint]:
    """The complaint about a curve that a flat face cannot follow: it is open, made for a roller, or not convex."""
    from mbproj.functions.curve_soundness import least_bent
    from mbproj.scene.blocks.curves import place

    path: KeyPath = ("joints", joint.name, "curve")
    if not curve.line.closed:
        hint = "close it, or use a joint of type 'cam'"
        yield Complaint(path, f"curve '{curve.name}' is open: a flat face may pass its end", hint)
    elif curve.roller:
        hint = "leave its 'roller' out, or give flat: true"
        yield Complaint(path, f"curve '{curve.name}' was made for a roller, not for a flat face", hint)
    elif (least := least_bent(curve.line)).value <= STRAIGHT:
        said = f"curve '{curve.name}' is not convex at {place(least)}: a flat face does not touch it there alone"
        yield Complaint(path, said, "make it for the face: flat: true with a 'lift', or use a roller")


def _gap_faults(joint: Joint, forces: Mapping[str, Any], motions: Mapping[str, Any]) -> Iterator[Complaint]:
    """Complaints about a follower that may lift off: no limit keeps it out of the profile, or a force or a motion acts
    along its gap."""
    path: KeyPath = ("joints", joint.name)
    limit = joint.limits.get("gap")
    if limit is None or limit.low is None:
        at = path if limit is None else (*path, "limits", "gap")
        said = f"nothing keeps joint '{joint.name}' from passing through its curve"
        yield Complaint(at, said, "give limits: {gap: {range: [0, null], rigid: true}}, or a stiffness")
    for block, items in (("forces", forces), ("motions", motions)):
        for item in items.values():
            if getattr(item, "joint", None) == joint.name:
                hint = f"a joint of type '{HOLDS[joint.type]}' holds both ways; a stiffness of the limit is a spring"
                said = f"'{item.name}' acts along a gap, where only limits can act"
                yield Complaint((block, item.name), said, hint)


def _friction_of_roller(curve: Track, joint: Joint, forces: Mapping[str, Any]) -> Iterator[Complaint]:
    """Complaints about friction along a curve by the load of a roller: a roller rolls, so that its load resists no
    sliding."""
    if not ("roller" in JOINTS[joint.type].parameters and joint.parameters.get("roller", curve.roller)):
        return
    said = f"joint '{joint.name}' has a roller, which rolls: its friction cannot depend on its load"
    hint = "give a constant 'force', or friction to the roller's pin"
    for force in forces.values():
        dry = getattr(force, "coulomb", {}) if getattr(force, "joint", None) == joint.name else {}
        for coordinate, each in dry.items():
            if each.bearing is not None:
                path = ("forces", force.name, "coulomb", *([coordinate] if coordinate else []), "coefficient")
                yield Complaint(path, said, hint)


def _roller_too_large(curve: Track, joint: Joint, distance: float, radius: float) -> Iterator[Complaint]:
    from mbproj.functions.curve_soundness import largest_roller, touches_twice, undercut
    from mbproj.scene.blocks.curves import place

    fault = undercut(curve.line, distance) or touches_twice(curve.line, distance) if distance else None
    if fault is None:
        return
    left = curve.is_left(joint.parameters.get("side"))
    most = largest_roller(curve.line, left, curve.roller, THRESHOLDS.least_undercut)
    key = ("roller",) if "roller" in joint.parameters else ("curve",)
    said = f"a roller of {radius:.4g} m does not fit curve '{curve.name}' at {place(fault)}"
    yield Complaint(("joints", joint.name, *key), said, f"the largest that does is {most:.4g} m")


def _acts_along_closed(
    joint: Joint, closed: set[str], forces: Mapping[str, Any], motions: Mapping[str, Any]
) -> Iterator[Complaint]:
    """Complaints about limits, inertias, forces and motions along the `closed` displacements, those along closed
    curves: these begin at 0 again with each round."""
    hint = "act on another coordinate, or open the curve"
    for what in ("limits", "reflected_inertia"):
        if closed & getattr(joint, what).keys():
            said = "the displacement along a closed curve begins anew with each round"
            yield Complaint(("joints", joint.name, what), said, hint)
    for block, items in (("forces", forces), ("motions", motions)):
        for item in items.values():
            acts = getattr(item, "joint", None) == joint.name and bool(closed)
            if acts and not (_acts_elsewhere(item, closed) or _is_dry_friction(item)):
                said = f"'{item.name}' acts along a closed curve, whose displacement begins anew with each round"
                yield Complaint((block, item.name), said, hint)


def _acts_elsewhere(item: Any, closed: set[str]) -> bool:
    """Whether a force or motion names its coordinates, and none of these displacements is among them."""
    names = {getattr(item, "coordinate", None), *getattr(item, "laws", ()), *getattr(item, "coulomb", ())} - {None}
    return bool(names) and not names & closed


def _is_dry_friction(item: Any) -> bool:
    """Whether a force is dry friction alone, which depends on the rate of a coordinate, not on its value."""
    return bool(getattr(item, "coulomb", ())) and not getattr(item, "laws", ())
