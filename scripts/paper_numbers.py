"""The paper's two mechanisms with every method: violations, error against the references, energy drift, time.

    python scripts/paper_numbers.py [--quick]

RK4 at the paper's step of 0.01 s over 10 s, then how the tip's error falls with the step and the integrator. The
references are those of tests/data. Takes about two minutes; --quick leaves out the steps of 0.001 s.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from mbproj import SimulationError, assemble, compile_system, initial_guess, read_scene, settings_to_run, simulate
from mbproj.base.arrays import Array
from mbproj.base.registry import PROJECTIONS
from mbproj.equations.recorded import Block

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


def row(label: str, scene: str, **simulation: str) -> str:
    """One row of a table: violations, the error of the first marker against the reference, energy drift, time."""
    name, column, times = CASES[scene]
    settings = {"formulation": "full", **simulation}
    what = read_scene(ROOT / "mechanisms" / f"{scene}.yaml", {}, settings)
    system, path = compile_system(what), MarkerPath()
    try:
        report = simulate(system, assemble(system, initial_guess(what, system)), settings_to_run(what), path)
    except SimulationError as error:
        return f"{label:28} {error}"
    exact = np.genfromtxt(ROOT / "tests" / "data" / f"{name}.csv", delimiter=",", names=True)
    recorded = np.round(np.concatenate(path.times), 9)
    points = np.concatenate(path.points)
    errors = []
    for time in times:
        truth = exact[np.searchsorted(exact["t"], time)]
        at = points[np.searchsorted(recorded, time)]
        height = truth["tip_z"] if column == "tip_x" else 0.0
        errors.append(f"{np.hypot(at[0] - truth[column], at[2] - height):9.1e}")
    return (
        f"{label:28} {report.position_violation.value:9.1e} {report.velocity_violation.value:9.1e} "
        f"{' '.join(errors)} {report.energy_drift:9.1e} {report.integration_seconds:7.2f}"
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
                print(row(f"{method}, {test}" if entry.corrects else method, scene, **chosen), flush=True)
        for settings in finer:
            label = ", ".join(settings[key] for key in ("integrator", "step", "tolerance") if key in settings)
            print(row(f"gpopm, {label}", scene, **settings), flush=True)


if __name__ == "__main__":
    main()
