"""The energy balance of a recorded run, with separate parts of the integrator and the projection."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from mbproj.api.again import stored_scene
from mbproj.cli.report.text import table
from mbproj.errors import InputError, Problem
from mbproj.registry import AUTOMATIC
from mbproj.report_schema import report_of
from mbproj.report_schema.results import ENERGY

if TYPE_CHECKING:
    from mbproj.results import Results


#: The sum of the parts is the change of energy to within this part of their size and of all energies. An implicit
#: method with error control ends Newton's iterations by its tolerance, which single steps do not have.
CLOSES, ROUND_OFF = 0.01, 1e-12


class EnergyParts(NamedTuple):
    """The energy E at the start and the end of a run, and its changes, all in J. Energy put in is positive."""

    start: float
    put_in: float
    dissipated: float
    integrator: float
    projection: float
    end: float

    @property
    def unexplained(self) -> float:
        """The change of energy that the parts do not explain, J."""
        return self.end - self.start - (self.put_in - self.dissipated + self.integrator + self.projection)

    @property
    def size(self) -> float:
        """The sum of the absolute values of all parts, J."""
        return sum(map(abs, self))


def split_energy(results: Results) -> EnergyParts:
    """Repeat each step of the run without and with projection, and sum the parts. Raises InputError for runs that
    cannot be divided, SimulationError where the run cannot be repeated."""
    from mbproj.studies.compare.energy_split import energy_split
    from mbproj.studies.measure.mechanism import Mechanism
    from mbproj.studies.measure.setting import Setting
    from mbproj.studies.measure.solve import sample_times, solve

    settings, mechanism = results.settings, Mechanism.of(stored_scene(results))
    obstacle = None
    if results.attributes.get("kinematic"):
        raise _undivided(results, "the run is kinematic, nothing of its motion was integrated")
    if settings.integrator == AUTOMATIC:
        obstacle = f"steps of '{AUTOMATIC}' are not all of one method"
    elif mechanism.system.stops is not None:
        obstacle = "impacts at stops belong to no step"
    elif mechanism.system.frictions is not None:
        obstacle = "dry friction sticks and slips between steps"
    elif results.status != "complete":
        obstacle = "the run did not come to its end"
    solution = solve(mechanism, Setting.of(settings), sample_times(settings.duration or 0.0, 1))
    if solution.failure is not None:
        obstacle = obstacle or solution.failure.cause
    if obstacle is not None:
        raise _undivided(results, obstacle)
    split = energy_split(mechanism, solution)
    energy, work, loss = (results[f"diagnostics/{name}"] for name in ("total_energy", "work", "dissipation"))
    parts = EnergyParts(
        start=float(energy[0]),
        put_in=float(work[-1]),
        dissipated=float(loss[-1]),
        integrator=float(split.integrator[-1]),
        projection=float(split.projection[-1]),
        end=float(energy[-1]),
    )
    if abs(parts.unexplained) > CLOSES * max(abs(parts.integrator), abs(parts.projection)) + ROUND_OFF * parts.size:
        raise _undivided(results, "its steps, made again one by one, are not those of the run")
    return parts


def _undivided(results: Results, why: str) -> InputError:
    return InputError(Problem(f"{results.path}: its energy cannot be divided: {why}"))


def facts(results: Results) -> dict[str, Any]:
    """The parts as a dictionary for JSON."""
    return report_of(ENERGY, split_energy(results), file=results.path)


def lines(results: Results) -> Iterator[str]:
    """Yield the energy at the start, its changes, and the energy at the end."""
    parts = split_energy(results)
    yield f"{results.path}: energy from the start to t = {results.time[-1]:g} s"
    said = {
        "at the start": f"{parts.start:.6e} J",
        "forces put in": f"{parts.put_in:.2e} J",
        "dampers took": f"{parts.dissipated:.2e} J",
        "the integrator": _changed(parts.integrator),
        "the projection": _changed(parts.projection),
        "at the end": f"{parts.end:.6e} J",
    }
    yield from table(said, indent="  ")


def _changed(energy: float) -> str:
    return f"took {-energy:.2e} J" if energy < 0.0 else f"added {energy:.2e} J"
