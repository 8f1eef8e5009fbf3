"""A valve train beside MuJoCo: the error of the valve's lift and the time it takes, over their steps.

    python scripts/valve_train_beside_mujoco.py [--repeat 3] [--cylinders 1 2 4 8]

The mechanism is that of mechanisms/valve_train.yaml, for several cylinders on one shaft: a cam, the roller of a
rocker, its tip on a valve, and a spring. mbproj holds both contacts as joints, or lets them open. MuJoCo has a mesh
with corners for the cam, spheres for roller and tip, and its soft contacts, stiff by a time constant of two steps.

The error is the largest of the first cylinder's valve at all samples, against mbproj at a tolerance of 1e-11. The times
are processor time for each second of the motion: that of a short run is taken off a long one, so that no start counts.
A last table has several cylinders, held: steps end at the knots of each, so there are more of them, too. Needs the
package mujoco, and leaves it out where it is missing.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from importlib.util import find_spec
from time import process_time

import numpy as np

from mbproj import State, System, assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.equations.recorded import Block
from mbproj.functions.plane_curve import CamFollower, Rise, of_law

#: Time between samples; a long and a short run, s.
OUTPUT, LONG, SHORT = 5e-3, 0.5, 0.1
#: Steps of MuJoCo in s, with the corners of its cam.
STEPS = ((1e-4, 720), (5e-5, 720), (2.5e-5, 1440), (2.5e-5, 2880))
#: Runs for a time: the seconds that it took, the lifts of the first valve at the samples, and how many evaluations.
Timed = Callable[[float], tuple[float, np.ndarray, int]]
LIMIT = ", limits: {gap: {range: [0, null], rigid: true, restitution: 0}}"
HEAD = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: DURATION, output_step: 5 ms, INTEGRATOR}
curves:
  cam: {roller: 10 mm, clockwise: true, lift: {base: 18 mm, rises: [[120 deg, 0 m, dwell],
        [75 deg, 5 mm, cycloidal], [75 deg, 0 m, cycloidal], [90 deg, 0 m, dwell]]}}
  tip: {circle: 6 mm}
"""
SHAFT = "  shaft: {mass: 2, inertia: [0.01, 0.01, 0.01], position: [0, 0, 0]}\n"
AXLE = "  axle: {type: revolute, bodies: [ground, shaft], location: [0, 0, 0], axis: [0, -1, 0], speed: 200 rad/s}\n"


def scene_text(cylinders: int, held: bool) -> str:
    """So many cylinders along the shaft, each cam turned against the one before."""
    blocks = {"bodies": SHAFT, "joints": AXLE, "forces": ""}
    on_cam, on_valve = ("cam", "flat_follower") if held else ("cam_contact", "flat_contact")
    limit = "" if held else LIMIT
    for k in range(cylinders):
        y, turn = 0.05 * k, 2.0 * np.pi * k / cylinders
        x_axis = f"[{float(-np.sin(turn))!r}, 0, {float(np.cos(turn))!r}]"
        blocks["bodies"] += (
            f"  rocker{k}: {{mass: 0.12, inertia: [6.0e-5, 6.0e-5, 6.0e-5], position: [0.04, {y}, 0.028]}}\n"
            f"  valve{k}: {{mass: 0.1, inertia: [1.0e-5, 1.0e-5, 1.0e-5], position: [0.08, {y}, 0.022]}}\n"
        )
        blocks["joints"] += (
            f"  pivot{k}: {{type: revolute, bodies: [ground, rocker{k}], location: [0.04, {y}, 0.028], axis: y}}\n"
            f"  guide{k}: {{type: prismatic, bodies: [ground, valve{k}], location: [0.08, {y}, 0], axis: -z}}\n"
            f"  on_cam{k}: {{type: {on_cam}, bodies: [shaft, rocker{k}], curve: cam, axis: -y, x_axis: {x_axis}, "
            f"locations: [[0, {y}, 0], [0, {y}, 0.028]]{limit}}}\n"
            f"  on_valve{k}: {{type: {on_valve}, bodies: [rocker{k}, valve{k}], curve: tip, axis: -y, x_axis: z, "
            f"locations: [[0.08, {y}, 0.028], [0.08, {y}, 0.022]], normal: [0, 0, -1]{limit}}}\n"
        )
        blocks["forces"] += (
            f"  spring{k}: {{type: linear_spring_damper, joint: guide{k}, stiffness: 20 kN/m, "
            "free_displacement: -7.5 mm}\n"
        )
    return HEAD + "".join(f"{name}:\n{lines}" for name, lines in blocks.items())


class _Lifts:
    """Keeps what the guide of the first valve does: the third coordinate."""

    def __init__(self) -> None:
        self.blocks = list[np.ndarray]()

    def write(self, block: Block) -> None:
        """Takes a block of samples."""
        self.blocks.append(block["joints/coordinate"][:, 2].copy())


def by_mbproj(cylinders: int, held: bool, integrator: str) -> Timed:
    """A run of the kernel."""
    text, ready = scene_text(cylinders, held).replace("INTEGRATOR", integrator), dict[float, tuple[System, State]]()

    def run(duration: float) -> tuple[float, np.ndarray, int]:
        scene = read_scene_text(text.replace("DURATION", repr(duration)))
        if duration not in ready:
            system = compile_system(scene)
            ready[duration] = system, assemble(system, initial_guess(scene, system))
        lifts, settings = _Lifts(), settings_to_run(scene)
        begun = process_time()
        report = simulate(*ready[duration], settings, lifts)
        return process_time() - begun, np.concatenate(lifts.blocks), report.counters["evaluations"]

    return run


def by_mujoco(step: float, corners: int) -> Timed:
    """A run of MuJoCo, with contacts of one direction and without friction."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(_mjcf(step, corners))
    every = round(OUTPUT / step)

    def run(duration: float) -> tuple[float, np.ndarray, int]:
        data, lifts = mujoco.MjData(model), []
        data.qvel[0] = 200.0
        begun = process_time()
        for _ in range(round(duration / OUTPUT)):
            lifts.append(float(data.qpos[2]))
            mujoco.mj_step(model, data, every)
        return process_time() - begun, np.array([*lifts, float(data.qpos[2])]), round(duration / step)

    return run


def _mjcf(step: float, corners: int) -> str:
    rise, dwell = np.radians(75.0), (np.radians(120.0), np.radians(90.0))
    rises = [Rise(dwell[0], 0.0, "dwell"), Rise(rise, 5e-3, "cycloidal"), Rise(rise, 0.0, "cycloidal")]
    line = of_law(18e-3, [*rises, Rise(dwell[1], 0.0, "dwell")], CamFollower("roller", 10e-3), clockwise=True)
    s = np.linspace(line.start, line.end, corners, endpoint=False)
    (x, y), (x1, y1), *_ = line.derivatives(s, line.at(s))
    speed = np.hypot(x1, y1)
    u, w = x - 10e-3 * y1 / speed, y + 10e-3 * x1 / speed
    mesh = " ".join(f"{-b!r} {h} {a!r}" for h in (-0.004, 0.004) for a, b in zip(u.tolist(), w.tolist(), strict=True))
    return f"""
<mujoco>
  <option timestep="{step!r}" integrator="implicitfast" gravity="0 0 -9.81" iterations="50" tolerance="1e-10"/>
  <default><geom solref="{2.0 * step!r} 1" solimp="0.99 0.9999 1e-5" condim="1" mass="0"/></default>
  <asset><mesh name="cam" vertex="{mesh}" inertia="shell"/></asset>
  <worldbody>
    <body>
      <inertial pos="0 0 0" mass="2" diaginertia="0.01 0.01 0.01"/>
      <joint type="hinge" axis="0 -1 0"/>
      <geom type="mesh" mesh="cam" contype="1" conaffinity="0"/>
    </body>
    <body pos="0.04 0 0.028">
      <inertial pos="0 0 0" mass="0.12" diaginertia="6e-5 6e-5 6e-5"/>
      <joint type="hinge" axis="0 1 0"/>
      <geom type="sphere" size="0.01" pos="-0.04 0 0" contype="0" conaffinity="1"/>
      <geom type="sphere" size="0.006" pos="0.04 0 0" contype="2" conaffinity="0"/>
    </body>
    <body pos="0.08 0 0.022">
      <inertial pos="0 0 0" mass="0.1" diaginertia="1e-5 1e-5 1e-5"/>
      <joint type="slide" axis="0 0 -1" stiffness="20000" springref="-0.0075"/>
      <geom type="box" size="0.01 0.01 0.005" pos="0 0 -0.005" contype="0" conaffinity="2"/>
    </body>
  </worldbody>
</mujoco>"""


def cases() -> Iterator[tuple[str, Timed]]:
    """Each program with several steps."""
    for held in (True, False):
        for integrator in ("dopri5, tolerance: 1.0e-5", "dopri5, tolerance: 1.0e-4", "bs32, tolerance: 1.0e-3"):
            how = "held" if held else "contacts"
            yield f"mbproj, {how}, {integrator}", by_mbproj(1, held, f"integrator: {integrator}")
    if find_spec("mujoco") is None:
        print("mujoco is not installed: it is left out")
        return
    for step, corners in STEPS:
        yield f"MuJoCo, {corners} corners, step {step:g} s", by_mujoco(step, corners)


def a_second(run: Timed, repeat: int) -> tuple[float, float]:
    """Processor time and evaluations for a second of motion; the fastest of several runs."""
    long, short = (min(run(duration)[::2] for _ in range(repeat)) for duration in (LONG, SHORT))
    return (long[0] - short[0]) / (LONG - SHORT), (long[1] - short[1]) / (LONG - SHORT)


def main(arguments: Sequence[str] | None = None) -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--cylinders", type=int, nargs="+", default=[1, 2, 4, 8])
    given = parser.parse_args(arguments)
    _, exact, _ = by_mbproj(1, True, "integrator: dop853, tolerance: 1.0e-11")(LONG)
    print(f"{'':44s} error (m)   a second of motion (ms)")
    for name, run in cases():
        error = np.abs(run(LONG)[1] - exact).max()
        print(f"{name:44s} {error:9.1e}   {1e3 * a_second(run, given.repeat)[0]:8.2f}", flush=True)
    print(f"\n{'cylinders, held, dopri5, tolerance: 1.0e-5':44s} a second of motion (ms)  evaluations  µs a cylinder")
    for cylinders in given.cylinders:
        run = by_mbproj(cylinders, True, "integrator: dopri5, tolerance: 1.0e-5")
        time, count = a_second(run, given.repeat)
        each = 1e6 * time / count / cylinders
        print(f"{cylinders:4d} {'':40s} {1e3 * time:8.2f} {count:28.0f} {each:12.2f}", flush=True)


if __name__ == "__main__":
    main()
