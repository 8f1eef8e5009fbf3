"""The expectations of a scene, checked on the results of its run, and the series of the quantities that they name.

`outcomes` takes expectations and results, and says what was measured, in SI units and radians, and how much of the
allowed error is used. `measured` and `series` do the same for the measures of studies, from a file or from memory: T is
the number of samples, k the number of components.

A value between samples, where a joint coordinate first passes a value, is that of a polynomial through neighbouring
samples. These polynomials do not cross an event, where a quantity may jump.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, numbers
from mbproj.base.dataclass import dataclass
from mbproj.results.between_samples import between
from mbproj.results.layout import ALL_NAMES
from mbproj.results.record import Results
from mbproj.scene.blocks.observables import CONTACT, TENSION, VELOCITY_RATIO, output_of
from mbproj.scene.records import Expectation, Passage
from mbproj.scene.sampling import SAME_TIME

# --- Outcomes: expectations beside what was measured ------------------------------------------------------------------


@dataclass(frozen=True)
class Outcome:
    """An expectation and the measured value, in the unit of the expectation. `measured` holds its components, at the
    time `time` (s); both are None where the run has no such sample. `error` is the largest deviation of a component; a
    bound has none. `unique` is False for a reaction that redundant joints share arbitrarily."""

    expectation: Expectation
    measured: tuple[float, ...] | None = None
    time: float | None = None
    error: float | None = None
    unique: bool = True

    @property
    def checked(self) -> bool:
        """Whether there was a sample to check."""
        return self.measured is not None

    @property
    def holds(self) -> bool:
        """Whether the expectation is met. NaN and a missing sample never meet one."""
        return self.share <= 1.0

    @property
    def share(self) -> float:
        """The part of the allowed error that is used: above 1 where the expectation is not met, infinite without a
        sample. For a bound, it is the value over the bound where both have one sign."""
        expected, measured = self.expectation, self.measured
        if measured is None:
            return inf
        if expected.tolerance is not None:
            assert self.error is not None
            return self.error / expected.tolerance
        if expected.below is not None:
            return _share_of_bound(measured[0], expected.below)
        assert expected.above is not None
        return _share_of_bound(-measured[0], -expected.above)


def _share_of_bound(number: float, bound: float) -> float:
    """The part of a bound that a number reaches: above 1 where the number is beyond the bound or NaN."""
    share = number / bound if bound > 0.0 else 0.0
    if number <= bound:
        return max(share, 0.0)
    return share if share > 1.0 else inf


def outcomes(expectations: Iterable[Expectation], results: Results) -> list[Outcome]:
    """The outcomes of all expectations, in their order."""
    duration = results.settings.duration
    return [_outcome(expectation, results, duration) for expectation in expectations]


def _outcome(expectation: Expectation, results: Results, duration: float | None) -> Outcome:
    measurement = measured(expectation, results, duration)
    if measurement is None:
        return Outcome(expectation)
    values, time, unique = measurement.values, measurement.time, is_unique(expectation, results)
    if expectation.value is None:
        return Outcome(expectation, _plain(values), time, unique=unique)
    exact = np.array(expectation.value)
    if expectation.quantity == "orientation" and values @ exact < 0.0:  # q and -q are the same orientation
        values = -values
    return Outcome(expectation, _plain(values), time, float(np.abs(values - exact).max()), unique)


def _plain(values: Array) -> tuple[float, ...]:
    """The numbers as Python's own."""
    return tuple(float(value) for value in values)


# --- The value of a series at the moment that an expectation names ----------------------------------------------------


#: Halvings of an interval: more than a double has digits.
BISECTIONS = 60
#: A sample counts as at the value where it differs by at most this part of the largest value.
SAME_VALUE = 1e-12
TURN = 2.0 * np.pi


class SampleSource(Protocol):
    """An object that has the samples of a run: `Results`, for example."""

    @property
    def event_times(self) -> Array:
        """The times (n,), s, at which steps ended at events."""

    def __getitem__(self, path: str, /) -> npt.NDArray[Any]:
        """The array of a dataset of the results' layout."""

    def names(self, kind: str) -> Sequence[str]:
        """The names of the columns of a kind, such as "markers"."""


class MeasuredValue(NamedTuple):
    """The measured components (k,), and the time (s) of their sample."""

    values: Array
    time: float


def measured(expectation: Expectation, samples: SampleSource, duration: float | None) -> MeasuredValue | None:
    """Measure what an expectation names in the samples of a run over `duration` (s, None where it is not known). None
    where they have no sample at its time."""
    time = samples["time"]
    if not len(time):
        return None
    values = components(expectation, series(expectation, samples))
    if isinstance(expectation.at, Passage):
        return _at_passage(expectation, expectation.at, samples, values)
    row = _row(expectation, time, values, duration)
    return None if row is None else MeasuredValue(values[row], float(time[row]))


def components(expectation: Expectation, values: Array) -> Array:
    """The components (T, k) that the expectation names of its series `values`. They are absolute values for the largest
    magnitude, and differences from the least value for the range."""
    if expectation.component == "norm":
        return np.linalg.norm(values, axis=1, keepdims=True)
    chosen = values[:, ["xyz".index(expectation.component)]] if expectation.component else values
    if expectation.at == "range":
        return np.asarray(chosen - chosen.min(axis=0))
    return np.abs(chosen) if expectation.at == "largest" else chosen


def _row(expectation: Expectation, time: Array, values: Array, duration: float | None) -> int | None:
    """The number of the sample to measure, with components `values` (T, k); None where there is none at that time. A
    NaN counts as the largest and the smallest number."""
    moment = expectation.at
    assert not isinstance(moment, Passage)
    if isinstance(moment, str):
        pick: Mapping[str, Callable[[], Any]] = {
            "end": lambda: len(time) - 1,
            "maximum": lambda: np.argmax(values[:, 0]),
            "minimum": lambda: np.argmin(values[:, 0]),
            "largest": lambda: np.argmax(values[:, 0]),
            "range": lambda: np.argmax(values[:, 0]),
        }
        return int(pick[moment]())
    nearest = int(np.argmin(np.abs(time - moment)))
    return nearest if abs(time[nearest] - moment) <= SAME_TIME * (duration or time[-1]) else None


def _at_passage(
    expectation: Expectation, passage: Passage, samples: SampleSource, values: Array
) -> MeasuredValue | None:
    """Measure between samples, where a coordinate first passes its value; None where it never does. A ratio has poles,
    so its two speeds are interpolated."""
    time, column = samples["time"], list(samples.names("coordinates")).index(passage.coordinate)
    coordinate = samples["joints/coordinate"][:, column]
    events = samples.event_times
    when = time_of_passage(passage, time, coordinate, events)
    if when is None:
        return None
    if expectation.over:
        pair = curves_at(time, speeds(expectation, samples), when, events)
        return MeasuredValue(ratio_of(expectation, pair[None]), when)
    return MeasuredValue(curves_at(time, values, when, events), when)


def time_of_passage(passage: Passage, time: Array, coordinate: Array, events: Array) -> float | None:
    """The time in s at which the coordinate (T,) first has the value, angles modulo a turn; None where it never has it.
    It is that of a sample at the value, or of a sign change between two samples, whichever is first."""
    turn = TURN if passage.unit == "rad" else np.inf
    apart = coordinate - passage.value
    whole_turns = np.zeros_like(apart) if np.isinf(turn) else turn * np.round(apart / turn)
    size = max(float(np.abs(coordinate).max(initial=0.0)), abs(passage.value), 1e-300)
    at_value = np.flatnonzero(np.abs(apart - whole_turns) <= SAME_VALUE * size)
    # The side of a length, or the number of the turn of an angle: it changes where the value is passed.
    side = (apart > 0.0).astype(float) if np.isinf(turn) else np.floor(apart / turn)
    crossed = np.flatnonzero(side[1:] != side[:-1])
    if len(crossed) and (not len(at_value) or crossed[0] + 1 < at_value[0]):
        before = int(crossed[0])
        target = passage.value + (0.0 if np.isinf(turn) else turn * max(side[before], side[before + 1]))
        return _root(time, coordinate - target, before, events)
    return float(time[at_value[0]]) if len(at_value) else None


def _root(time: Array, values: Array, before: int, events: Array) -> float:
    """The time of the sign change after the sample `before`, on the polynomial through neighbouring samples."""
    low, high = float(time[before]), float(time[before + 1])
    sign = values[before] > 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if (curves_at(time, values[:, None], middle, events)[0] > 0.0) == sign:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def curves_at(time: Array, values: Array, when: float, events: Array) -> Array:
    """The values (k,) of curves (T, k) at a time `when` between two samples."""
    return between(time, values, events, np.array([when]))[0]


# --- The series of the quantity that an expectation names, over all samples -------------------------------------------


#: The kind of names in the results, by the kind of object that an expectation is `of`.
KIND_OF = {
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
ENERGIES = ("diagnostics/kinetic_energy", "diagnostics/potential_energy")
BALANCE = "diagnostics/energy_balance"
_TRANSLATION, _ROTATION = ("x", "y", "z"), ("rx", "ry", "rz")
#: The coordinates of a bushing that make up a quantity, and the dataset of their columns.
BUSHING_COLUMNS: Mapping[str, tuple[tuple[str, ...], str]] = {
    "translation": (_TRANSLATION, "coordinate"),
    "rotation": (_ROTATION, "coordinate"),
    "translation_rate": (_TRANSLATION, "rate"),
    "rotation_rate": (_ROTATION, "rate"),
    "force": (_TRANSLATION, "force"),
    "torque": (_ROTATION, "force"),
}


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
        return (_dataset_of(expectation, coordinates)[0], *passed)
    if expectation.quantity == "energy_drift_relative":
        return (BALANCE, *ENERGIES, *passed)
    return (BALANCE if expectation.quantity == "energy_drift" else f"diagnostics/{expectation.quantity}", *passed)


def _dataset_of(expectation: Expectation, coordinates: Sequence[str]) -> tuple[str, str, str]:
    """Where the results have the quantity: the path of the dataset, and the kind and the name of its column."""
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
    kind = KIND_OF[expectation.of]
    if expectation.of == "force" and quantity in BUSHING_COLUMNS:
        quantity = BUSHING_COLUMNS[quantity][1]
    return f"{ALL_NAMES[kind].group}/{quantity}", kind, item


def _column(expectation: Expectation, samples: SampleSource) -> npt.NDArray[Any]:
    """The column that the expectation names; three columns for a bushing."""
    path, kind, name = _dataset_of(expectation, samples.names("coordinates"))
    names = list(samples.names(kind))
    if expectation.of == "force" and name not in names:
        columns = [names.index(f"{name}.{coordinate}") for coordinate in BUSHING_COLUMNS[expectation.quantity][0]]
        return np.asarray(samples[path][:, columns])
    column: npt.NDArray[Any] = samples[path][:, names.index(name)]
    return column


def _diagnostic(expectation: Expectation, samples: SampleSource) -> Array:
    """A diagnostic series of the run; for energy drift the size of the energy balance, in J or relative to the
    exchanged energy."""
    name = expectation.quantity
    if not name.startswith("energy_drift"):
        return samples[f"diagnostics/{name}"]
    balance: Array = np.abs(samples[BALANCE])
    if name == "energy_drift":
        return balance
    from mbproj.results.analysis.summary import relative_drift

    return relative_drift(balance, *(samples[path] for path in ENERGIES))


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


# --- Ratios to an input, and transmission angles ----------------------------------------------------------------------
# Uicker, Pennock and Shigley, Theory of Machines and Mechanisms, ch. 3.


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


# --- Whether the results determine the quantity -----------------------------------------------------------------------


#: The quantities that stops, frictions and joints may share arbitrarily.
SHARED = ("force", "reaction_force", "reaction_torque")


def is_unique(expectation: Expectation, results: Results) -> bool:
    """Whether the constraints and contacts determine the quantity: redundant joints share their reactions arbitrarily.
    True where the results have no marks."""
    if expectation.of != "joint" and expectation.quantity not in SHARED:
        return True
    from mbproj.results.analysis.loads import REACTIONS, shared_at_contacts

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
