"""The data of a page: of one or several results, or of a scene at its start.

Given forces and torques depend on time only, and are computed again from the scene.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from mbproj.analysis.trust import usual_limit
from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.dynamics.assembly.assemble import coordinate_values
from mbproj.dynamics.equations.forces import given_vectors
from mbproj.dynamics.equations.instant import Instant
from mbproj.dynamics.equations.kinematics import pose_of, twist_of
from mbproj.dynamics.rank.components import component_rows, loops_of
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.model.system import System
from mbproj.pages.appearance.forces import LoadLook
from mbproj.pages.appearance.mechanism import Look, look_of
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.pages.appearance.recorded import motion_of
from mbproj.pages.appearance.view import View, view_of
from mbproj.pages.data.frames import PageFrames, frames_of, largest_between
from mbproj.pages.data.packing import Packer
from mbproj.pages.data.page_data import group_data, look_data, motion_data, path_data, view_data
from mbproj.pages.data.series import XYZ, SeriesGroup, fitting, groups_of
from mbproj.results import Results
from mbproj.scene.meshes import meshes_of
from mbproj.scene.read import Scene
from mbproj.thresholds import THRESHOLDS

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
    kept, left = fitting(groups_of(result), len(frames.rows))
    for group in kept:
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
