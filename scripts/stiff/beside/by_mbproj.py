"""mbproj itself: both implicit integrators, `auto` and DOP853, with error control."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from mbproj.base.errors import SimulationError
from mbproj.base.settings import Settings
from mbproj.equations.recorded import Block
from mbproj.motion.simulate import simulate
from mbproj.studies.measure.solve import Mechanism
from stiff.beside.four_bar import FourBar
from stiff.beside.governor import LINK, START
from stiff.beside.program import END, SAMPLES, Array, NotDone, Problem, Program, Setting, tolerances
from stiff.cases import four_bar, governor

INTEGRATORS = ("radau5", "esdirk4", "auto", "dop853")
#: What is recorded, by path.
Recorded = dict[str, Array]
NEEDED = ("joints/coordinate", "bodies/position", "bodies/acceleration", "bodies/angular_acceleration")


class _Recorder:
    """Keeps what is needed."""

    def __init__(self) -> None:
        self.blocks: list[Recorded] = []

    def write(self, block: Block) -> None:
        """Takes a block of samples."""
        self.blocks.append({path: block[path].copy() for path in NEEDED})

    @property
    def whole(self) -> Recorded:
        """All samples."""
        return {path: np.concatenate([block[path] for block in self.blocks]) for path in NEEDED}


def _four_bar(problem: Problem, found: Recorded) -> Array:
    a, b, c, d = found["joints/coordinate"].T  # from the start on: each against the one before it
    one, two, _, four = problem.start[:4]
    return problem.points(np.stack([one + a, two + a + b, four + d - c, four + d], axis=-1))


def _governor(_: Problem, found: Recorded) -> Array:
    ball, collar = found["bodies/position"][:, 1], found["bodies/position"][:, 3]
    return np.stack([ball[:, 0], ball[:, 1], 0.0 * collar[:, 2], collar[:, 2]], axis=-1)


def _run(
    problem: Problem, mechanism: Mechanism, read: Callable[[Problem, Recorded], Array], name: str, tolerance: float
) -> tuple[float, Array]:
    kept = _Recorder()
    settings = Settings(duration=END, output_step=END / SAMPLES, integrator=name, tolerance=tolerance)
    try:
        report = simulate(mechanism.system, mechanism.state, settings, kept)
    except SimulationError as error:
        raise NotDone(str(error)) from error
    return report.integration_cpu_seconds, read(problem, kept.whole)[1:]


def _settings(run: Callable[[str, float], tuple[float, Array]], name: str) -> Iterator[Setting]:
    for tolerance in tolerances(9):
        yield Setting(f"tolerance {tolerance:.0e}", partial(run, name, tolerance))


def _accelerations(problem: Problem, mechanism: Mechanism) -> Array:
    kept = _Recorder()
    simulate(mechanism.system, mechanism.state, Settings(duration=1e-6, step=1e-6, integrator="rk4"), kept)
    found = {path: values[0] for path, values in kept.whole.items()}
    if isinstance(problem, FourBar):
        return -found["bodies/angular_acceleration"][:, 1]
    lift = found["bodies/acceleration"][3, 2] / (2.0 * LINK * np.sin(START))
    return np.array([found["bodies/angular_acceleration"][0, 2], lift])


def programs(problem: Problem) -> list[Program]:
    """On the scene of `stiff.cases`."""
    scene, read = (four_bar, _four_bar) if isinstance(problem, FourBar) else (governor, _governor)
    mechanism = Mechanism.of(scene(problem.k))
    run = partial(_run, problem, mechanism, read)
    return [
        Program(f"mbproj, {name}", partial(_settings, run, name), partial(_accelerations, problem, mechanism))
        for name in INTEGRATORS
    ]
