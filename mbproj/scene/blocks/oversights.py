"""Notes on a legal scene that looks like an oversight: bodies that nothing holds, joints far from their bodies, points
of a cam that were rounded.

A wrong note is worse than none. Where all bodies are free they are so on purpose, and a spring holds a body as well as
a joint. The inertia tells the length of a body that is longer than wide. A compact body may hang on a long massless
rod; its joint is noted only where the rod is many times as long as the rest of the scene. A sliding joint may be placed
anywhere along its axis, and a fixed one anywhere.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from mbproj.base.errors import Place, Problem, shortened
from mbproj.joints.table import COORDINATE_UNITS, JOINTS
from mbproj.scene.fields.rotations import principal_moments
from mbproj.scene.records import GROUND, Body, Bushing, Joint, PointForce

if TYPE_CHECKING:
    from mbproj.functions.space_curve import SpaceTrack, Track
    from mbproj.scene.scene import Scene


#: A joint is far from a body where its distance from the centre of mass is more than this many lengths of the body.
#: Half a length is usual.
FAR = 8.0
#: A body is longer than wide where its largest principal moment is more than this multiple of the least.
LONG = 3.0
#: A joint is far from its bodies where its distance is more than this multiple of the size of the rest of the scene.
ALONE = 100.0
#: The most notes of one kind, and the most names in one note.
MOST = 5
#: Numbers are rounded to a digit where they differ from it by less than ROUGHLY of its unit; DIGITS are tried.
ROUGHLY, DIGITS = 1e-6, 12
#: Curves with fewer points are drawn by a designer; they are no table of a cam, and give no note.
FEWEST = 24
#: The least uncertainty that is reported, relative to half the lift: the acceleration per ω² of a harmonic motion.
FELT = 0.05


def notes_on(scene: Scene) -> list[Problem]:
    """The notes of the reader on the scene, and those of `oversights`."""
    return [*scene.notes, *oversights(scene)]


def oversights(scene: Scene) -> list[Problem]:
    """A note for each group of bodies that nothing holds, each joint far from its body, and each rounded curve."""
    rough = list(_rough(scene)) if scene.curves else []
    far = list(_far(scene)) or list(_alone(scene))  # one joint would be noted twice
    return [*_shortened(list(_loose(scene))), *_shortened(far), *_shortened(rough)]


def _shortened(notes: list[Problem]) -> list[Problem]:
    left = len(notes) - MOST
    return notes if left <= 0 else [*notes[:MOST], Problem(f"... and {left} more of this kind")]


def _line_of(scene: Scene, *path: str) -> Place | None:
    """The place of the value at `path`."""
    place = scene.place(*path)
    return None if place is None else Place(place.file, place.line, place.column)


# --- Bodies that nothing holds ----------------------------------------------------------------------------------------


def _loose(scene: Scene) -> Iterator[Problem]:
    """A note for each group of bodies that no joint or spring connects with the ground. Where nothing is on the ground,
    as in a spacecraft, only single bodies are noted; and none where all bodies are single."""
    groups = _connected(scene)
    single = [group for group in groups if len(group) == 1]
    if len(single) == len(groups):
        return
    for group in single if [GROUND] in groups else groups:
        if GROUND in group:
            continue
        if len(group) == 1:
            message = f"no joint holds body '{group[0]}': it moves freely"
        else:
            message = (
                f"no joint connects the bodies {shortened([*map(repr, group)], MOST)} with the ground: they move freely"
            )
        yield Problem(message, _line_of(scene, "bodies", group[0]))


def _connected(scene: Scene) -> list[list[str]]:
    """The names of the ground and the bodies, in groups that joints and springs connect, in the order of the scene."""
    root = {name: name for name in (GROUND, *(body.name for body in scene.bodies))}

    def find(name: str) -> str:
        while root[name] != name:
            root[name] = name = root[root[name]]
        return name

    springs = (force for force in scene.forces if isinstance(force, PointForce | Bushing))
    pairs = [joint.bodies for joint in scene.joints if joint.couples is None] + [force.bodies for force in springs]
    for first, second in pairs:
        root[find(second)] = find(first)
    groups: dict[str, list[str]] = {}
    for name in root:
        groups.setdefault(find(name), []).append(name)
    return list(groups.values())


# --- Joints far from their bodies -------------------------------------------------------------------------------------


def _far(scene: Scene) -> Iterator[Problem]:
    """A note for each joint that is many lengths of a body away from it."""
    bodies = {body.name: body for body in scene.bodies}
    for joint in scene.joints:
        if joint.couples is not None or _may_be_anywhere(joint):
            continue
        for name, point in zip(joint.bodies, (joint.points.first, joint.points.second), strict=True):
            if name == GROUND:
                continue
            body = bodies[name]
            arm = math.dist(point, (0.0, 0.0, 0.0) if joint.points.local else body.position)
            length = _length(body, arm)
            if length is not None and arm > FAR * length:
                message = (
                    f"joint '{joint.name}' is {arm:.3g} m from the centre of mass of body '{name}', which is about "
                    f"{length:.2g} m long by its inertia"
                )
                yield Problem(message, _line_of(scene, "joints", joint.name), "look at its location, and at its units")


def _alone(scene: Scene) -> Iterator[Problem]:
    """A note for each joint that is much farther from its bodies than the rest of the scene is large. Where most joints
    are so far, they are long pendulums, and no note is given."""
    bodies = {body.name: body.position for body in scene.bodies}
    joints = [joint for joint in scene.joints if joint.couples is None and not joint.points.local]
    arms = {
        joint.name: min(math.dist(joint.points.first, bodies[name]) for name in joint.bodies if name != GROUND)
        for joint in joints
    }
    median = sorted(arms.values())[(len(arms) - 1) // 2] if arms else 0.0
    usual = max(median, _extent(list(bodies.values())))
    far = [joint.name for joint in joints if arms[joint.name] > ALONE * usual and not _may_be_anywhere(joint)]
    size = _extent([*bodies.values(), *(joint.points.first for joint in joints if joint.name not in far)])
    for name in far:
        if arms[name] > ALONE * size > 0.0:
            message = (
                f"joint '{name}' is {arms[name]:.3g} m from the bodies that it holds, and all else is within "
                f"{size:.2g} m"
            )
            yield Problem(message, _line_of(scene, "joints", name), "look at its location, and at its units")


def _extent(points: Sequence[Sequence[float]]) -> float:
    """The diagonal of the box around some points."""
    return math.hypot(*(max(along) - min(along) for along in zip(*points, strict=True)))


def _may_be_anywhere(joint: Joint) -> bool:
    """Whether a joint may be far from its bodies: it slides, or it merges them to one."""
    kind = JOINTS[joint.type]
    return kind.merges or any(COORDINATE_UNITS[row[0]] == "m" for row in kind.coordinates.values())


def _length(body: Body, arm: float) -> float | None:
    """The length in m of a uniform rod with the body's inertia; None for a compact body. None also where the distance
    `arm` in m is certainly not far, which saves the eigenvalues."""
    trace = sum(body.inertia[i][i] for i in range(3))
    if body.mass == 0.0 or arm**2 * body.mass <= FAR**2 * 4.0 * trace:  # the largest moment is >= a third of the trace
        return None
    least, _, largest = principal_moments(body.inertia)
    return math.sqrt(12.0 * largest / body.mass) if largest > LONG * least else None


# --- Points of a cam that were rounded --------------------------------------------------------------------------------


def _rough(scene: Scene) -> Iterator[Problem]:
    """A note for each curve whose points were rounded so much that the accelerations of a follower are uncertain."""
    for track in scene.curves:
        roughness = uncertainty(track)
        if roughness is not None:
            digit, bend = roughness
            message = (
                f"the points of curve '{track.name}' are rounded to {1e6 * digit:.3g} µm: accelerations are uncertain "
                f"by {bend:.2g} m times the square of the speed in rad/s"
            )
            yield Problem(message, _line_of(scene, "curves", track.name), "give the lift law, or more digits")


def uncertainty(track: Track | SpaceTrack) -> tuple[float, float] | None:
    """The unit in m to which the N points of a closed curve were rounded, and the error of a follower's acceleration,
    in m per (rad/s)². The error is 12 r (N/2π)² with r half the unit. None where it is small, or the rounding is not
    known."""
    from mbproj.functions.curve_pieces import Form
    from mbproj.functions.space_curve import SpaceTrack

    if isinstance(track, SpaceTrack):
        return None
    polar = track.line.pieces[0].form is Form.POLAR
    rows = track.rows[:-1] if polar else track.rows
    if not track.line.closed or len(rows) < FEWEST:
        return None
    lengths = [row[1] for row in rows] if polar else [each for row in rows for each in row]
    radii = [row[1] if polar else math.hypot(*row) for row in rows]
    half = grain(lengths)
    error = 12.0 * half * (len(rows) / (2.0 * math.pi)) ** 2
    return (2.0 * half, error) if error > FELT * 0.5 * (max(radii) - min(radii)) else None


def grain(numbers: Sequence[float]) -> float:
    """Half of the last decimal digit that numbers are rounded to, in their unit; 0 if they have more than 12 digits."""
    largest = max(abs(number) for number in numbers)
    for digits in range(DIGITS):
        unit = 10.0 ** (math.ceil(math.log10(largest)) - digits)
        if all(abs(number / unit - round(number / unit)) < ROUGHLY for number in numbers):
            return 0.5 * unit
    return 0.0
