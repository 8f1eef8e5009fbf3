"""Prints the tables of the guide's page on the paper's examples: every method at the paper's step, against references.

    python scripts/paper_table.py

The paper's settings are RK4 at 0.01 s over 10 s in the full formulation. It takes some minutes.
`tests/projection/test_paper_table.py` holds the page to it.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

import mbproj
from mbproj.base.errors import MbprojWarning
from mbproj.base.mechanisms_folder import mechanism

DATA = Path(__file__).parents[1] / "tests" / "data"


class Example(NamedTuple):
    """A mechanism of the paper: its reference and the columns of it, and the times at which errors are shown."""

    name: str
    scene: str
    reference: str
    axes: tuple[int, ...]
    times: tuple[int, ...]


EXAMPLES = (
    Example("five-bar", "five_bar", "five_bar", (0, 2), (3, 5, 8)),
    Example("slider-crank", "spatial_slider_crank", "slider_crank_comA", (0,), (1, 5, 10)),
)
PAPER = {"integrator": "rk4", "step": 0.01}
METHODS = ("gopm", "mass-orthogonal", "mmopm", "gpopm", "gpopm-pinv")


def rows() -> dict[str, Mapping[str, object]]:
    """The settings of each row, by its name."""
    found: dict[str, Mapping[str, object]] = {name: {**PAPER, "projection": name} for name in ("none", "baumgarte")}
    for method in METHODS:
        found[f"{method}, violation"] = {**PAPER, "projection": method}
        found[f"{method}, paper"] = {**PAPER, "projection": method, "projection_test": "paper"}
    found["gpopm, 0.001"] = {"integrator": "rk4", "step": 0.001}
    for integrator, tolerance in (("dopri5", "1e-8"), ("dop853", "1e-10"), ("dop853", "1e-12")):
        found[f"gpopm, {integrator}, {tolerance}"] = {"integrator": integrator, "tolerance": tolerance}
    return found


def cells(example: Example, settings: Mapping[str, object]) -> list[str]:
    """|C|, |C'|, the errors at the times, and the energy drift; or where the run has failed."""
    exact = np.genfromtxt(DATA / f"{example.reference}.csv", delimiter=",", skip_header=1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MbprojWarning)
        try:
            results = mbproj.run(
                mechanism(example.scene),
                duration=10,
                output_step=0.01,
                formulation="full",
                **settings,  # type: ignore[arg-type]
            )
        except mbproj.SimulationError as error:
            return ["diverges", f"at {error.time:.2f} s", *[""] * (len(example.times) + 1)]
    position = results["markers/position"][::50, 0, example.axes]
    off = np.linalg.norm(position - exact[:, 1 : 1 + len(example.axes)], axis=1)
    has = results.attributes
    numbers = [has["position_violation_max"], has["velocity_violation_max"], *off[2 * np.array(example.times)]]
    return [f"{number:.1e}" for number in [*numbers, has["energy_drift"]]]


def table(example: Example) -> Iterator[str]:
    """Yield the lines of a table."""
    what = "tip" if example.name == "five-bar" else "slider"
    first, *more = example.times
    at = [f"{what} off at {first} s, m", *(f"{time} s" for time in more)]
    headings = [example.name, r"\|C\|", r"\|Ċ\|", *at, "energy drift, J"]
    yield f"| {' | '.join(headings)} |"
    yield "|---" * len(headings) + "|"
    for name, settings in rows().items():
        yield f"| {' | '.join([name, *cells(example, settings)])} |"


def main() -> None:
    for example in EXAMPLES:
        print("\n".join(table(example)), end="\n\n", flush=True)


if __name__ == "__main__":
    main()
