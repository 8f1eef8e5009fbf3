"""The quantity that an expectation or a measure names, over all samples of a run, from a file or from memory.

Ratios to an input and transmission angles are those of Uicker, Pennock and Shigley, Theory of Machines and Mechanisms,
ch. 3.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, numbers
from mbproj.results import Results
from mbproj.results.layout import ALL_NAMES
from mbproj.scene.blocks.observables import CONTACT, TENSION, VELOCITY_RATIO, output_of
from mbproj.scene.records import Expectation, Passage

#: The kind of names in the results, for each kind of observed object.
PLACES = {
    "marker": "markers",
    "body": "bodies",
    "joint": "joints",
    "force": "forces",
    "motion": "motions",
    "stop": "stops",
    "friction": "frictions",
    "state": "states",
    "signal": "signals",
}
#: The quantities that stops, frictions and joints may share arbitrarily.
SHARED = ("force", "reaction_force", "reaction_torque")
ENERGIES = ("diagnostics/kinetic_energy", "diagnostics/potential_energy")
BALANCE = "diagnostics/energy_balance"
_TRANSLATION, _ROTATION = ("x", "y", "z"), ("rx", "ry", "rz")
#: The coordinates of a bushing that make up a quantity, and the dataset of their columns.
OF_BUSHINGS: Mapping[str, tuple[tuple[str, ...], str]] = {
    "translation": (_TRANSLATION, "coordinate"),
    "rotation": (_ROTATION, "coordinate"),
    "translation_rate": (_TRANSLATION, "rate"),
    "rotation_rate": (_ROTATION, "rate"),
    "force": (_TRANSLATION, "force"),
    "torque": (_ROTATION, "force"),
}


class SampleSource(Protocol):
    """An object that has the samples of a run: `Results`, for example."""

    @property
    def event_times(self) -> Array:
        """The times (n,), s, at which steps ended at events."""

    def __getitem__(self, path: str, /) -> npt.NDArray[Any]:
        """The array of a dataset of the results' layout."""

    def names(self, kind: str) -> Sequence[str]:
        """The names of the columns of a kind, such as "markers"."""


def series(expectation: Expectation, samples: SampleSource) -> Array:
    """All samples of the quantity that the expectation names: (T, k) with k components."""
    time = samples["time"]
    if expectation.over or expectation.between:
        return _kinematic(expectation, samples).reshape(len(time), 1)
    values = _diagnostic(expectation, samples) if expectation.of == "diagnostic" else _column(expectation, samples)
    return numbers(values).reshape(len(time), -1)


def datasets(expectation: Expectation, coordinates: Sequence[str]) -> tuple[str, ...]:
    """The paths of the datasets that `series` reads beside the time. `coordinates` are the names of the joint
    coordinates."""
    passed = ("joints/coordinate",) if isinstance(expectation.at, Passage) else ()
    if expectation.over or expectation.between:
        return ("joints/speed" if expectation.over else "markers/position", *passed)
    if expectation.of != "diagnostic":
        return (_place(expectation, coordinates)[0], *passed)
    if expectation.quantity == "energy_drift_relative":
        return (BALANCE, *ENERGIES, *passed)
    return (BALANCE if expectation.quantity == "energy_drift" else f"diagnostics/{expectation.quantity}", *passed)


def is_unique(expectation: Expectation, results: Results) -> bool:
    """Whether the constraints and contacts determine the quantity; True where the results have no marks."""
    if expectation.of != "joint" and expectation.quantity not in SHARED:
        return True
    from mbproj.analysis.reactions import REACTIONS, shared_at_contacts

    if expectation.quantity in SHARED and f"{expectation.of} '{expectation.item}'" in shared_at_contacts(results):
        return False
    of_rope = expectation.quantity.startswith(TENSION)
    if not of_rope and f"joints/{expectation.quantity}" not in REACTIONS:
        return True
    marks = results.constant(f"{REACTIONS[0] if of_rope else f'joints/{expectation.quantity}'}_unique")
    if marks is None:
        return True
    return unique_in(expectation, marks[results.names("joints").index(expectation.item)])


def unique_in(expectation: Expectation, marks: npt.NDArray[np.bool_]) -> bool:
    """Whether the marks (3,) of its joint's unique reaction components include the expectation's component, or all for
    a vector."""
    return bool(marks["xyz".index(expectation.component)] if expectation.component in ("x", "y", "z") else marks.all())


def _place(expectation: Expectation, coordinates: Sequence[str]) -> tuple[str, str, str]:
    """The path of the dataset, and the kind and the name of its column."""
    item, quantity = expectation.item, expectation.quantity
    if quantity.startswith(TENSION):
        return "ropes/tension", "tensions", f"{item}.{quantity}"
    if expectation.of == "joint" and quantity == CONTACT:
        return "curves/contact", "touching", item
    if expectation.of == "joint":
        for name in coordinates:
            if f"{item}.{quantity}" in (name, f"{name}_speed"):
                path = "joints/coordinate" if name == f"{item}.{quantity}" else "joints/speed"
                return path, "coordinates", name
    kind = PLACES[expectation.of]
    if expectation.of == "force" and quantity in OF_BUSHINGS:
        quantity = OF_BUSHINGS[quantity][1]
    return f"{ALL_NAMES[kind].group}/{quantity}", kind, item


def _column(expectation: Expectation, samples: SampleSource) -> npt.NDArray[Any]:
    """The column that the expectation names; three columns for a bushing."""
    path, kind, name = _place(expectation, samples.names("coordinates"))
    names = list(samples.names(kind))
    if expectation.of == "force" and name not in names:
        columns = [names.index(f"{name}.{coordinate}") for coordinate in OF_BUSHINGS[expectation.quantity][0]]
        return np.asarray(samples[path][:, columns])
    column: npt.NDArray[Any] = samples[path][:, names.index(name)]
    return column


def _kinematic(expectation: Expectation, samples: SampleSource) -> Array:
    """The velocity ratio or mechanical advantage to the input, or the transmission angle, (T,)."""
    if expectation.between:
        names, position = list(samples.names("markers")), samples["markers/position"]
        first, second = (position[:, names.index(name)] for name in expectation.between)
        return transmission_angle(first, position[:, names.index(expectation.item)], second)
    return ratio_of(expectation, speeds(expectation, samples))


def speeds(expectation: Expectation, samples: SampleSource) -> Array:
    """The speeds of the output and the input of a ratio, (T, 2)."""
    names = list(samples.names("coordinates"))
    pair = f"{expectation.item}.{output_of(expectation.quantity)}", expectation.over
    return np.asarray(samples["joints/speed"][:, [names.index(name) for name in pair]])


def ratio_of(expectation: Expectation, pair: Array) -> Array:
    """The velocity ratio or the mechanical advantage (T,) of the speeds `pair` (T, 2)."""
    ratio = velocity_ratio if expectation.quantity.endswith(VELOCITY_RATIO) else mechanical_advantage
    return ratio(pair[:, 0], pair[:, 1])


def _diagnostic(expectation: Expectation, samples: SampleSource) -> Array:
    """A diagnostic series of the run; for energy drift the size of the energy balance, in J or relative to the
    exchanged energy."""
    name = expectation.quantity
    if not name.startswith("energy_drift"):
        return samples[f"diagnostics/{name}"]
    balance: Array = np.abs(samples[BALANCE])
    if name == "energy_drift":
        return balance
    from mbproj.analysis.energy import relative_drift

    return relative_drift(balance, *(samples[path] for path in ENERGIES))


#: Speeds below this part of the largest of the run count as rest. A ratio to an input at rest has no value.
REST = 1e-10


def velocity_ratio(output: Array, input_: Array) -> Array:
    """The rate of an output over that of an input, (T,): dsₒ/dsᵢ. NaN where the input rests."""
    moves = np.abs(input_) > REST * np.abs(input_).max(initial=0.0)
    return np.asarray(np.where(moves, output / np.where(moves, input_, 1.0), np.nan))


def mechanical_advantage(output: Array, input_: Array) -> Array:
    """The ratio of the force at an output to the force at an input that balances it, (T,): dsᵢ/dsₒ by virtual power,
    without inertia, friction and other forces. It is infinite, with the sign of the input, where only the output
    rests."""
    rests = np.abs(output) <= REST * np.abs(output).max(initial=0.0)
    moves = np.abs(input_) > REST * np.abs(input_).max(initial=0.0)
    advantage = np.where(rests, np.copysign(np.inf, input_), input_ / np.where(rests, 1.0, output))
    return np.asarray(np.where(moves, advantage, np.nan))


def transmission_angle(first: Array, corner: Array, second: Array) -> Array:
    """The angle at a `corner` between the lines to two other points, (T, 3) each, folded into 0 to π/2. At the joint of
    coupler and output it is best at π/2; at 0 nothing is transmitted."""
    one, other = first - corner, second - corner
    sine = np.linalg.norm(np.cross(one, other), axis=-1)
    return np.asarray(np.arctan2(sine, np.abs(np.sum(one * other, axis=-1))))
