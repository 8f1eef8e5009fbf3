"""The series that a page charts: all that the run recorded, as far as there is room."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.results import Results

#: The most numbers of all series together. Groups that come later are left out first.
ROOM = 1_200_000


@dataclass(frozen=True, eq=False)
class SeriesGroup:
    """The series of one quantity: one of the run (`kind` ""), or one for each of `owners`, in `components` ("" for a
    scalar).

    `units` has one entry for the run, or one for each owner. `logarithmic` series are shown on a logarithmic scale."""

    name: str
    kind: str
    owners: tuple[str, ...]
    components: tuple[str, ...]
    units: tuple[str, ...]
    path: str
    logarithmic: bool = False

    @property
    def columns(self) -> int:
        """The number c of columns."""
        return max(len(self.owners), 1) * len(self.components)

    def values(self, results: Results) -> Array:
        """The series over all samples (T, c)."""
        read = np.asarray(results[self.path], dtype=float)
        return read.reshape(len(read), -1)


XYZ = ("x", "y", "z")
_RUN = (
    ("position violation", "m or rad", "diagnostics/position_violation", True),
    ("velocity violation", "m/s or rad/s", "diagnostics/velocity_violation", True),
    ("kinetic energy", "J", "diagnostics/kinetic_energy", False),
    ("potential energy", "J", "diagnostics/potential_energy", False),
    ("total energy", "J", "diagnostics/total_energy", False),
    ("energy balance", "J", "diagnostics/energy_balance", False),
    ("step size", "s", "diagnostics/step_size", True),
)
#: The kind of owners, quantity, unit and dataset of vector series. Angular velocities of bodies are in body axes, all
#: others in global axes.
_VECTORS = (
    ("joints", "reaction force", "N", "joints/reaction_force"),
    ("joints", "reaction torque", "N m", "joints/reaction_torque"),
    ("markers", "velocity", "m/s", "markers/velocity"),
    ("bodies", "velocity", "m/s", "bodies/velocity"),
    ("bodies", "angular velocity", "rad/s", "bodies/angular_velocity"),
    ("markers", "acceleration", "m/s²", "markers/acceleration"),
    ("bodies", "acceleration", "m/s²", "bodies/acceleration"),
    ("touching", "contact", "m", "curves/contact"),
)


def groups_of(results: Results) -> Iterator[SeriesGroup]:
    """All groups that the results have, the most useful first."""
    for name, unit, path, logarithmic in _RUN:
        yield SeriesGroup(name, "", (), ("",), (unit,), path, logarithmic)
    for group in _of_columns(results):
        if group.owners:
            yield group


def _of_columns(results: Results) -> Iterator[SeriesGroup]:
    joints, along, units = (results.names(kind) for kind in ("joints", "coordinates", "coordinate_units"))
    yield SeriesGroup("violation", "joints", joints, ("",), ("m or rad",) * len(joints), "joints/violation", True)
    yield SeriesGroup("coordinate", "coordinates", along, ("",), units, "joints/coordinate")
    yield SeriesGroup("rate", "coordinates", along, ("",), tuple(f"{unit}/s" for unit in units), "joints/speed")
    forces, lengths = results.names("forces"), results.names("force_units")
    yield SeriesGroup("coordinate", "forces", forces, ("",), lengths, "forces/coordinate")
    yield SeriesGroup("force", "forces", forces, ("",), _force_units(lengths), "forces/force")
    ropes = results.names("tensions")
    yield SeriesGroup("tension", "tensions", ropes, ("",), ("N",) * len(ropes), "ropes/tension")
    motions = results.names("motions")
    yield SeriesGroup("force", "motions", motions, ("",), _force_units(results.names("motion_units")), "motions/force")
    for kind, of in (("states", "state"), ("signals", "signal")):
        yield SeriesGroup("value", kind, results.names(kind), ("",), results.names(f"{of}_units"), f"{kind}/value")
    for kind, name, unit, path in _VECTORS:
        owners = results.names(kind)
        yield SeriesGroup(name, kind, owners, XYZ, (unit,) * len(owners), path)


def _force_units(units: Sequence[str]) -> tuple[str, ...]:
    """The units of forces along coordinates with these units."""
    return tuple("N m" if unit == "rad" else "N" for unit in units)


def fitting(groups: Iterable[SeriesGroup], frames: int) -> tuple[list[SeriesGroup], list[SeriesGroup]]:
    """The groups for which there is room, and those that are left out."""
    kept: list[SeriesGroup] = []
    left: list[SeriesGroup] = []
    room = ROOM
    for group in groups:
        size = group.columns * frames
        (kept if size <= room else left).append(group)
        room -= size if size <= room else 0
    return kept, left
