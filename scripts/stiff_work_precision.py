"""Stiff mechanisms: error against work of implicit and explicit integrators, over dials of stiffness.

    python scripts/stiff_work_precision.py [--case NAME ...] [--tolerances 1e-4 1e-6] [--dials 1e6 1e8] [--until 0.2]
    python scripts/stiff_work_precision.py --below 1e-5 [--case NAME ...] [--dials 1e8 1e10]

The cases (`scripts/stiff/cases.py`): four-bars in the plane and in space whose coupler or rod a bushing holds together,
the flyball governor with a stiff spring and damper, chains whose links stiff torsion springs hold in line, a
slider-crank whose rod is in ten pieces with bushings between them, and a mass that sticks and slips on a belt by a
regularised law of friction. The error is the largest of all coordinates at ten times. The reference is radau5 at 1e-10;
how far esdirk4 is from it there says how certain it is. With --below: the least time in which each integrator stays
below an error, and DOP853's beside it.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))

from stiff.cases import CASES
from stiff.measure import Outcome, cheapest, run

from mbproj.errors import SimulationError
from mbproj.scene.records import Scene

INTEGRATORS = ("esdirk4", "radau5", "dop853")
REFERENCE = 1e-10


def reference_of(scene: Scene, until: float, tight: float) -> tuple[Outcome, float]:
    """The reference, and how certain it is."""
    reference, check = (run(scene, until, name, tight) for name in ("radau5", "esdirk4"))
    return reference, reference.off(check)


def table(scene: Scene, until: float, tolerances: list[float], reference: Outcome) -> Iterator[str]:
    """The rows of a case: each integrator at each tolerance."""
    for name in INTEGRATORS:
        for tolerance in tolerances:
            try:
                found = run(scene, until, name, tolerance)
            except SimulationError as stopped:
                yield f"  {name:8} {tolerance:7.0e}  {stopped}"
                continue
            yield (
                f"  {name:8} {tolerance:7.0e}  error {found.off(reference):8.1e}  steps {found.steps:7,} "
                f"rejected {found.rejected:5,}  evaluations {found.evaluations:9,}  factors {found.factorisations:9,}  "
                f"closed {found.closure:.0e}  {1e3 * found.seconds:9.2f} ms"
            )


def least_times(scene: Scene, until: float, error: float, reference: Outcome) -> Iterator[str]:
    """The rows of a case: the least time of each integrator below an error."""
    explicit = cheapest(scene, until, "dop853", reference, error)
    for name in INTEGRATORS:
        found = explicit if name == "dop853" else cheapest(scene, until, name, reference, error)
        if found is None:
            yield f"  {name:8} does not get below {error:.0e}"
            continue
        gain = f"{explicit.seconds / found.seconds:7.1f} times as fast as dop853" if explicit else ""
        yield f"  {name:8} steps {found.steps:7,}  {1e3 * found.seconds:9.2f} ms  {gain}"


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--tolerances", nargs="+", type=float, default=[1e-4, 1e-6])
    parser.add_argument("--dials", nargs="+", type=float, default=[1e4, 1e6, 1e8, 1e10])
    parser.add_argument("--until", type=float, default=0.2)
    parser.add_argument("--below", type=float)
    parser.add_argument("--reference", type=float, default=REFERENCE, help="the tolerance of the reference")
    options = parser.parse_args()
    for case in options.case:
        for k in options.dials:
            scene = CASES[case](k)
            reference, certain = reference_of(scene, options.until, options.reference)
            print(f"{case}, {k:.0e}: the reference is certain to {certain:.1e}, {reference.steps:,} steps")
            if options.below is None:
                rows = table(scene, options.until, options.tolerances, reference)
            else:
                rows = least_times(scene, options.until, options.below, reference)
            for line in rows:
                print(line, flush=True)


if __name__ == "__main__":
    main()
