"""Running a shipped mechanism in memory, and what follows from its recorded poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mbproj import read_scene, settings_to_run, simulate
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.system import System
from mbproj.motion.report import Report
from mbproj.scene.scene import Scene, read_scene_text
from tests.support import ROOT, Recorder, assembled

#: Tolerance at which what an integrator leaves is far below what the tests ask for.
TIGHT = {"integrator": "dop853", "tolerance": "1e-12"}
#: Short runs per formulation: the full one takes milliseconds a step.
BRIEF = {
    "reduced": TIGHT,
    "planar": TIGHT,
    "full": {"integrator": "dop853", "step": "20 ms", "output_step": "40 ms", "duration": "0.4"},
}


@dataclass(frozen=True)
class Run:
    """A finished run; indexing gives recorded arrays, first axis time."""

    scene: Scene
    system: System
    recorder: Recorder
    report: Report

    def __getitem__(self, path: str) -> np.ndarray:
        return self.recorder[path]

    @property
    def parameters(self) -> Mapping[str, float]:
        return self.scene.parameters

    def column(self, path: str, name: str) -> np.ndarray:
        """What was recorded at `path` of the body, marker, joint or coordinate of this name."""
        kind = "coordinates" if path in ("joints/coordinate", "joints/speed") else path.split("/")[0]
        return self[path][:, getattr(self.system.names, kind).index(name)]

    def rotation(self, body: str) -> np.ndarray:
        """Rotation matrices (T, 3, 3), body to global."""
        return rotation_matrix(self.column("bodies/orientation", body))


def run_scene(scene: Scene) -> Run:
    (system, state), recorder = assembled(scene), Recorder()
    return Run(scene, system, recorder, simulate(system, state, settings_to_run(scene), recorder))


def run(name: str, parameters: Mapping[str, Any] | None = None, **simulation: Any) -> Run:
    """The mechanism mechanisms/<name>.yaml with these parameters and settings."""
    options = {key: str(value) for key, value in simulation.items()}
    return run_scene(read_scene(ROOT / "mechanisms" / f"{name}.yaml", parameters or {}, options))


def run_text(text: str, parameters: Mapping[str, Any] | None = None, **simulation: Any) -> Run:
    """The scene of this text with these parameters and settings."""
    options = {key: str(value) for key, value in simulation.items()}
    return run_scene(read_scene_text(text, "scene.yaml", parameters or {}, options))


def global_angular_velocity(done: Run, body: str) -> np.ndarray:
    """ω (T, 3) in global axes."""
    return np.einsum("tij,tj->ti", done.rotation(body), done.column("bodies/angular_velocity", body))


def angular_momentum(done: Run, about: str = "centre") -> np.ndarray:
    """The angular momentum of all bodies in global axes (T, 3), about the common centre of mass or the "origin"."""
    mass = np.array([body.mass for body in done.scene.bodies])
    r, v = done["bodies/position"], done["bodies/velocity"]
    if about == "centre":
        r = r - np.einsum("b,tbi->ti", mass, r)[:, None] / mass.sum()
        v = v - np.einsum("b,tbi->ti", mass, v)[:, None] / mass.sum()
    total = np.einsum("b,tbi->ti", mass, np.cross(r, v))
    for body in done.scene.bodies:
        spin = done.column("bodies/angular_velocity", body.name) @ np.array(body.inertia)
        total += np.einsum("tij,tj->ti", done.rotation(body.name), spin)
    return total


def assert_close(found: np.ndarray, exact: np.ndarray | float | list[float], tolerance: float) -> None:
    """|found - exact| <= tolerance everywhere, absolutely."""
    error = np.abs(np.asarray(found) - np.asarray(exact)).max()
    assert error <= tolerance, f"off by {error:.3g}, {tolerance:.3g} is allowed"
