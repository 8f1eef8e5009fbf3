"""The data of a page: of one or several results, or of a scene at its start.

Given forces and torques depend on time only, and are computed again from the scene.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.forces import given_vectors
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.rank.components import component_rows, loops_of
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.model.system import System
from mbproj.results.analysis.trust import usual_limit
from mbproj.results.linear_files import StoredModes, read_modes, scene_of_modes
from mbproj.results.record import Results
from mbproj.scene.meshes import meshes_of
from mbproj.scene.scene import Scene
from mbproj.show.appearance.forces import LoadLook
from mbproj.show.appearance.mechanism import Look, View, look_of, view_of
from mbproj.show.appearance.motion import PoseHistory, motion_of
from mbproj.show.page.series import (
    THINNED,
    XYZ,
    Packer,
    PageFrames,
    SeriesGroup,
    fitting,
    frames_of,
    group_data,
    groups_of,
    largest_between,
    look_data,
    motion_data,
    path_data,
    view_data,
)

#: The most bodies for which passages are searched: with more, the search would take longer than all else.
MOST_BODIES = 60


@dataclass(frozen=True, eq=False)
class PageData:
    """The contents of a page: its title, plain data for JSON, and packed numbers."""

    title: str
    data: dict[str, Any]
    packer: Packer


def page_of(
    results: Sequence[Results], labels: Sequence[str], full: bool = False, limit: float | None = None
) -> PageData:
    """The page of one run, or of several in one picture: the first is solid, the others are ghosts. `limit` (m) is the
    error beyond which a certified run is not trusted."""
    packer = Packer()
    views: list[View] = []
    runs = []
    for result, label in zip(results, labels, strict=True):
        scene, motion = result.scene, motion_of(result)
        look = look_of(scene, motion, result.meshes())
        views.append(view_of(scene, motion, look))
        runs.append(_run(result, scene, look, motion, label, packer, full, limit))
        better = _better(result, runs[-1]["trust"], frames_of(result.time, motion.finite, len(look.bodies), full).rows)
        if better is not None:
            views.append(view_of(scene, better, look))
            ghost = f"better solution of {label}" if len(results) > 1 else "better solution"
            runs.append(_ghost(ghost, runs[-1], better, look, packer))
    title = results[0].title or labels[0]
    return PageData(title, {"title": title, "view": view_data(_together(views)), "runs": runs}, packer)


def start_of(scene: Scene, motion: PoseHistory, title: str) -> PageData:
    """The page of a scene at its start, without a run."""
    packer = Packer()
    look = look_of(scene, motion, meshes_of(scene))
    view = view_of(scene, motion, look)
    run = {
        "label": title,
        "look": look_data(look, packer),
        **motion_data(motion, look.size, packer),
        "groups": [],
        "events": [],
        "trust": None,
        "remarks": ["the start, assembled; nothing was run"],
        "blocks": packer.blocks,
    }
    return PageData(title, {"title": title, "view": view_data(view), "runs": [run]}, packer)


def _run(
    result: Results,
    scene: Scene,
    look: Look,
    motion: PoseHistory,
    label: str,
    packer: Packer,
    full: bool,
    limit: float | None,
) -> dict[str, Any]:
    whole = motion.finite
    frames = frames_of(result.time, whole, len(look.bodies), full)
    shown = motion.at(frames.rows)
    system = compile_system(scene)
    groups = [group_data(group, values, packer) for group, values in load_groups(system, look.loads, shown)]
    fitted, left = fitting(groups_of(result), len(frames.rows))
    for group in fitted:
        values = group.values(result)
        peaks = group.name.endswith("violation")
        values = largest_between(values, whole, frames.rows) if peaks else values[frames.rows]
        groups.append(group_data(group, values, packer))
    left_out = ", ".join(dict.fromkeys(f"{group.name} of {group.kind}" for group in left))
    remarks = [
        "" if result.status == "complete" else result.status,
        frames.remark,
        f"no room for the series: {left_out}" if left_out else "",
    ]
    return {
        "label": label,
        "look": look_data(look, packer),
        **motion_data(shown, look.size, packer),
        "contacts": path_data(look, shown, packer),
        "groups": groups,
        "events": [*_events(result, frames), *_passages(system, shown)],
        "trust": _trust(result, limit),
        "remarks": [remark for remark in remarks if remark],
        "blocks": packer.blocks,
    }


def _events(result: Results, frames: PageFrames) -> list[dict[str, Any]]:
    """The events of the run, and its failure if it failed, in the order of time."""
    events = [{"time": event.time, "text": f"{event.kind}: {event.name}", "kind": "event"} for event in result.events]
    if result.status.startswith("failed") and len(frames.rows):
        events.append({"time": float(result.time[frames.rows[-1]]), "text": result.status, "kind": "failure"})
    return events


def _passages(system: System, motion: PoseHistory) -> list[dict[str, Any]]:
    return [
        {"time": time, "text": f"near a singular position: {part:.2g} of the usual distance", "kind": "passage"}
        for time, part in passages(system, motion)
    ]


def _trust(result: Results, limit: float | None) -> dict[str, Any] | None:
    """The time from which on the error may exceed the limit, with a text; None for a run without a certificate."""
    trust = result.trust
    if trust is None:
        return None
    bound = usual_limit([result]) if limit is None else limit
    since = trust.untrusted_from(bound)
    text = "" if since is None else f"not to be trusted from {since:.4g} s on: the error may exceed {bound:g} m"
    return {"since": since, "limit": bound, "text": text, "solution": trust.solution}


def _better(result: Results, trust: Mapping[str, Any] | None, rows: Integers) -> PoseHistory | None:
    """The better solution of a certified run, at the frames from which on the run is not trusted; None where there is
    none."""
    poses = result.better()
    if trust is None or trust["since"] is None or poses is None:
        return None
    motion = PoseHistory(result.time[: len(poses.position)], poses.position, poses.orientation)
    shown = np.intersect1d(rows, motion.finite)
    shown = shown[result.time[shown] >= trust["since"]]
    return motion.at(shown) if len(shown) else None


def _ghost(label: str, run: Mapping[str, Any], motion: PoseHistory, look: Look, packer: Packer) -> dict[str, Any]:
    """A better solution as a ghost beside its run."""
    bare: dict[str, Any] = {"groups": [], "events": [], "trust": None, "remarks": []}
    contacts = path_data(look, motion, packer)
    moved = {**run, **motion_data(motion, look.size, packer), "contacts": contacts, **bare}
    return {**moved, "label": label, "ghost": True, "from": run["trust"]["since"]}


def _together(views: Sequence[View]) -> View:
    """The view direction of the first view, with room for all."""
    first, points = views[0], np.concatenate([view.points for view in views])
    low, high = points.min(axis=0), points.max(axis=0)
    return View(0.5 * (low + high), first.eye, first.up, 0.5 * float(np.linalg.norm(high - low)), points, first.flat)


def load_groups(system: System, looks: Sequence[LoadLook], motion: PoseHistory) -> Iterator[tuple[SeriesGroup, Array]]:
    """The group of all given forces, and that of all given torques, each with its global components (T, 3w)."""
    if not looks:
        return
    if any(system.forces.programs.names_channels(index) for index in system.forces.on_bodies.program.ravel().tolist()):
        return
    instants = (_instant(system, float(t), q) for t, q in zip(motion.time, carried(system, motion), strict=True))
    vectors = np.array([given_vectors(instant) for instant in instants])
    for torque, name, unit in ((False, "given force", "N"), (True, "given torque", "N m")):
        chosen = [at for at, look in enumerate(looks) if look.torque == torque]
        owners = tuple(looks[at].name for at in chosen)
        if owners:
            group = SeriesGroup(name, "forces", owners, XYZ, (unit,) * len(owners), "")
            yield group, vectors[:, chosen].reshape(len(vectors), -1)


def _instant(system: System, t: float, q: Array) -> Instant:
    """The instant at which functions of time are evaluated."""
    pose = pose_of(q)
    return Instant(system, pose, twist_of(pose, np.zeros_like(q)), t, coordinate_values(system, pose))


def passages(system: System, motion: PoseHistory) -> Iterator[tuple[float, float]]:
    """The time (s) of the nearest frame of each passage, and its distance: the smallest singular value of a loop's
    rows, relative to its largest value in this motion."""
    loops = loops_of(system) if system.bodies <= MOST_BODIES else []
    if not loops or len(motion.time) < 3:
        return
    q = carried(system, motion)
    by_frame = [
        [np.linalg.svd(rows, compute_uv=False) for rows in component_rows(system, pose_of(each), loops)] for each in q
    ]
    for loop in range(len(loops)):
        values = np.array([frame[loop] for frame in by_frame])
        rank = int((values > THRESHOLDS.dependent * values[:, :1]).sum(axis=1).max())
        smallest = values[:, rank - 1] / values[:, rank - 1].max()
        for row in dips(smallest, THRESHOLDS.near_singular):
            yield float(motion.time[row]), float(smallest[row])


def dips(values: Array, below: float) -> Iterator[int]:
    """The rows of the minima of `values` (T,) in each stretch below a limit that begins and ends above it."""
    low = np.concatenate([[False], values < below, [False]])
    starts, ends = np.flatnonzero(~low[:-1] & low[1:]), np.flatnonzero(low[:-1] & ~low[1:])
    for start, end in zip(starts, ends, strict=True):
        if start > 0 and end < len(values):
            yield int(start + np.argmin(values[start:end]))


def carried(system: System, motion: PoseHistory) -> Array:
    """The coordinates (T, 7n) of the carriers, each computed from the first body fixed to it."""
    first = np.array([np.flatnonzero(system.body_carrier == carrier)[0] for carrier in range(system.bodies)])
    back = system.body_turn[first] * [1.0, -1.0, -1.0, -1.0]
    orientation = product(motion.orientation[:, first], np.broadcast_to(back, (len(motion.time), *back.shape)))
    arm = (rotation_matrix(orientation) @ system.body_offset[first][..., None])[..., 0]
    q = np.concatenate([motion.position[:, first] - arm, orientation], axis=-1)
    return q.reshape(len(motion.time), -1)


# --- The data of a page of modes --------------------------------------------------------------------------------------
# The linearised pose, and the shape of each mode about it.


#: The initial amplitude of a page: a part of the mechanism's size, and of 1 rad.
AMPLITUDE = 0.15
#: The binary digits of shapes, whose largest number is 1.
DIGITS = 20
#: The number of modes for whose largest swing the first view has room.
IN_VIEW = 30
LARGER = "shapes are drawn larger than small motions are: joints seem to open"


def page_of_modes(path: Path, label: str) -> PageData:
    """The page of a file of modes. Raises InputError where the file has no mode."""
    modes = read_modes(path)
    if not len(modes.eigenvalue):
        raise InputError(Problem(f"'{path}' has no mode to show", hint="its mechanism has no degree of freedom"))
    scene, meshes = scene_of_modes(path, modes.bodies)
    pose = PoseHistory(np.zeros(1), modes.position[None], modes.orientation[None])
    size = look_of(scene, pose, meshes).size
    count = min(len(modes.eigenvalue), max(1, THINNED // (12 * max(len(modes.bodies), 1))))
    scales, shapes = unit_shapes(modes.displacement[:count], size)
    swings = swing_ends(modes, shapes[:IN_VIEW], size)
    look = look_of(scene, swings, meshes)
    packer = Packer()
    turning = np.array([1.0 if unit == "rad" else size for unit in modes.coordinate_units])
    along = _turning_on(modes, modes.coordinate_shape[:count]) / scales[:, None]
    shown = {
        "size": size,
        "amplitude": AMPLITUDE,
        "list": [{"name": modes.names[mode], "words": words_on(modes, mode)} for mode in range(count)],
        "shape": packer.add(_halves(_turning_on(modes, shapes).reshape(count, -1)), 2.0**-DIGITS),
        "coordinates": list(modes.coordinates),
        "units": list(modes.coordinate_units),
        "along": packer.add(_halves(along), np.tile(turning * 2.0**-DIGITS, 2)),
    }
    left = len(modes.eigenvalue) - count
    remarks = [*modes.notes.splitlines(), LARGER, f"no room for the {left} fastest modes" if left else ""]
    run = {
        "label": label,
        "look": look_data(look, packer),
        **motion_data(pose, look.size, packer),
        "groups": [],
        "events": [],
        "trust": None,
        "remarks": [remark for remark in remarks if remark],
        "blocks": packer.blocks,
    }
    rest = {**run, "label": "the pose", "ghost": True, "remarks": []}
    title = modes.title or label
    data = {"title": title, "view": view_data(view_of(scene, swings, look)), "runs": [{**run, "modes": shown}, rest]}
    return PageData(title, data, packer)


def words_on(modes: StoredModes, mode: int) -> str:
    """The motion of a mode in words."""
    value, damping = modes.eigenvalue[mode], modes.damping_ratio[mode]
    if value == 0.0:
        return "neutral: nothing drives it back"
    grows = value.real > 0.0
    constant = f"by e in {1.0 / abs(value.real):.4g} s" if value.real != 0.0 else ""
    if value.imag == 0.0:
        return f"does not oscillate: it {'grows' if grows else 'falls'} {constant}"
    rings = f"{modes.frequency[mode]:.4g} Hz, damping ratio {damping:.3g}"
    return f"{rings}: it grows {constant}" if grows else rings


def unit_shapes(displacement: Numbers, size: float) -> tuple[Array, Numbers]:
    """The scale of each mode (k, n, 6), and its shape divided by the scale. Then the largest displacement is `size`, or
    the largest rotation 1 rad."""
    parts = displacement / np.array([size] * 3 + [1.0] * 3)
    largest = np.linalg.norm(parts.reshape(*parts.shape[:2], 2, 3), axis=-1).max(axis=(1, 2), initial=0.0)
    scales = np.where(largest > 0.0, largest, 1.0)
    return scales, parts / scales[:, None, None]


def swing_ends(modes: StoredModes, shapes: Numbers, size: float) -> PoseHistory:
    """The pose, then the two ends of each swing at the initial amplitude, for the real and the imaginary part of each
    shape."""
    parts = AMPLITUDE * np.concatenate([sign * half for half in (shapes.real, shapes.imag) for sign in (1.0, -1.0)])
    parts = np.concatenate([np.zeros((1, *parts.shape[1:])), parts])
    angle = np.linalg.norm(parts[..., 3:], axis=-1, keepdims=True)
    axis = parts[..., 3:] / np.where(angle > 0.0, angle, 1.0)
    turn = np.concatenate([np.cos(0.5 * angle), np.sin(0.5 * angle) * axis], axis=-1)
    return PoseHistory(np.zeros(len(parts)), modes.position + size * parts[..., :3], product(turn, modes.orientation))


def _turning_on(modes: StoredModes, shapes: Numbers) -> Numbers:
    """Shapes (k, ..), conjugated where needed, so that their motion is Re(shape · exp(iφ)) with a growing phase φ."""
    back = modes.eigenvalue[: len(shapes)].imag < 0.0
    return np.where(back.reshape(-1, *[1] * (shapes.ndim - 1)), shapes.conj(), shapes)


def _halves(values: Numbers) -> Array:
    return np.concatenate([values.real, values.imag], axis=1)
