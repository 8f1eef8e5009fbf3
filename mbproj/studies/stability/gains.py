"""The limit of Baumgarte's gains: the gains from which an offset of C grows over 300 steps, and the limit from the
tableau.

With α = β the violation obeys C'' + 2αC' + α²C = 0, whose double eigenvalue is -α. A Runge-Kutta method has the
stability function R(z) = 1 + z bᵀ(I - zA)⁻¹1. It keeps the violation bounded while |R(-αh)| <= 1 (Hairer & Wanner 1996,
sect. IV.2).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.equations.constraint_equations import constraint_at
from mbproj.dynamics.observe.recorded import Block
from mbproj.errors import MbprojError, SimulationError
from mbproj.integrate import simulate
from mbproj.integrate.formulations.choice import choose
from mbproj.integrate.formulations.planar import InPlane
from mbproj.model import System
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.stability.judge import FAILS, HOLDS, StabilityPoint, Subject, cause_of

#: Steps over which |C| is watched, and the initial offset in units of the mechanism's length.
STEPS, OFFSET = 300, 1e-8


def growth(subject: Subject, value: float) -> StabilityPoint:
    """Test whether an offset of C grows with these gains.

    The difference to a run without the offset is watched, because the integrator's error adds to C in both. `closure`
    is this difference after the last step, in lengths or rad."""
    try:
        mechanism = Mechanism.of(subject.scene)
        own, opened = (_violations(subject, each) for each in (mechanism, _shifted(subject, mechanism)))
    except MbprojError as error:
        where, time = (error.where, error.time) if isinstance(error, SimulationError) else (None, 0.0)
        return StabilityPoint(value, FAILS, np.nan, np.nan, time, where, cause_of(error), ended=False)
    first, last = (float(part) for part in np.abs(opened - own).max(axis=1))
    if last <= first:
        return StabilityPoint(value, HOLDS, last, np.nan)
    said = f"an offset has grown from {first:.1e} to {last:.1e}"
    return StabilityPoint(
        value, FAILS, last, np.nan, STEPS * subject.step, _worst(mechanism.system, opened - own), said
    )


def _shifted(subject: Subject, mechanism: Mechanism) -> Mechanism:
    """Return the mechanism with its bodies shifted by random offsets. The offsets stay in the plane where the run is
    planar."""
    state, random = mechanism.state, np.random.default_rng(0)
    shift = np.zeros((mechanism.system.bodies, 7))
    shift[:, :3] = OFFSET * mechanism.system.length * random.choice([-1.0, 1.0], (mechanism.system.bodies, 3))
    run = choose(mechanism.system, state, subject.setting.settings(STEPS * subject.step, subject.step)).compiled
    if isinstance(run, InPlane):
        normal = run.plane.axes[:, 2]
        shift[:, :3] -= np.outer(shift[:, :3] @ normal, normal)
    return replace(mechanism, state=state.changed(positions=state.q + shift.ravel()))


def _violations(subject: Subject, mechanism: Mechanism) -> Array:
    """The violation C of joints and motions at the start and after the last step, (2, m), in the mechanism's length or
    rad."""
    span, kept, system = STEPS * subject.step, list[Block](), mechanism.system

    class Kept:
        def write(self, block: Block) -> None:
            kept.append(block)

    with np.errstate(all="ignore"):
        simulate(system, mechanism.state, mechanism.settings(subject.setting, span, span), Kept())
    times = np.concatenate([block["time"] for block in kept])
    q = np.concatenate([_coordinates(system, block) for block in kept])
    return np.asarray((constraint_at(system, q, times) / system.row_scale)[:, system.bodies :])


def _coordinates(system: System, block: Block) -> Array:
    """The coordinates q (T, 7n) of the carriers, each computed from the first body that is fixed to it."""
    first = [int(np.argmax(system.body_carrier == carrier)) for carrier in range(system.bodies)]
    back = system.body_turn[first] * np.array([1.0, -1.0, -1.0, -1.0])
    orientation = product(block["bodies/orientation"][:, first], back)
    arm = (rotation_matrix(orientation) @ system.body_offset[first][..., None])[..., 0]
    q = np.concatenate([block["bodies/position"][:, first] - arm, orientation], axis=-1)
    return np.asarray(q.reshape(len(q), -1))


def _worst(system: System, offset: Array) -> str:
    """The owner of the row that has grown most."""
    return system.row_owner(system.bodies + int(np.argmax(np.abs(offset[-1]))))
