"""The fastest modes of a mechanism's forces and states at its start: their causes, the bodies that they move, and the
step that explicit integrators need for them."""

from __future__ import annotations

from collections.abc import Sequence

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.fast_modes import Mode, leading, moved_bodies
from mbproj.integrate.formulations.choice import Choice, choose
from mbproj.integrate.steppers.stability_region import reach
from mbproj.integrate.steppers.tableau import tableau_of
from mbproj.integrate.stiff.modes_at_a_step import Owners, can_be_fast, modes_at
from mbproj.model.system import System
from mbproj.registry import WHERE_SMOOTH, explicit_integrators
from mbproj.scene.records import Settings
from mbproj.thresholds import THRESHOLDS

#: The number of modes that are reported.
TOLD = 3


@dataclass(frozen=True)
class FastMode:
    """An eigenvalue λ in 1/s, the forces or states with most of its energy, and the bodies that move most; the largest
    part comes first."""

    eigenvalue: complex
    forces: tuple[str, ...]
    states: tuple[str, ...]
    bodies: tuple[str, ...]

    @property
    def time_constant(self) -> float:
        """1 / |λ| in s."""
        return 1.0 / abs(self.eigenvalue)

    @property
    def direction(self) -> complex:
        """λ / |λ|, without slight growth."""
        size = abs(self.eigenvalue)
        return complex(round(min(self.eigenvalue.real, 0.0) / size, 3), round(abs(self.eigenvalue.imag) / size, 3))


def fastest_at(choice: Choice, system: System, state: State) -> list[FastMode]:
    """Return the fastest modes at a state, the fastest first; none without forces along coordinates or states."""
    chosen, modes = modes_at(choice, system, state)
    fastest = modes[:TOLD]
    real = [mode for mode in fastest if abs(mode.eigenvalue) > THRESHOLDS.no_motion * abs(fastest[0].eigenvalue)]
    return [_described(system, state, chosen, mode) for mode in real]


def stable_steps(modes: Sequence[FastMode]) -> dict[str, float]:
    """Return the largest step in s, by name, with which each explicit integrator is stable for all these modes."""
    if not modes:
        return {}
    return {
        name: min(reach(tableau_of(name), mode.direction) * mode.time_constant for mode in modes)
        for name in explicit_integrators()
    }


def steps_for_stability(system: System, state: State, settings: Settings) -> float:
    """Return the least number of steps that DOP853 makes for stability alone in a run with these settings. It assumes
    the forces at the start; 0 without forces along coordinates and states."""
    if not can_be_fast(system):
        return 0.0
    stable = stable_steps(fastest_at(choose(system, state, settings), system, state))
    return (settings.duration or 0.0) / stable[WHERE_SMOOTH] if stable else 0.0


def _described(system: System, state: State, chosen: Integers, mode: Mode) -> FastMode:
    motion: Array | None = None
    if system.bodies <= THRESHOLDS.large and mode.moves_bodies:
        motion = moved_bodies(system, pose_of(state.q), chosen, mode)
    bodies = () if motion is None else leading(system.names.carriers, motion)
    owners = Owners.of(system, mode)
    return FastMode(mode.eigenvalue, owners.forces, owners.states, bodies)
