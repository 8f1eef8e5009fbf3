"""Check of the scene's own steps: gears keep their teeth, screws their threads, and driven angles count their turns."""

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

#: The scene is run for so many of its steps; with error control, for as many radians of its fastest part, in samples.
STEPS, RADIANS = 64, 20.0
#: A smaller part of a tooth or turn is what the projection leaves open.
WHOLE = 0.5


def teeth_kept(case: Case) -> Found:
    """By how many teeth, threads or turns the recorded coordinates are away from where gears, screws and motions hold
    them: the most over the scene's first steps."""
    if not (case.system.couplings.size or _driven_angles(case.system).size):
        return "there are no gears, screws or driven angles"
    kept = TurnRecorder()
    simulate(case.system, case.mechanism.state, _short(case), kept)
    away = slipped(case.system, kept.coordinate, kept.prescribed)
    return Finding(away, WHOLE, f"teeth or turns, in {len(kept.coordinate) - 1} samples")


def slipped(system: System, coordinate: Array, prescribed: Array) -> float:
    """From the joints' coordinates (T, nc) and what motions prescribe (T, k): the largest number of teeth, threads or
    turns that any sample is away from the first."""
    sums, angles = system.couplings.sums(coordinate), _driven_angles(system)
    teeth = np.abs(sums - sums[0]) / np.where(system.couplings.period > 0.0, system.couplings.period, system.length)
    turns = np.abs(coordinate[:, system.motions.joint_coordinate] - prescribed)[:, angles] / (2.0 * np.pi)
    return float(max(teeth.max(initial=0.0), turns.max(initial=0.0)))


def _driven_angles(system: System) -> Integers:
    """The motions that drive an angle."""
    return np.flatnonzero(~system.rows.is_length[system.joints.size :])


def _short(case: Case) -> Settings:
    """The scene's own settings, over its first steps."""
    own = settings_to_run(case.scene)
    assert own.duration is not None
    if own.step is not None:
        return replace(own, duration=min(own.duration, STEPS * own.step), output_step=None)
    duration = min(own.duration, RADIANS / case.rate)
    return replace(own, duration=duration, output_step=duration / STEPS)


class TurnRecorder:
    """A recorder of the joints' coordinates and what motions prescribe."""

    def __init__(self) -> None:
        self._blocks: list[Block] = []

    def write(self, block: Block) -> None:
        """Takes T samples."""
        self._blocks.append(block)

    @property
    def coordinate(self) -> Array:
        """(T, nc)."""
        return np.concatenate([block["joints/coordinate"] for block in self._blocks])

    @property
    def prescribed(self) -> Array:
        """(T, k)."""
        return np.concatenate([block["motions/value"] for block in self._blocks])
