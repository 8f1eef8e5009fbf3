"""Models with changed numbers beside one that ran: their numbers, their initial states, and samples at given states."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.assembly.assemble import turns_of
from mbproj.dynamics.observe.samples import GivenMotion, Samples
from mbproj.errors import InputError, SimulationError
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.integrate.formulations.planar import InPlane
from mbproj.integrate.formulations.reduced import Reduced
from mbproj.integrate.tangents import numbers_of, structure_of
from mbproj.model.planar import Plane, planar_reduction
from mbproj.model.system import System
from mbproj.studies.measure.mechanism import Mechanism

#: Parts of the paths of datasets that need accelerations, and of those that need multipliers.
ACCELERATIONS, MULTIPLIERS = ("acceleration", "forces/"), ("reaction", "motions/force", "ropes/")


def chosen_of(samples: Samples, rows: Integers) -> Samples:
    """Return the samples with these numbers."""
    names = ("t", "carried", "step_size", "work")
    counters = {name: values[rows] for name, values in samples.counters.items()}
    chosen = {name: getattr(samples, name)[rows] for name in names}
    return replace(samples, **chosen, motion=samples.motion.chosen(rows), counters=counters)


class Model:
    """A system in the kernel, with its numbers and its initial state."""

    def __init__(self, compiled: Compiled, mechanism: Mechanism) -> None:
        self.compiled, self.mechanism = compiled, mechanism
        self.numbers, self.structure = numbers_of(compiled), structure_of(compiled)
        self.start = compiled.beginning(mechanism.state)

    def states(self, samples: Samples) -> Array:
        """Return the kernel's states (T, S) at samples."""
        layout = self.compiled.layout
        bodies = self.compiled.state(samples.q, samples.v).reshape(len(samples.t), -1)
        return layout.vector_of({"bodies": bodies} | samples.layout.common_blocks(samples.y, layout))

    def samples(self, beside: Samples, counted: Array, y: Array, paths: Iterable[str]) -> Samples:
        """Return T samples at the kernel's states y (T, S), near other samples with the joint coordinates `counted`."""
        compiled, system = self.compiled, self.compiled.system
        bodies = np.ascontiguousarray(compiled.bodies_of(y))
        acceleration = np.zeros((*bodies.shape[:2], bodies.shape[2] // 2))
        carried = beside.carried
        wanted = (*ACCELERATIONS, *(MULTIPLIERS if isinstance(compiled, Reduced) else ()))
        if any(each in path for path in paths for each in wanted):
            acceleration, carried = self._solved(beside, bodies, counted)
        q, v = compiled.motion(bodies)
        turns = turns_of(system, q, counted)
        states = {"positions": q, "velocities": v, "turns": turns} | compiled.layout.common_blocks(y, system.layout)
        return replace(
            beside,
            motion=GivenMotion(
                system.layout, system.layout.vector_of(states), compiled.acceleration(bodies, acceleration)
            ),
            carried=carried,
            solved=compiled.multipliers,
        )

    def _solved(self, beside: Samples, bodies: Array, counted: Array) -> tuple[Array, Array]:
        """Return accelerations and multipliers at samples. Raises SimulationError where they are not unique."""
        equations, solutions = self.compiled.equations(), []
        for t, body, along, x in zip(beside.t, bodies, counted, beside.y[:, beside.layout["states"]], strict=True):
            solution = equations.accelerations(body, float(t), [*self.compiled.turns(along).tolist(), *x.tolist()])
            if solution is None:
                raise SimulationError(float(t), "the equations have no unique solution")
            solutions.append(solution)
        accelerations, multipliers = zip(*solutions, strict=True)
        return np.array(accelerations), np.array(multipliers)[:, : beside.carried.shape[1]]


def compiled_like(like: Compiled, system: System, q: Array) -> Compiled:
    """Return a system in the kernel's coordinates of the system `like`."""
    if isinstance(like, Reduced):
        model = Reduced(like.core, system)
        model.model.rows = like.model.rows
        return model
    plane = planar_reduction(system, q)
    if not isinstance(plane, Plane):
        raise InputError(f"it moves the mechanism out of the plane: {plane.reason}")
    return InPlane(like.core, system, plane)
