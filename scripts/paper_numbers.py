"""The paper's two mechanisms with every method: violations, error against the references, energy drift, time.

    python scripts/paper_numbers.py [--quick]

RK4 at the paper's step of 0.01 s over 10 s, then how the tip's error falls with the step and the integrator. The
references are those of tests/data. Takes about two minutes; --quick leaves out the steps of 0.001 s.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from mbproj import Report, assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.arrays import Array
from mbproj.dynamics.observe import Block
from mbproj.registry import PROJECTIONS

ROOT = Path(__file__).parents[1]
CASES = {
    "five_bar": ("five_bar", "tip_x", (3.0, 5.0, 8.0)),
    "spatial_slider_crank": ("slider_crank_comA", "slider_x", (1.0, 5.0, 10.0)),
}


class MarkerPath:
    """Keeps the path of the first marker."""

    def __init__(self) -> None:
        self.times: list[Array] = []
        self.points: list[Array] = []

    def write(self, block: Block) -> None:
        """Takes a block of samples."""
        self.times.append(block["time"])
        self.points.append(block["markers/position"][:, 0])


def run(scene: str, **simulation: str) -> tuple[Report, dict[float, float]]:
    """The report of a run, and the error of its first marker at the times of the reference, m."""
    name, column, _ = CASES[scene]
    what = read_scene(ROOT / "mechanisms" / f"{scene}.yaml", {}, simulation)
    system, path = compile_system(what), MarkerPath()
    report = simulate(system, assemble(system, initial_guess(what, system)), settings_to_run(what), path)
    exact = np.genfromtxt(ROOT / "tests" / "data" / f"{name}.csv", delimiter=",", names=True)
    times = np.round(np.concatenate(path.times), 9)
    points = np.concatenate(path.points)
    errors = {}
    for row in exact:
        at = points[np.searchsorted(times, row["t"])]
        height = row["tip_z"] if column == "tip_x" else 0.0
        errors[float(row["t"])] = float(np.hypot(at[0] - row[column], at[2] - height))
    return report, errors


def line(label: str, scene: str, report: Report, errors: dict[float, float]) -> str:
    """One row of a table."""
    at = " ".join(f"{errors[time]:9.1e}" for time in CASES[scene][2])
    return (
        f"{label:28} {report.position_violation.value:9.1e} {report.velocity_violation.value:9.1e} {at} "
        f"{report.energy_drift:9.1e} {report.integration_seconds:7.2f}"
    )


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    finer = [
        {"integrator": "dopri5", "tolerance": "1e-8", "output_step": "0.01"},
        {"integrator": "dop853", "tolerance": "1e-10", "output_step": "0.01"},
        {"integrator": "dop853", "tolerance": "1e-12", "output_step": "0.01"},
    ]
    if not quick:
        finer.insert(0, {"step": "0.001", "output_step": "0.01"})
    for scene, (_, _, times) in CASES.items():
        at = " ".join(f"err {time:3g} s" for time in times)
        print(f"\n{scene}, 10 s\n{'method':28} {'|C|':>9} {'|Cdot|':>9} {at} {'drift J':>9} {'time s':>7}")
        for method, entry in PROJECTIONS.items():
            if method == "popm":
                continue
            tests = ("violation", "paper") if entry.corrects else ("violation",)
            for test in tests:
                chosen = {"projection": method} | ({"projection_test": test} if entry.corrects else {})
                print(line(f"{method}, {test}" if entry.corrects else method, scene, *run(scene, **chosen)), flush=True)
        for settings in finer:
            label = ", ".join(settings[key] for key in ("integrator", "step", "tolerance") if key in settings)
            print(line(f"gpopm, {label}", scene, *run(scene, **settings)), flush=True)


if __name__ == "__main__":
    main()
