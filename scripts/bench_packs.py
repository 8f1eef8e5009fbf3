"""What packs of cases give: the time of runs by themselves over that of runs side by side, in one process.

    python scripts/bench_packs.py [--cases N] [--repeats N]

Five-bars, slider-cranks, governors with a spring and engines with a motor, which differ in masses and speeds, by RK4
and by DOP853. Times are of the processor, the least of some repeats that take turns.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace
from typing import Any

import numpy as np

from mbproj import assemble, compile_system, initial_guess, read_scene
from mbproj.integrate.formulations.choice import choose
from mbproj.kernel import core
from mbproj.mechanisms_folder import mechanism
from mbproj.scene.records import Scene

#: How long they run, s.
CASES = {"five_bar": 5.0, "spatial_slider_crank": 10.0, "governor": 2.0, "inline_four": 1.0}
METHODS: dict[str, dict[str, Any]] = {
    "rk4": {"integrator": "rk4", "step": 0.01},
    "dop853": {"integrator": "dop853", "tolerance": 1e-8},
}
MOST, FOREVER = 2**31, 1e9


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=40)
    parser.add_argument("--repeats", type=int, default=3)
    given = parser.parse_args()
    if core() is None:
        print("needs the compiled kernel", file=sys.stderr)
        return 2
    print(f"{'':32s} {'alone':>9s} {'together':>9s} {'ratio':>6s} {'packed':>7s}   ms a case")
    for name, duration in CASES.items():
        for method, keys in METHODS.items():
            measure(name, method, {**keys, "duration": duration, "output_step": duration}, given.cases, given.repeats)
    return 0


def measure(name: str, method: str, keys: dict[str, Any], count: int, repeats: int) -> None:
    """Prints a row."""
    scenes = alike(read_scene(mechanism(name)), count)
    least = [np.inf, np.inf]
    packed, kernel = 0, core()
    assert kernel is not None, "packs need the kernel"
    for _ in range(repeats):
        alone, together = ([run_of(scene, keys) for scene in scenes] for _ in range(2))
        begin = time.process_time()
        for run in alone:
            run.advance(MOST, FOREVER)
        middle = time.process_time()
        made = kernel.together(together, FOREVER, lambda: None)
        packed = sum(each is not None for each in made)
        for run, samples in zip(together, made, strict=True):
            if samples is None:
                run.advance(MOST, FOREVER)
        least = [min(least[0], middle - begin), min(least[1], time.process_time() - middle)]
    own, side = (1e3 * each / count for each in least)
    print(f"{name + ', ' + method:32s} {own:9.3f} {side:9.3f} {own / side:6.2f} {packed:3d}/{count:3d}", flush=True)


def alike(scene: Scene, count: int) -> list[Scene]:
    """Scenes that differ in masses and speeds."""
    rng = np.random.default_rng(1)
    led = {motion.joint for motion in scene.motions}
    return [
        replace(
            scene,
            bodies=tuple(replace(body, mass=body.mass * rng.uniform(0.8, 1.25)) for body in scene.bodies),
            joints=tuple(
                replace(joint, speed={name: speed * rng.uniform(0.8, 1.25) for name, speed in joint.speed.items()})
                if joint.name not in led
                else joint
                for joint in scene.joints
            ),
        )
        for _ in range(count)
    ]


def run_of(scene: Scene, keys: dict[str, Any]) -> Any:
    """A run of the kernel that has not begun."""
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    settings = replace(scene.settings, **{"step": None, "tolerance": None, **keys})
    compiled = choose(system, state, settings).compiled
    assert compiled is not None
    return compiled.run(state, settings)


if __name__ == "__main__":
    sys.exit(main())
