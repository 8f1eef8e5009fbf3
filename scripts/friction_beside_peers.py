"""Dry friction beside MuJoCo and Exudyn: the error at the end, and the time it takes, over their steps.

    python scripts/friction_beside_peers.py [--repeat 5]

Two cases with closed forms: a brake stops a rotor, and an oscillator with dry friction comes to rest beside its
equilibrium. Needs the packages mujoco and exudyn; one that is not installed is left out with a line that says so. Only
integration is timed; medians of interleaved repetitions. mbproj runs the whole of `simulate`, events included.
"""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Callable, Iterator
from time import perf_counter
from typing import NamedTuple

from mbproj import State, System, assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.base.settings import Settings

#: Time after which all is at rest, s.
END = 2.0


class Case(NamedTuple):
    """One coordinate: inertia, stiffness, dry friction, start and speed, whether it turns, and where it rests."""

    name: str
    inertia: float
    stiffness: float
    friction: float
    start: float
    speed: float
    turns: bool
    rest: float


CASES = (
    Case("rotor and brake", 0.5, 0.0, 4.0, 0.0, 10.0, True, 6.25),
    Case("oscillator", 1.0, 100.0, 2.0, 0.09, 0.0, False, 0.01),
)
#: What runs a case once and gives the seconds it took and the coordinate at the end.
Once = Callable[[], tuple[float, float]]


def by_mbproj(case: Case) -> Iterator[tuple[str, Once]]:
    """Error control, and the paper's RK4."""
    unit, force = ("rad", "torque: {} N*m") if case.turns else ("m", "force: {} N")
    name, coordinate = ("revolute", "angle") if case.turns else ("prismatic", "displacement")
    kind = "torsion" if case.turns else "linear"
    spring = f"  spring: {{type: {kind}_spring_damper, joint: j, stiffness: {case.stiffness}}}"
    scene = f"""
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: {END}, output_step: {END}, integrator: %s}}
bodies:
  b: {{mass: {case.inertia}, inertia: [{case.inertia}, {case.inertia}, {case.inertia}], position: [0, 0, 0]}}
joints:
  j: {{type: {name}, bodies: [ground, b], location: [0, 0, 0], axis: [0, 0, 1], {coordinate}: {case.start} {unit}, %s}}
forces:
  dry: {{type: friction, joint: j, coulomb: {{{force.format(case.friction)}}}}}
{spring if case.stiffness else ""}
"""
    for steps in (
        "dopri5, tolerance: 1.0e-6",
        "dop853, tolerance: 1.0e-10",
        "rk4, step: 0.01",
    ):
        read = read_scene_text(scene % (steps, f"speed: {case.speed} {unit}/s"))
        system, settings = compile_system(read), settings_to_run(read)
        start = assemble(system, initial_guess(read, system))

        def once(system: System = system, start: State = start, settings: Settings = settings) -> tuple[float, float]:
            begun, last = perf_counter(), _Last()
            simulate(system, start, settings, last)
            return perf_counter() - begun, last.coordinate

        yield f"mbproj, {steps}", once


class _Last:
    """Keeps the coordinate of the last sample."""

    coordinate = 0.0

    def write(self, block: object) -> None:
        self.coordinate = float(block["joints/coordinate"][-1, 0])  # type: ignore[index]

    def events(self, events: object) -> None:
        """They are not asked for."""


def by_mujoco(case: Case) -> Iterator[tuple[str, Once]]:
    """Friction loss of a joint, as stiff as the step allows."""
    import mujoco
    import numpy as np

    kind = "hinge" if case.turns else "slide"
    for step in (1e-2, 1e-3, 1e-4):
        model = mujoco.MjModel.from_xml_string(
            f"""<mujoco>
            <option gravity="0 0 0" timestep="{step}" integrator="implicitfast" tolerance="0" iterations="100"/>
            <worldbody><body><joint name="j" type="{kind}" axis="0 0 1" stiffness="{case.stiffness}"
            frictionloss="{case.friction}" solreffriction="{2 * step} 1"/>
            <inertial pos="0 0 0" mass="{case.inertia}" diaginertia="{case.inertia} {case.inertia} {case.inertia}"/>
            </body></worldbody></mujoco>"""
        )

        def once(model: mujoco.MjModel = model, step: float = step) -> tuple[float, float]:
            data = mujoco.MjData(model)
            data.qpos[:], data.qvel[:] = np.array([case.start]), np.array([case.speed])
            begun = perf_counter()
            mujoco.mj_step(model, data, nstep=round(END / step))
            return perf_counter() - begun, float(data.qpos[0])

        yield f"MuJoCo, implicitfast, step {step:g}", once


def by_exudyn(case: Case) -> Iterator[tuple[str, Once]]:
    """A coordinate spring-damper with friction over a narrow zone of speeds, generalised-alpha."""
    import exudyn
    from exudyn.itemInterface import (
        CoordinateSpringDamperExt,
        MarkerNodeCoordinate,
        Mass1D,
        Node1D,
        NodePointGround,
    )

    for step in (1e-2, 1e-3, 1e-4):

        def once(step: float = step) -> tuple[float, float]:
            mbs = exudyn.SystemContainer().AddSystem()
            ground = mbs.AddNode(NodePointGround())
            moving = Node1D(initialCoordinates=[case.start], initialVelocities=[case.speed])
            node = mbs.AddNode(moving)
            mbs.AddObject(Mass1D(nodeNumber=node, physicsMass=case.inertia))
            ends = [mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=each, coordinate=0)) for each in (ground, node)]
            friction = {"fDynamicFriction": case.friction, "frictionProportionalZone": 10.0 * step}
            mbs.AddObject(CoordinateSpringDamperExt(markerNumbers=ends, stiffness=case.stiffness, **friction))
            mbs.Assemble()
            settings = exudyn.SimulationSettings()
            settings.timeIntegration.endTime = END
            settings.timeIntegration.numberOfSteps = round(END / step)
            settings.timeIntegration.verboseMode = 0
            settings.solution.file.write = False
            begun = perf_counter()
            mbs.SolveDynamic(settings)
            return perf_counter() - begun, float(mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates))

        yield f"Exudyn, generalised-alpha, step {step:g}", once


def main() -> None:
    """Prints a line for each program and setting."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=5)
    repeat = parser.parse_args().repeat
    for case in CASES:
        print(f"\n{case.name}: rests at {case.rest:g} {'rad' if case.turns else 'm'}")
        runs: dict[str, Once] = {}
        for program in (by_mbproj, by_mujoco, by_exudyn):
            try:
                runs |= dict(program(case))
            except ImportError as error:
                print(f"left out: {program.__name__.removeprefix('by_')} ({error})", file=sys.stderr)
        taken: dict[str, list[float]] = {name: [] for name in runs}
        found: dict[str, float] = {}
        for _ in range(repeat):
            for name, once in runs.items():
                seconds, found[name] = once()
                taken[name].append(seconds)
        for name in runs:
            print(f"  {name:45} {abs(found[name] - case.rest):9.1e}  {1e3 * statistics.median(taken[name]):9.2f} ms")


if __name__ == "__main__":
    main()
