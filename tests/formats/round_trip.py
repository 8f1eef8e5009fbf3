"""A scene that is exported and imported again: how its bodies accelerate at the start, before and after."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import pose_of
from mbproj.equations.rank.mobility import mobility
from mbproj.formats.as_scene import scene_text
from mbproj.formats.export.exported import Written
from mbproj.formats.mechanism import ImportOptions
from mbproj.formats.read import read_model
from mbproj.linear.equilibrium.start import start_state
from mbproj.model.euler_parameters import matrix_L
from mbproj.motion.formulations.full import FullFormulation
from mbproj.scene.scene import Scene, read_scene_text
from tests.formats.agreement import _y


def again(written: Written, folder: Path, ending: str) -> Scene:
    """The scene that is read from what was written."""
    path = folder / f"model.{ending}"
    path.write_text(written.text, encoding="utf-8")
    if written.loops:
        (folder / "model.yaml").write_text(written.loops, encoding="utf-8")
    key = "start" if "<keyframe>" in written.text else None
    return read_scene_text(scene_text(read_model(path, ImportOptions(key=key)), "test"))


def accelerations(scene: Scene) -> dict[str, np.ndarray]:
    """Of each body that moves: that of its centre of mass and its angular one, global, at the assembled start."""
    system = compile_system(scene)
    state = start_state(scene, system)
    pose = pose_of(state.q)
    redundant = sum(mobility(system, pose).redundant.values())
    form = FullFormulation.of(system, state, scene.settings, redundant)
    a = form.accelerations(0.0, _y(form, state)).acceleration.reshape(-1, 7)
    v, L = state.v.reshape(-1, 7), matrix_L(state.q.reshape(-1, 7)[:, 3:])
    omega, alpha = (2.0 * np.einsum("nij,nj->ni", L, rows[:, 3:]) for rows in (v, a))
    found = {}
    for at, body in enumerate(scene.bodies):
        carrier = int(system.body_carrier[at])
        if carrier == system.bodies:
            continue
        R = pose.rotation[carrier]
        arm, w, turned = R @ system.body_offset[at], R @ omega[carrier], R @ alpha[carrier]
        moved = a[carrier, :3] + np.cross(turned, arm) + np.cross(w, np.cross(w, arm))
        found[body.name] = np.concatenate([moved, turned])
    return found


def difference(before: dict[str, np.ndarray], after: dict[str, np.ndarray]) -> float:
    """The largest over the bodies, relative to the largest acceleration, or to that of gravity."""
    scale = max(9.81, max(np.abs(each).max() for each in before.values()))
    return max(float(np.abs(before[name] - after[name]).max()) for name in before) / scale
