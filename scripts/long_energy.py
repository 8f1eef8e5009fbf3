"""Long runs with the energy balance as a row of the velocity projection, beside symplectic methods.

    python scripts/long_energy.py [SECONDS] [--only NAME ...] [-o FOLDER]     errors after 10,000 s, with a figure
    python scripts/long_energy.py --draw FOLDER                               the figure of what is there
    python scripts/long_energy.py --chaos                                     how long a chaotic motion is followed

Two mechanisms of one degree of freedom, a heavy top that nods, and small swings of two and of five bars in a row
(`scripts/long_motions/cases.py`). The first three are held against exact motions (`exact.py`), the bars against the
Gauss method of order 12 in extended precision, whose own error is that of steps of twice the size. Beside mbproj's
methods stand the Gauss methods of order 4, 6 and 8 on Hamilton's equations in minimal coordinates, which need no
constraints, so that an evaluation costs less, and RATTLE on the same bodies and joints, with dense matrices.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from long_motions.cases import CASES, MS, Case, double_pendulum, five_bar
from long_motions.figure import drawn

import mbproj
from mbproj.base.errors import MbprojError

#: A motion is lost that is so far off, m.
LOST = 1e-3


def by_mbproj(case: Case, integrator: str, h: float, span: float, **rows: bool) -> tuple[np.ndarray, dict[str, Any]]:
    """Where a mechanism is after a span, and the attributes of its results."""
    options = {"integrator": integrator, "step": h, "duration": span, "output_step": span}
    found = mbproj.run(case.scene, **options, **rows)  # type: ignore[arg-type]
    return case.seen(found), dict(found.attributes)


def runs(case: Case, span: float) -> Iterator[dict[str, Any]]:
    """A row a run."""
    exact, certain = case.exact(span)
    for method, steps in case.steps.items():
        for each in steps:
            count, h = round(span / (each * MS)), each * MS
            for row in (False, True) if method in ("rk4", "dop853") else (False,):
                began = process_time()
                extra: dict[str, Any] = {}
                if method == "RATTLE":
                    where, evaluations = case.by_rattle(span, count)
                elif method.startswith("Gauss"):
                    where, evaluations = case.by_gauss(int(method.split()[1]), span, count)
                else:
                    try:
                        where, told = by_mbproj(case, method, h, span, energy_row=row)
                    except MbprojError as error:
                        print(f"{case.name}: {method} at {each} ms: {error}", file=sys.stderr, flush=True)
                        continue
                    evaluations = int(told["evaluations"])
                    extra = {name: told[name] for name in ("energy_row_given", "rows_refused") if name in told}
                yield {
                    "case": case.name,
                    "unit": case.unit,
                    "method": method,
                    "row": row,
                    "step": each,
                    "error": float(np.abs(where - exact).max()),
                    "evaluations": evaluations,
                    "seconds": process_time() - began,
                    "certain": certain,
                    **extra,
                }


def followed(case: Case, integrator: str, h: float, span: float, every: float, **rows: bool) -> float:
    """How long a motion is followed until it is LOST, s."""
    options = {"integrator": integrator, "step": h, "duration": span, "output_step": every}
    path = mbproj.run(case.scene, **options, **rows)["markers/position"][:, 0]  # type: ignore[arg-type]
    for k in range(1, len(path)):
        exact, certain = case.exact(k * every)
        if certain > LOST / 10 or np.abs(path[k] - exact).max() > LOST:
            return k * every if certain <= LOST / 10 else float("nan")
    return span


def chaos() -> None:
    """Prints how long the double pendulum from 120 and the five bars from 90 degrees are followed."""
    print("| mechanism | method, step | without the row, s | with it, s |\n|---|---|---|---|")
    for case in (double_pendulum(120.0), five_bar(90.0)):
        for integrator, h in (("rk4", 0.01), ("dop853", 0.02), ("dop853", 0.01)):
            times = [followed(case, integrator, h, 20.0, 0.5, energy_row=row) for row in (False, True)]
            print(f"| {case.name} | {integrator}, {1e3 * h:g} ms | {times[0]:.1f} | {times[1]:.1f} |", flush=True)


def main() -> None:
    """As the arguments say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seconds", nargs="?", type=float, default=10_000.0)
    parser.add_argument("--only", nargs="+", default=[case.__name__ for case in CASES], metavar="NAME")
    parser.add_argument("-o", "--output", type=Path, default=Path())
    parser.add_argument("--draw", type=Path)
    parser.add_argument("--chaos", action="store_true")
    options = parser.parse_args()
    if options.chaos:
        return chaos()
    folder = options.draw or options.output
    path, found = folder / "long_energy.json", []
    if options.draw is None:
        print("| mechanism | method | step, ms | error | evaluations | processor time, s |\n|---|---|---|---|---|---|")
        for make in CASES:
            for row in runs(make(), options.seconds) if make.__name__ in options.only else ():
                found.append(row)
                name = f"{row['method']}{', energy row' * row['row']}"
                print(
                    f"| {row['case']} | {name} | {row['step']:g} | {row['error']:.1e} {row['unit']} | "
                    f"{row['evaluations']:.2e} | {row['seconds']:.1f} |",
                    flush=True,
                )
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(found, indent=1), encoding="utf-8")
    drawn(json.loads(path.read_text(encoding="utf-8")), folder / "long_energy.png")
    return None


if __name__ == "__main__":
    main()
