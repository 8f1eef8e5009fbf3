"""What is measured: a mechanism of one size in one formulation, ready to run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from peers.problem import MECHANISMS

from kernel_bench import scenes
from kernel_bench.frequency import highest_frequency
from mbproj import State, System, assemble, compile_system, initial_guess, read_scene
from mbproj.base.settings import Settings
from mbproj.kernel import core
from mbproj.model.planar.reduction import NotPlanar, planar_reduction
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.formulations.reduced import InPlane, Reduced
from mbproj.motion.formulations.redundant_rows import settle_rows
from mbproj.scene.scene import Scene

#: The step in radians of the highest frequency; steps of a run: as many as keep the work of all runs alike.
STEP_RADIANS, LEAST_STEPS, MOST_STEPS, BODY_STEPS = 0.1, 128, 5000, 100_000


@dataclass(frozen=True)
class Family:
    """Mechanisms of one kind by size; `quick`: the sizes of --quick. `what` a size counts."""

    title: str
    what: str
    scene: Callable[[int, bool], Scene]
    sizes: tuple[int, ...]
    quick: tuple[int, ...]


FAMILIES = {
    "chain": Family("Chains from the ground", "links", scenes.chain, (5, 20, 100, 1000, 10_000), (5, 100)),
    "tree": Family("Binary trees", "bars", scenes.tree, (15, 127, 1023), (15,)),
    "star": Family("Stars: bars on one hub", "spokes", scenes.star, (10, 100, 1000), (10, 100)),
    "ladder": Family("Ladders of four-bars, 3 bodies a loop", "loops", scenes.ladder, (10, 100, 1000), (10,)),
    "wheel": Family("Wheels: four-bars on one shaft", "loops", scenes.wheel, (3, 10, 30), (3,)),
}


@dataclass(frozen=True)
class Case:
    """A mechanism in the kernel: where it starts, its steps, and where they come from a frequency that (rad/s)."""

    compiled: Compiled
    start: State
    settings: Settings
    frequency: float | None = None

    @property
    def bodies(self) -> int:
        """How many move."""
        return self.compiled.system.bodies

    @property
    def steps(self) -> int:
        """Of the run."""
        assert self.settings.duration is not None and self.settings.step is not None
        return round(self.settings.duration / self.settings.step)


def paper_case(name: str, planar: bool) -> Case:
    """One of the paper's mechanisms as its scene says."""
    scene = read_scene(MECHANISMS[name].scene)
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    settings = replace(scene.settings, output_step=scene.settings.duration)
    return Case(_compiled(system, state, planar), state, settings)


def family_case(family: Family, size: int, planar: bool) -> Case:
    """A mechanism of a family, with steps of a tenth of a radian of its highest frequency. It is built closed, so that
    the guess is the start."""
    scene = family.scene(size, planar)
    system = compile_system(scene)
    guess = initial_guess(scene, system)
    state = State.of(system, 0.0, positions=guess.q, velocities=guess.v)
    compiled = _compiled(system, state, planar)
    frequency = highest_frequency(compiled, state)
    step = STEP_RADIANS / frequency
    duration = min(MOST_STEPS, max(LEAST_STEPS, BODY_STEPS // system.bodies)) * step
    return Case(compiled, state, Settings(duration=duration, step=step, output_step=duration), frequency)


def _compiled(system: System, state: State, planar: bool) -> Compiled:
    """With the rows that a run holds."""
    plane = planar_reduction(system, state.q) if planar else None
    if isinstance(plane, NotPlanar):
        raise SystemExit(f"not planar: {plane.reason}")
    compiled = Reduced(core(), system) if plane is None else InPlane(core(), system, plane)
    settle_rows(compiled, state)
    return compiled
