"""Dry friction along a given motion: it acts against the rate of its joint, and is zero where the joint rests."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mbproj.dynamics.derivatives.linear_equations import MotionAtTime
from mbproj.dynamics.equations.constraint_equations import set_velocity
from mbproj.dynamics.equations.kinematics import body_rates
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


class SlidingFrictions:
    """A system whose dry frictions act as sliding laws, cached by their directions of sliding."""

    def __init__(self, system: System, motions: Iterable[MotionAtTime]) -> None:
        self._system, self._by_directions = system, dict[tuple[float, ...], System]()
        self._fastest = 0.0 if system.frictions is None else max(_speed(system, each) for each in motions)

    def at(self, motion: MotionAtTime) -> System:
        """The system at a sample of the motion, with each friction sliding in its direction there."""
        frictions = self._system.frictions
        if frictions is None:
            return self._system
        rate = set_velocity(frictions.coordinates, motion.pose, motion.twist(motion.pose))
        size = np.where(frictions.coordinates.is_length, self._system.length, 1.0)
        moves = np.abs(rate) > THRESHOLDS.stop_rests * self._fastest * size
        found = tuple(np.where(moves, np.sign(rate), 0.0).tolist())
        if found not in self._by_directions:
            sliding = {k: direction for k, direction in enumerate(found) if direction}
            self._by_directions[found] = in_contact(self._system, Contacts(sliding=sliding))
        return self._by_directions[found]


def _speed(system: System, motion: MotionAtTime) -> float:
    """The speed of the fastest part of the mechanism, in its lengths and rad per s."""
    twist = motion.twist(motion.pose)
    return float(np.abs(twist.velocity).max() / system.length + np.abs(body_rates(motion.pose, twist)).max())
