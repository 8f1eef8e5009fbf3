"""What mechanics asks of a run by itself: joints closed at all three levels, energy in balance, momentum conserved."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from mbproj import System
from mbproj.base.arrays import Numbers
from mbproj.equations.constraints import jacobian, position_grain, velocity_grain
from mbproj.equations.kinematics import pose_of, twist_of

from .conserved import angular_momentum, momentum
from .finding import Finding, off
from .motion import Motion
from .round_off import ROUND_OFF, RoundOff

#: Joints are to be closed to so many times what round-off leaves; none has to be closed further than the default
#: tolerance of the projection asks for.
ATTAINABLE, CLOSED = 100.0, 1e-13
#: The error of a run is at most so many times its distance to the run with half the step; and what round-off does in
#: ten steps is at most so many times what it does in one.
MARGIN, ADDS_UP = 2.0, 10.0


def invariants(system: System, done: Motion, limits: list[RoundOff], free: bool) -> Iterator[Finding]:
    """Of a run with the round-off at its first and last sample; `free`: nothing but gravity acts from outside."""
    yield from _closure(system, done, limits)
    # Poses are closed to `CLOSED` only, which reactions turn into energy.
    pull = float(np.abs(done.samples.multipliers).sum(axis=-1).max(initial=0.0))
    energies = ("kinetic_energy", "potential_energy")
    size = sum(float(np.abs(done.block[f"diagnostics/{part}"]).max()) for part in energies)
    size += _weighed(system, done) + pull
    yield _kept("energy", done, lambda run: run.block["diagnostics/energy_balance"], ADDS_UP * ROUND_OFF * size)
    if free:
        straight, size = momentum(system, done.samples)
        size += pull * float(done.samples.t[-1])
        yield off("momentum", straight - straight[0], ADDS_UP * ROUND_OFF * size)
        size += angular_momentum(system, done.samples)[1]
        yield _kept(
            "angular momentum", done, lambda run: angular_momentum(system, run.samples)[0], ADDS_UP * ROUND_OFF * size
        )


def _closure(system: System, done: Motion, limits: list[RoundOff]) -> Iterator[Finding]:
    samples, n = done.samples, system.bodies
    pose = pose_of(samples.q[-1])
    twist = twist_of(pose, samples.v[-1])
    grain = position_grain(system, pose)[n:].max(initial=0.0)
    yield off("closure", done.tally.joint_peak.value, max(CLOSED, ATTAINABLE * grain))
    # A structure is at rest but for what round-off of the accelerations makes of its velocities in a step.
    pushed = np.abs(jacobian(system, pose)) @ limits[-1].acceleration * float(done.samples.t[-1])
    # Its start is what assembly leaves of given velocities of about 1 m/s.
    grain = (velocity_grain(system, pose, twist) + pushed).max(initial=0.0)
    yield off("closure of velocities", done.tally.velocity_peak.value, ATTAINABLE * max(grain, ROUND_OFF))
    for at, limit in zip((0, -1), limits, strict=True):
        a, rows = samples.acceleration[at], np.abs(jacobian(system, pose_of(samples.q[at])))
        allowed = (rows @ (limit.acceleration + ROUND_OFF * np.abs(a))).max()
        yield off("closure of accelerations", done.block["diagnostics/acceleration_violation"][at], allowed)


def _weighed(system: System, done: Motion) -> float:
    """Σ m |g·r|, which cancels in the potential energy of gravity."""
    r = done.samples.q.reshape(len(done.samples.q), -1, 7)[..., :3]
    return float((system.mass * np.abs(r @ system.gravity)).sum(axis=-1).max())


def _kept(what: str, done: Motion, of: Callable[[Motion], Numbers], grain: float) -> Finding:
    """Something constant: off by no more than the error of the steps, which halving them shows, and by round-off."""
    assert done.finer is not None
    coarse, fine = (values - values[0] for values in (of(done), of(done.finer)))
    return off(what, np.abs(coarse).max(), MARGIN * np.abs(coarse - fine).max() + grain)
