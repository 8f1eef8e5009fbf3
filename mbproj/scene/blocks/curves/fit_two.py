"""Rules on two curves that touch: their sides, limits along open ones, and that one fits into the other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from mbproj.scene.fields.containers import Complaint
from mbproj.scene.records import Joint, KeyPath

if TYPE_CHECKING:
    import numpy as np

    from mbproj.functions.curves.track import Track


def fit_two(tracks: Sequence[Track], joint: Joint) -> Iterator[Complaint]:
    """A check that the two curves of a joint can touch on the sides, and within the limits, that the joint gives."""
    path: KeyPath = ("joints", joint.name)
    given = joint.parameters.get("sides")
    wrong = [*_wrong_sides(tracks, given, path)]
    yield from wrong
    if wrong:
        return
    for number, track in enumerate(tracks):
        if track.line.closed:
            continue
        if f"displacement_{number + 1}" not in joint.limits:
            yield from _open(track, joint, number)
        else:
            yield from _passes_end(track, joint, number)
    yield from _hollow(tracks, joint)


def _wrong_sides(tracks: Sequence[Track], given: tuple[str, ...] | None, path: KeyPath) -> Iterator[Complaint]:
    for number, track in enumerate(tracks):
        kind, able = ("closed", ("outside", "inside")) if track.line.closed else ("open", ("left", "right"))
        if given is None and not track.line.closed:
            said = f"curve '{track.name}' is open: say on which side of it the other curve is"
            yield Complaint(path, said, "give sides: two of left, right, along each; outside, inside of closed ones")
            return
        if given is not None and given[number] not in able:
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


def _passes_end(track: Track, joint: Joint, number: int) -> Iterator[Complaint]:
    name, length = f"displacement_{number + 1}", track.line.length
    low, high = joint.limits[name].low, joint.limits[name].high
    if low is None or high is None or low < 0.0 or high > length:
        said = f"joint '{joint.name}' may leave curve '{track.name}', which ends"
        yield Complaint(("joints", joint.name, "limits", name), said, f"give a range within [0, {length:.6g} m]")


def _hollow(tracks: Sequence[Track], joint: Joint) -> Iterator[Complaint]:
    """The complaint that the roundest part of one curve does not fit into a hollow of the other. Such curves would
    touch at several places."""
    from mbproj.functions.curves.soundness import At
    from mbproj.scene.blocks.curves.made import place

    sides = joint.parameters.get("sides", (None, None))
    bulges = [_bulge(track, side, joint, n) for n, (track, side) in enumerate(zip(tracks, sides, strict=True))]
    for number in (0, 1):
        (points, own), (_, other) = bulges[number], bulges[1 - number]
        worst = int(own.argmin())
        if own[worst] >= 0.0 or own[worst] + other.max() > 0.0:
            continue
        at, most = At(float(points[worst, 0]), float(points[worst, 1]), 0.0), float(other.max())
        said = f"curve '{tracks[number].name}' is hollow at {place(at)}, with a radius of {-1.0 / own[worst]:.4g} m"
        mate = f"curve '{tracks[1 - number].name}'"
        why = f"{mate} has one of {1.0 / most:.4g} m or more" if most > 0.0 else f"{mate} is hollow or straight"
        hint = "make it rounder there, or the hollow wider; look at the 'sides', too"
        yield Complaint(("joints", joint.name, "curves"), f"{said}: {why}, and does not fit into it", hint)
        return


def _bulge(track: Track, side: str | None, joint: Joint, number: int) -> tuple[np.ndarray, np.ndarray]:
    """The points (k, 2) in m where a curve may be touched within its limits, and the curvature (k,) of its profile
    there in 1/m: positive where it bulges towards the other curve, negative where it is hollow."""
    import numpy as np

    from mbproj.functions.curves.soundness import curvature

    places, κ = track.line.places, curvature(track.line)
    limit = joint.limits.get(f"displacement_{number + 1}")
    own = np.full(len(κ), True)
    if limit is not None:
        own &= places.length >= (0.0 if limit.low is None else limit.low) - track.line.length / len(κ)
        own &= places.length <= (np.inf if limit.high is None else limit.high) + track.line.length / len(κ)
    left = 1.0 if track.is_left(side) else -1.0
    return places.point[own], (-left * κ / (1.0 - κ * track.roller))[own]
