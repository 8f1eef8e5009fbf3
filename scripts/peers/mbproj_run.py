"""mbproj itself, through its Python API: RK4 with fixed steps, DOPRI5 and DOP853 to a tolerance, closed by GPOPM."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from mbproj import (
    Report,
    SimulationError,
    State,
    System,
    assemble,
    compile_system,
    initial_guess,
    read_scene,
    read_scene_text,
    settings_to_run,
    simulate,
)
from mbproj.equations.recorded import Block
from mbproj.motion.simulate import Recorder
from mbproj.scene.scene import Scene
from peers.peer import (
    NotConverged,
    Observation,
    Peer,
    Setting,
    ode_label,
    steps_per_interval,
    tolerance_label,
    tolerances,
)
from peers.problem import ACROSS, ALONG, FIVE_BAR, GRAVITY, LENGTH, MASS, Array, Chain, Mechanism

#: Links beyond which the dense formulation takes minutes a second.
FULL_LINKS = 20


class _Markers:
    """Keeps the first marker's places."""

    def __init__(self) -> None:
        self.times: list[Array] = []
        self.points: list[Array] = []

    def write(self, block: Block) -> None:
        """Takes a block of samples."""
        self.times.append(block["time"])
        self.points.append(block["markers/position"][:, 0])


def _run(system: System, state: State, scene: Scene, recorder: Recorder | None = None) -> Report:
    try:
        return simulate(system, state, settings_to_run(scene), recorder)
    except SimulationError as error:
        raise NotConverged(str(error)) from error


def _setting(label: str, read: partial[Scene], duration: float, interval: float, columns: list[int]) -> Setting:
    """A run with one output at its end for the time, and one with outputs for the error."""
    timed, observed = read(simulation_output=duration), read(simulation_output=interval)
    system = compile_system(timed)
    state = assemble(system, initial_guess(timed, system))

    def observe() -> Observation:
        markers = _Markers()
        report = _run(system, state, observed, markers)
        return Observation(np.concatenate(markers.points)[1:, columns], report.position_violation.value)

    return Setting(label, lambda: _run(system, state, timed).integration_seconds, observe)


def _scene(mechanism: Mechanism, simulation: dict[str, object], simulation_output: float) -> Scene:
    whole = {"duration": mechanism.duration, "projection": "gpopm", "output_step": simulation_output}
    return read_scene(mechanism.scene, {}, simulation | whole)


def _fixed(formulation: str, mechanism: Mechanism) -> Iterator[Setting]:
    for per_interval in steps_per_interval(5, 5000):
        step = mechanism.interval / per_interval
        yield _of(mechanism, ode_label(step), {"formulation": formulation, "integrator": "rk4", "step": step})


def _controlled(formulation: str, integrator: str, mechanism: Mechanism) -> Iterator[Setting]:
    for tolerance in tolerances(2, 13):
        simulation = {"formulation": formulation, "integrator": integrator, "tolerance": tolerance}
        yield _of(mechanism, tolerance_label(tolerance), simulation)


def _of(mechanism: Mechanism, label: str, simulation: dict[str, object]) -> Setting:
    columns = [0, 2] if mechanism is FIVE_BAR else [0]
    return _setting(label, partial(_scene, mechanism, simulation), mechanism.duration, mechanism.interval, columns)


def chain_text(links: int) -> str:
    """The scene of a chain in the x-z plane, level along x."""
    inertia = f"mass: {MASS}, inertia: [{ALONG!r}, {ACROSS!r}, {ACROSS!r}]"
    bodies = "\n".join(f"  b{k}: {{{inertia}, position: [{(k + 0.5) * LENGTH}, 0, 0]}}" for k in range(links))
    joints = "\n".join(
        f"  j{k}: {{type: revolute, bodies: [{f'b{k - 1}' if k else 'ground'}, b{k}],"
        f" location: [{k * LENGTH}, 0, 0], axis: [0, 1, 0]}}"
        for k in range(links)
    )
    marker = f"  tip: {{body: b{links - 1}, location: [{links * LENGTH}, 0, 0]}}"
    return f"mbproj: 1\ngravity: [0, 0, {-GRAVITY}]\nbodies:\n{bodies}\njoints:\n{joints}\nmarkers:\n{marker}\n"


def _chain_scene(chain: Chain, formulation: str, simulation_output: float) -> Scene:
    simulation = {
        "duration": chain.steps * chain.step,
        "step": chain.step,
        "integrator": "rk4",
        "projection": "gpopm",
        "formulation": formulation,
        "output_step": simulation_output,
    }
    return read_scene_text(chain_text(chain.links), simulation=simulation)


def _chain(formulation: str, chain: Chain) -> Setting | None:
    if formulation == "full" and chain.links > FULL_LINKS:
        return None
    whole = chain.steps * chain.step
    return _setting(ode_label(chain.step), partial(_chain_scene, chain, formulation), whole, whole, [0, 2])


def peers(formulation: str) -> tuple[Peer, ...]:
    """mbproj with a formulation, by integrator."""
    return (
        Peer(f"mbproj, {formulation}, RK4", partial(_fixed, formulation), partial(_chain, formulation)),
        Peer(f"mbproj, {formulation}, DOPRI5", partial(_controlled, formulation, "dopri5")),
        Peer(f"mbproj, {formulation}, DOP853", partial(_controlled, formulation, "dop853")),
    )


PEERS = peers("auto")
