"""MMOPM's penalty factor α from 1e0 to 1e14 against GPOPM: what round-off makes of a method that Eq. 78 calls the same.

    python scripts/alpha_roundoff.py [SCENE] [--duration 3] [--step 0.01]

Part 1 runs the scene with each α. Part 2 takes the poses of one run with velocities that violate the constraints by
1e-3, and corrects each once with two ways of evaluating Eq. 61: linear solves (as mbproj does), and inverse matrices
(as the equation is printed). The paper reports a larger velocity error for MMOPM (its Figs. 5 and 10) and puts it down
to the penalty factor.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from mbproj import SimulationError, assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.base.arrays import Array
from mbproj.equations.constraints import jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.equations.of_motion import mass_matrix
from mbproj.equations.recorded import Block
from mbproj.model.system import System
from mbproj.motion.projection import weighted_correction

ALPHAS = [10.0**power for power in range(15)]


class Poses:
    """Keeps the coordinates q of a run."""

    def __init__(self) -> None:
        self.q: list[Array] = []

    def write(self, block: Block) -> None:
        """Takes a block of samples."""
        rows = np.concatenate([block["bodies/position"], block["bodies/orientation"]], axis=-1)
        self.q.extend(rows.reshape(len(rows), -1))


def run(scene: Path, duration: str, step: str, **projection: str) -> tuple[str, Poses]:
    """One line of part 1, and the poses of the run."""
    what = read_scene(scene, {}, {"duration": duration, "step": step, **projection})
    system, poses = compile_system(what), Poses()
    try:
        report = simulate(system, assemble(system, initial_guess(what, system)), settings_to_run(what), poses)
    except SimulationError as error:
        return str(error), poses
    counts = report.counters
    return (
        f"{report.position_violation.value:10.1e} {report.velocity_violation.value:10.1e} "
        f"{counts['projection_iterations'] / counts['projections']:10.2f} {counts['projection_failures']:9d}",
        poses,
    )


def by_inverses(A: Array, C_q: Array, violation: Array) -> Array:
    """Eq. 28 as it is printed."""
    inverse = np.linalg.inv(A)
    return -inverse @ C_q.T @ np.linalg.inv(C_q @ inverse @ C_q.T) @ violation


def corrections(system: System, poses: list[Array], alpha: float) -> list[float]:
    """Largest |C'| left and largest relative distance from GPOPM's correction, by solves and by inverses."""
    rng = np.random.default_rng(1)
    worst = [0.0] * 4
    for q in poses:
        pose = pose_of(q)
        M, C_q = mass_matrix(system, pose), jacobian(system, pose)
        v = 1e-3 * rng.normal(size=len(q))
        reference = weighted_correction(M + C_q.T @ C_q, C_q, C_q @ v)
        A = M + alpha * (C_q.T @ C_q)
        for place, correct in ((0, weighted_correction), (2, by_inverses)):
            change = correct(A, C_q, C_q @ v)
            worst[place] = max(worst[place], float(np.abs(C_q @ (v + change)).max()))
            distance = np.linalg.norm(change - reference) / np.linalg.norm(reference)
            worst[place + 1] = max(worst[place + 1], float(distance))
    return worst


def main() -> None:
    """Prints both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    default = Path(__file__).parents[1] / "mechanisms" / "five_bar.yaml"
    parser.add_argument("scene", nargs="?", type=Path, default=default)
    parser.add_argument("--duration", default="3")
    parser.add_argument("--step", default="0.01")
    chosen = parser.parse_args()
    print(f"{chosen.scene.name}, RK4, step {chosen.step} s, {chosen.duration} s\n")
    print(f"{'alpha':>10} {'|C|':>10} {'|Cdot|':>10} {'iterations':>10} {'failures':>9}")
    line, poses = run(chosen.scene, chosen.duration, chosen.step, projection="gpopm")
    print(f"{'GPOPM':>10} {line}")
    for alpha in ALPHAS:
        line, _ = run(chosen.scene, chosen.duration, chosen.step, projection="mmopm", alpha=repr(alpha))
        print(f"{alpha:10.0e} {line}")
    what = read_scene(chosen.scene)
    system = compile_system(what)
    print("\none velocity correction of 1e-3 m/s    by solves                by inverses")
    print(f"{'alpha':>10} {'|Cdot| left':>24} {'from GPOPM':>12} {'|Cdot| left':>12} {'from GPOPM':>12}")
    for alpha in ALPHAS:
        left, distance, left_inverse, distance_inverse = corrections(system, poses.q[::10], alpha)
        print(f"{alpha:10.0e} {left:24.1e} {distance:12.1e} {left_inverse:12.1e} {distance_inverse:12.1e}")


if __name__ == "__main__":
    main()
