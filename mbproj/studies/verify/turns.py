"""Check of the scene's own steps: gears do not slip by teeth, screws by threads, or driven angles by turns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.observe.recorded import Block
from mbproj.integrate import simulate
from mbproj.model.system import System
from mbproj.scene import settings_to_run
from mbproj.scene.records import Settings
from mbproj.studies.verify.case import Case
from mbproj.studies.verify.finding import Finding, Found

#: Length of the run: this many of the scene's steps, or with error control this many radians of its fastest part.
STEPS, RADIANS = 64, 20.0
#: A deviation below this part of a tooth or turn is an error that the projection leaves, not a slip.
WHOLE = 0.5


def teeth_kept(case: Case) -> Found:
    """Count the teeth, threads or turns by which recorded coordinates leave what gears, screws and motions prescribe.
    The largest count over the scene's first steps is the finding."""
    if not (case.system.couplings.size or _driven_angles(case.system).size):
        return "there are no gears, screws or driven angles"
    recorder = TurnRecorder()
    simulate(case.system, case.mechanism.state, _short(case), recorder)
    away = slipped(case.system, recorder.coordinate, recorder.prescribed)
    return Finding(away, WHOLE, f"teeth or turns, in {len(recorder.coordinate) - 1} samples")


def slipped(system: System, coordinate: Array, prescribed: Array) -> float:
    """The largest number of teeth, threads or turns by which any sample differs from the first. `coordinate` (T, nc)
    are the joints' coordinates, `prescribed` (T, k) the values of motions."""
    sums, angles = system.couplings.sums(coordinate), _driven_angles(system)
    teeth = np.abs(sums - sums[0]) / np.where(system.couplings.period > 0.0, system.couplings.period, system.length)
    turns = np.abs(coordinate[:, system.motions.joint_coordinate] - prescribed)[:, angles] / (2.0 * np.pi)
    return float(max(teeth.max(initial=0.0), turns.max(initial=0.0)))


def _driven_angles(system: System) -> Integers:
    """The numbers of the motions that drive an angle."""
    return np.flatnonzero(~system.rows.is_length[system.joints.size :])


def _short(case: Case) -> Settings:
    """The scene's own settings, shortened to its first steps."""
    own = settings_to_run(case.scene)
    assert own.duration is not None
    if own.step is not None:
        return replace(own, duration=min(own.duration, STEPS * own.step), output_step=None)
    duration = min(own.duration, RADIANS / case.rate)
    return replace(own, duration=duration, output_step=duration / STEPS)


class TurnRecorder:
    """A recorder of the joints' coordinates and of the prescribed values of motions."""

    def __init__(self) -> None:
        self._blocks: list[Block] = []

    def write(self, block: Block) -> None:
        """Record a block of T samples."""
        self._blocks.append(block)

    @property
    def coordinate(self) -> Array:
        """The joints' coordinates, (T, nc)."""
        return np.concatenate([block["joints/coordinate"] for block in self._blocks])

    @property
    def prescribed(self) -> Array:
        """The prescribed values of motions, (T, k)."""
        return np.concatenate([block["motions/value"] for block in self._blocks])
