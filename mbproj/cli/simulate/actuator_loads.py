"""The loads of actuators along a motion, as lines, for JSON, and as a table of all samples."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import degrees
from typing import TYPE_CHECKING, Any

import numpy as np

from mbproj.cli.report.text import columns
from mbproj.cli.simulate.largest_loads import cells
from mbproj.report_schema import report_of
from mbproj.report_schema.loads import ACTUATORS

if TYPE_CHECKING:
    from mbproj.studies.inverse.loads import ActuatorLoads, Smoothing

HEADINGS = ("actuator", "largest", "unit", "at t (s)", "place", "mean", "rms")
#: The most dead centres that are listed.
LISTED = 5


def facts(acting: ActuatorLoads, source: str, over: str | None) -> dict[str, Any]:
    """The loads as a dictionary for JSON."""
    actuators = {
        name: {
            "unit": unit,
            "weight": float(weight),
            "force": acting.force[:, k],
            "rate": acting.rate[:, k],
            "power": acting.power[:, k],
        }
        for k, (name, unit, weight) in enumerate(zip(acting.names, acting.units, acting.weights, strict=True))
    }
    return report_of(ACTUATORS, acting, source=source, place_of=over, largest=acting.largest(over), actuators=actuators)


def lines(actuators: ActuatorLoads, source: str, over: str | None) -> Iterator[str]:
    """Yield a table of the largest forces and powers, then notes on them."""
    count = len(actuators.names)
    yield (
        f"{source}: {actuators.freedom} {'degree' if actuators.freedom == 1 else 'degrees'} of freedom, {count} "
        f"{'actuator' if count == 1 else 'actuators'}, {len(actuators.time)} samples"
    )
    loads = actuators.largest(over)
    turns = over is not None and actuators.cycle(over).unit == "rad"
    yield columns(HEADINGS, [_row(load, over, turns) for load in loads])
    works = [load for load in loads if load.quantity == "power"]
    yield columns(
        ("work of", "put in (J)", "taken out (J)"),
        [(load.name, f"{load.put_in:.6g}", f"{load.taken_out:.6g}") for load in works],
    )
    yield "± is the uncertainty between samples"
    if actuators.is_shared:
        yield _sharing(actuators)
    if actuators.rank < actuators.freedom:
        reached = f"{actuators.rank} of {actuators.freedom} degrees of freedom"
        yield f"the actuators reach {reached}; the others take no force"
    yield f"power balance: {actuators.balance:.2g} of the largest power"
    yield from _dead(actuators)
    yield from _smoothing(actuators.smoothing)


def _row(load: Any, over: str | None, turns: bool) -> tuple[str, ...]:
    place = "-" if over is None else f"{degrees(load.place):.1f}°" if turns else f"{load.place:.5g}"
    return cells(load, load.name + (" power" if load.quantity == "power" else ""), place)


def _sharing(actuators: ActuatorLoads) -> str:
    weights = dict(zip(actuators.names, actuators.weights.tolist(), strict=True))
    weighed = {name: weight for name, weight in weights.items() if weight != 1.0}
    said = ", ".join(f"{name} {weight:g}" for name, weight in weighed.items())
    mixed = "; N and N m are weighed alike" if len(set(actuators.units)) > 1 and not weighed else ""
    norm = f"least weighted sum of squares ({said})" if weighed else "least sum of squares"
    return f"more actuators than degrees of freedom that they reach: of all forces that balance, those of {norm}{mixed}"


def _dead(actuators: ActuatorLoads) -> Iterator[str]:
    if len(actuators.dead):
        listed = ", ".join(f"{time:.6g}" for time in actuators.dead[:LISTED]) + (
            ", .." if len(actuators.dead) > LISTED else ""
        )
        yield f"note: at t = {listed} s the actuators cannot move the mechanism (a dead centre): no force there"


def _smoothing(smoothing: Sequence[Smoothing]) -> Iterator[str]:
    """Yield how the given columns were smoothed."""
    if smoothing:
        yield "the motion against the data that was given"
        rows = [
            (
                each.name,
                "interpolated" if each.noise == 0.0 else f"smoothed, {each.noise:.3g}",
                f"{each.largest:.3g}",
                f"{each.time:.6g}",
                f"{each.rms:.3g}",
                each.unit,
            )
            for each in smoothing
        ]
        yield columns(("column", "spline", "largest change", "at t (s)", "rms", "unit"), rows)


def table(actuators: ActuatorLoads) -> tuple[list[str], np.ndarray[Any, Any]]:
    """The headings and the rows (T, 1 + 3 k) of a CSV table."""
    headings = ["time (s)"]
    for name, unit in zip(actuators.names, actuators.units, strict=True):
        own = "rad/s" if unit == "N m" else "m/s"
        headings += [f"{name} force ({unit})", f"{name} rate ({own})", f"{name} power (W)"]
    parts = np.stack([actuators.force, actuators.rate, actuators.power], axis=2).reshape(len(actuators.time), -1)
    return headings, np.concatenate([actuators.time[:, None], parts], axis=1)
