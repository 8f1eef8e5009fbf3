"""A mechanism at stops: the gaps, their rates and accelerations, and bounds on the pushes."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.freedom import Free, Freedom, counted_coordinates
from mbproj.dynamics.contact.impact import contact_pushes
from mbproj.dynamics.contact.inside import stop_sizes
from mbproj.dynamics.equations.energy import kinetic_energy
from mbproj.dynamics.equations.gaps import gap_rates, gaps
from mbproj.dynamics.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.stops import Stops
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


class Touch:
    """A mechanism at its stops in one state, where the compliant stops in `pushing` push."""

    def __init__(self, system: System, stops: Stops, state: State, pushing: dict[int, float]) -> None:
        self.system, self.state, self.stops = in_contact(system, Contacts((), pushing)), state, stops
        pose = pose_of(state.q)
        twist = twist_of(pose, state.v)
        self.gap, self.rate = gaps(self.stops, pose, state.turns), gap_rates(self.stops, pose, twist)
        self.size = stop_sizes(system)
        self.near = self.gap <= THRESHOLDS.touching * self.size
        speed = np.abs(twist.velocity).max() / system.length + np.abs(body_rates(pose, twist)).max()
        self.slow = THRESHOLDS.stop_rests * self.size * speed
        self.kinetic = float(kinetic_energy(system, pose, twist))

    @cached_property
    def freedom(self) -> Freedom:
        return Freedom.at(self.system, self.state)

    @cached_property
    def N(self) -> Array:
        return self.freedom.rows(self.stops)

    @cached_property
    def free(self) -> Free:
        """The motion without contacts of rigid stops and without dry friction."""
        return self.freedom.free(self.counted)

    @cached_property
    def acceleration(self) -> Array:
        """The accelerations of the gaps in the motion `free`, (S,)."""
        return self.freedom.gap_accelerations(self.stops, self.free)

    @property
    def round_off(self) -> Array:
        """The round-off of the accelerations of gaps, (S,)."""
        found: Array = self.freedom.round_off(self.free) * np.linalg.norm(self.N, axis=1)
        return found

    def least_push(self, touching: Flags) -> float:
        """Return the push, in N or N m, at these stops beside which a pull within round-off counts as zero."""
        size = np.linalg.norm(self.N[touching], axis=1)
        none = self.freedom.round_off(self.free) / float(size[size > 0.0].min(initial=np.inf))
        return none / THRESHOLDS.contact_pulls

    @property
    def counted(self) -> Array:
        """The joints' coordinates with turns, (nc,)."""
        return counted_coordinates(self.system, self.state)

    def fall(self, rigid: Flags) -> Array:
        """Return the accelerations (S,) at which gaps close while resting `rigid` stops hold: a ball that rests on the
        floor then stops another that falls on it."""
        rest = np.flatnonzero(rigid & (np.abs(self.rate) <= self.slow))
        pushes = contact_pushes(self.N[rest], self.acceleration[rest]) if rest.size else None
        held = 0.0 if pushes is None else self.N @ (self.N[rest].T @ pushes)
        return -(self.acceleration + held)

    def after(self, v: Array) -> Touch:
        """Return the contact with velocities v. The bound below which rates count as slow stays, because round-off
        does."""
        touch = Touch.__new__(Touch)
        moving = ("freedom", "free", "N", "acceleration")
        touch.__dict__.update({k: x for k, x in self.__dict__.items() if k not in moving})
        touch.state = self.state.changed(velocities=v)
        pose = pose_of(touch.state.q)
        touch.rate = gap_rates(self.stops, pose, twist_of(pose, v))
        return touch
