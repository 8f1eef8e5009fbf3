"""Stiff mechanisms: error against work of implicit and explicit integrators, over dials of stiffness.

    python scripts/stiff_work_precision.py [--case NAME ...] [--tolerances 1e-4 1e-6] [--dials 1e6 1e8] [--until 0.2]
    python scripts/stiff_work_precision.py --below 1e-5 [--case NAME ...] [--dials 1e8 1e10] [--longest 5]
    python scripts/stiff_work_precision.py --links 10 100 1000 [--dials 1e6]

The cases (`scripts/stiff/cases.py`): four-bars in the plane and in space whose coupler or rod a bushing holds together,
the first of them also without damping ("ringing"), the flyball governor with a stiff spring and damper, chains whose
links stiff torsion springs hold in line, a slider-crank whose rod is in ten pieces with bushings between them, and a
mass that sticks and slips on a belt by a regularised law of friction. The error is the largest of all coordinates at
ten times. The reference is radau5 at 1e-10;
how far esdirk4 is from it there says how certain it is. With --below: the least time in which each integrator stays
below an error, best of five in turn, and how many times as fast as DOP853 that is. With --links: what a step of chains
costs, by their length.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))

from extremes.time_limit import at_most
from stiff.cases import CASES, chain
from stiff.measure import Outcome, cheapest, fastest, run

from mbproj.base.errors import SimulationError
from mbproj.scene.scene import Scene

EXPLICIT = "dop853"
INTEGRATORS = ("esdirk4", "radau5", EXPLICIT)
REFERENCE = 1e-10
#: A reference may take so many times as long as a search.
REFERENCES = 4


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


def least_times(scene: Scene, until: float, error: float, reference: Outcome, longest: float) -> Iterator[str]:
    """The rows of a case: the least time of each integrator below an error. A search of `longest` seconds that has
    found nothing has taken longer than that for a run."""
    found: dict[str, tuple[float, Outcome]] = {}
    said: dict[str, str] = {}
    for name in INTEGRATORS:
        try:
            with at_most(longest):
                best = cheapest(scene, until, name, reference, error)
        except TimeoutError:
            said[name] = f"takes more than {longest:g} s"
            continue
        if best is None:
            said[name] = f"does not get below {error:.0e}"
        else:
            found[name] = best
    seconds = dict(zip(found, fastest(scene, until, [(name, found[name][0]) for name in found]), strict=True))
    for name in INTEGRATORS:
        if name in said:
            yield f"  {name:8} {said[name]}"
            continue
        tolerance, one = found[name]
        yield (
            f"  {name:8} {tolerance:7.0e}  error {one.off(reference):8.1e}  steps {one.steps:7,}  "
            f"factors {one.factorisations:9,}  closed {one.closure:.0e}  {1e3 * seconds[name]:9.2f} ms"
            f"{_gain(name, seconds, longest, EXPLICIT in said)}"
        )


def _gain(name: str, seconds: dict[str, float], longest: float, too_long: bool) -> str:
    if name == EXPLICIT or not (too_long or EXPLICIT in seconds):
        return ""
    explicit = seconds.get(EXPLICIT, longest)
    return f"  {'> ' * too_long}{explicit / seconds[name]:.3g} times as fast as {EXPLICIT}"


def lengths(k: float, links: list[int]) -> Iterator[str]:
    """What a step of chains costs a link."""
    for count in links:
        scene = chain(k, count)
        for name in ("esdirk4", "radau5"):
            found = run(scene, 0.05, name, 1e-4)
            seconds = min(fastest(scene, 0.05, [(name, 1e-4)], 3))
            yield (
                f"  {count:5} links  {name:8} steps {found.steps:4} ({found.rejected} rejected)  "
                f"evaluations {found.evaluations:5}  {1e6 * seconds / found.evaluations / count:6.3f} us an evaluation "
                f"and link  {1e6 * seconds / (found.steps + found.rejected) / count:6.2f} us a step and link  "
                f"closed {found.closure:.0e}"
            )


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--tolerances", nargs="+", type=float, default=[1e-4, 1e-6])
    parser.add_argument("--dials", nargs="+", type=float, default=[1e4, 1e6, 1e8, 1e10])
    parser.add_argument("--until", type=float, default=0.2)
    parser.add_argument("--below", type=float)
    parser.add_argument("--reference", type=float, default=REFERENCE, help="the tolerance of the reference")
    parser.add_argument("--longest", type=float, default=5.0, help="s, after which a search for --below is given up")
    parser.add_argument("--links", nargs="+", type=int)
    options = parser.parse_args()
    if options.links:
        for k in options.dials:
            print(f"chains, {k:.0e} N m/rad")
            for line in lengths(k, options.links):
                print(line, flush=True)
        return
    for case in options.case:
        for k in options.dials:
            scene = CASES[case](k)
            try:
                with at_most(REFERENCES * options.longest):
                    reference, certain = reference_of(scene, options.until, options.reference)
            except TimeoutError:
                print(f"{case}, {k:.0e}: no reference in {REFERENCES * options.longest:g} s", flush=True)
                continue
            print(f"{case}, {k:.0e}: the reference is certain to {certain:.1e}, {reference.steps:,} steps")
            if options.below is None:
                rows = table(scene, options.until, options.tolerances, reference)
            else:
                rows = least_times(scene, options.until, options.below, reference, options.longest)
            for line in rows:
                print(line, flush=True)


if __name__ == "__main__":
    main()
