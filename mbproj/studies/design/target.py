"""The target of a match: a quantity of the run, and the values with which it is compared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.results.analysis.expectations import SampleSource, components, series
from mbproj.results.between_samples import between
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.blocks.expectations import ExpectationKeys, complaints, measures_of
from mbproj.scene.blocks.observables import OBSERVABLES, OF_BUSHINGS, Observable, coordinates_of
from mbproj.scene.fields.quantities import agrees
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import Expectation
from mbproj.scene.scene import Scene
from mbproj.scene.settings import settings_to_run
from mbproj.studies.inverse.given_motion import TIME_NAMES, CsvTable, read_columns

TIME, PATH = "time", "path"
#: The search for the point of a curve nearest to a given one: the number of places for each interval of samples, the
#: number of Newton's steps from the best place, and their differences as a part of the distance of two places.
FINER, NEWTON, ASIDE = 8, 6, 1e-3
#: The number of halvings of an interval in which a coordinate passes a value.
SHRINKS = 45
TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Target:
    """N points `values` (N, k) of k `measures` in `unit`, over `abscissa` (N,): times in s, or values of the joint
    coordinate `over`. Over a "path" the points belong to no particular time. A residual is divided by `deviation`, and
    its square has the weight `weight`."""

    name: str
    measures: tuple[Expectation, ...]
    unit: str
    over: str
    abscissa: Array
    values: Array
    deviation: float
    weight: float
    source: str

    @property
    def needed(self) -> tuple[Expectation, ...]:
        """The measures that a run must record for this target."""
        if self.over in (TIME, PATH):
            return self.measures
        joint, _, coordinate = self.over.partition(".")
        along = Expectation(self.over, "joint", joint, coordinate, COORDINATES[coordinate], "", "end", "")
        return (*self.measures, along)

    def reached(self, samples: SampleSource) -> Array | None:
        """Return the run's values at the abscissa, (N, k); None where the coordinate does not pass all of it."""
        time, events = samples["time"], samples.event_times
        curve = np.concatenate([components(each, series(each, samples)) for each in self.measures], axis=1)
        if self.over == TIME:
            return between(time, curve, events, np.minimum(self.abscissa, time[-1]))
        if self.over == PATH:
            return _nearest(time, curve, events, self.values)
        when = _passages(time, series(self.needed[-1], samples)[:, 0], events, self.abscissa, self.needed[-1].unit)
        return None if when is None else between(time, curve, events, when)

    def residuals(self, samples: SampleSource) -> Array | None:
        """Return (run - values) / deviation × √weight, (k N,), measure by measure; None where the coordinate does not
        pass all values."""
        reached = self.reached(samples)
        if reached is None:
            return None
        return np.asarray((reached - self.values).T.ravel() * (self.weight**0.5 / self.deviation))


def _nearest(time: Array, curve: Array, events: Array, points: Array) -> Array:
    """Return the points (N, k) of a curve (T, k) nearest to given points."""
    fine = np.linspace(time[0], time[-1], FINER * (len(time) - 1) + 1)
    there = between(time, curve, events, fine)
    best = np.argmin(np.sum((there[None] - points[:, None]) ** 2, axis=2), axis=1)
    low, high = fine[np.maximum(best - 1, 0)], fine[np.minimum(best + 1, len(fine) - 1)]
    when, aside = fine[best], ASIDE * (fine[1] - fine[0])
    for _ in range(NEWTON):
        before, after = np.maximum(when - aside, time[0]), np.minimum(when + aside, time[-1])
        places = between(time, curve, events, np.concatenate([before, 0.5 * (before + after), after]))
        first, middle, last = places.reshape(3, *points.shape)
        rate, off = (last - first) / (after - before)[:, None], middle - points
        bend = (first - 2.0 * middle + last) / (0.5 * (after - before))[:, None] ** 2
        square = np.sum(rate**2, axis=1)
        slope = square + np.sum(off * bend, axis=1)
        step = np.sum(off * rate, axis=1) / np.where(slope > 0.1 * square, slope, np.maximum(square, 1e-300))
        when = np.clip(0.5 * (before + after) - step, low, high)
    nearest = between(time, curve, events, when)
    nearer = np.sum((nearest - points) ** 2, axis=1) <= np.sum((there[best] - points) ** 2, axis=1)
    return np.where(nearer[:, None], nearest, there[best])


def _passages(time: Array, coordinate: Array, events: Array, wanted: Array, unit: str) -> Array | None:
    """Return the times at which the coordinate (T,) first passes the values (N,), angles modulo a turn; None where it
    does not pass all."""
    values = wanted
    if unit == "rad":
        low, high = coordinate.min(), coordinate.max()
        values = wanted + TURN * (np.ceil((low - wanted) / TURN) if coordinate[-1] >= coordinate[0] else 0.0)
        if coordinate[-1] < coordinate[0]:
            values = wanted + TURN * np.floor((high - wanted) / TURN)
    apart = coordinate[None] - values[:, None]
    crosses = (apart[:, 1:] >= 0.0) != (apart[:, :-1] >= 0.0)
    met = np.isclose(apart, 0.0, rtol=0.0, atol=1e-12 * max(float(np.abs(coordinate).max()), 1.0))
    first_cross = np.where(crosses.any(axis=1), np.argmax(crosses, axis=1), len(time))
    first_met = np.where(met.any(axis=1), np.argmax(met, axis=1), len(time))
    if np.any(np.minimum(first_cross, first_met) == len(time)):
        return None
    cross = np.minimum(first_cross, len(time) - 2)
    low, high = time[cross], time[cross + 1]
    rising = apart[np.arange(len(values)), cross] < 0.0
    for _ in range(SHRINKS):
        middle = 0.5 * (low + high)
        below = between(time, coordinate[:, None], events, middle)[:, 0] < values
        low, high = np.where(below == rising, middle, low), np.where(below == rising, high, middle)
    at_sample = first_met <= first_cross
    return np.where(at_sample, time[np.minimum(first_met, len(time) - 1)], 0.5 * (low + high))


# --- The `match` of a design ------------------------------------------------------------------------------------------
# The quantity, and the columns of a file with its wanted values.


#: The quantity that is matched by default, by the kind of object.
USUAL = {"marker": "position", "body": "position"}
AXES = ("x", "y", "z")


class Match:
    """A match under `name` with the keys `entry`, for the scene `base`. Its files are relative to `folder`. Problems
    are reported at their places."""

    def __init__(self, name: str, entry: ExpectationKeys, base: Scene, folder: Path, reading: Reading) -> None:
        self._name, self._entry, self._base, self._reading = name, entry, base, reading
        self._of = next(key for key in OBSERVABLES if key in entry)
        self._path = folder / entry["through"]
        self._over: str = entry.get("over", TIME)
        self.notes: list[str] = []  # on possible mistakes

    def target(self) -> Target | None:
        """Return the target of this match; None where it has a problem."""
        before = len(self._reading.problems)
        quantity = self._quantity()
        columns = self._table()
        if quantity is None or columns is None or not self._over_is_known():
            return None
        place = Place(str(self._path), columns.heading_line)
        if not self._headings_are_known(quantity, columns):
            return None
        numbers = self._value_columns(quantity, columns)
        if not numbers:
            wanted = self._names(quantity, AXES[0] if self._components(quantity) == AXES else "")[0]
            hint = f"name one '{wanted}', or say which it is: columns: {{{wanted}: HEADING}}"
            self._reading.report(f"no column is of '{quantity}' of '{self._item}'", place, hint)
            return None
        words = {self._of: self._item, **({} if self._of == "diagnostic" else {"quantity": quantity}), "at": "end"}
        measures = {f"{self._name}{part}": {**words, **({"component": part} if part else {})} for part in numbers}
        for complaint in complaints(measures, self._base):
            self._reading.report(complaint.message, self._at(*map(str, complaint.path[2:])), complaint.hint)
        if len(self._reading.problems) > before:
            return None
        chosen = measures_of(measures, self._base)
        unit = chosen[0].unit
        try:
            values = np.stack([columns.column(number, unit, place) for number in numbers.values()], axis=1)
            abscissa = self._abscissa(columns, place)
        except InputError as error:
            self._reading.problems += error.problems
            return None
        if unit and not any(columns.headings[number][1] for number in numbers.values()):
            self.notes.append(f"'{self._entry['through']}' has no unit for '{quantity}': it is read in {unit}")
        deviation, weight = self._deviation(unit), self._entry.get("weight", 1.0)
        if len(self._reading.problems) > before:
            return None
        return Target(self._name, chosen, unit, self._over, abscissa, values, deviation, weight, self._entry["through"])

    @property
    def _item(self) -> str:
        return str(self._entry[self._of])

    def _at(self, *keys: str) -> Place:
        """The place of a key of this match, or of the match itself."""
        return self._reading.places.get(("match", self._name, *keys)) or self._reading.places[("match", self._name)]

    def _quantity(self) -> str | None:
        usual = self._item if self._of == "diagnostic" else USUAL.get(self._of, "")
        quantity, able = self._entry.get("quantity", usual), self._able
        if quantity in able:
            return str(quantity)
        message = f"a {self._of} has no '{quantity}'" if quantity else "missing key 'quantity'"
        self._reading.report(message, self._at("quantity"), choose_from(quantity, able))
        return None

    @property
    def _able(self) -> Mapping[str, Observable]:
        return {**OBSERVABLES[self._of], **(OF_BUSHINGS if self._of == "force" else {})}

    def _over_is_known(self) -> bool:
        known = [TIME, PATH, *coordinates_of({joint.name: joint for joint in self._base.joints})]
        if self._over not in known:
            message = f"nothing is over '{self._over}'"
            self._reading.report(message, self._at("over"), choose_from(self._over, known))
        return self._over in known

    def _table(self) -> CsvTable | None:
        place = self._at("through")
        try:
            table = read_columns(self._path, place.file)
        except InputError as error:
            for problem in error.problems:
                there = problem.place is not None and problem.place.line is not None
                unread = problem.message.startswith("cannot read")
                message = problem.message if there or unread else f"'{self._path}': {problem.message}"
                moved = replace(problem, message=message, place=problem.place if there else place)
                self._reading.problems.append(moved)
            return None
        if not len(table.rows):
            where = Place(str(self._path), table.heading_line)
            self._reading.report("it has no row below its headings", where, "give measurements")
            return None
        return table

    def _components(self, quantity: str) -> tuple[str, ...]:
        """The components of a quantity that columns may contain."""
        return AXES if self._able[quantity].components == len(AXES) else ("",)

    def _names(self, quantity: str, part: str) -> list[str]:
        """The possible headings of a column; the first is that of `mbproj export`."""
        component = f"{quantity}_{part}" if part else quantity
        short = [part, f"{self._item}.{part}"] if part and quantity == "position" else []
        return [component, f"{self._item}.{component}", *short]

    def _headings_are_known(self, quantity: str, columns: CsvTable) -> bool:
        """Whether the key `columns` names components of this match and headings of the file. Other names are
        reported."""
        before = len(self._reading.problems)
        known = [name for name, _ in columns.headings]
        lower = [name.lower() for name in known]
        expected = [name for part in self._components(quantity) for name in self._names(quantity, part)]
        for what, heading in self._headings.items():
            if what not in (*expected, self._over):
                message = f"'{what}' is no column of this match"
                self._reading.report(message, self._at("columns", what), choose_from(what, [*expected, self._over]))
            elif heading not in known and (what != self._over or heading.lower() not in lower):
                message = f"'{self._entry['through']}' has no column '{heading}'"
                self._reading.report(message, self._at("columns", what), choose_from(heading, known))
        return len(self._reading.problems) == before

    def _value_columns(self, quantity: str, columns: CsvTable) -> dict[str, int]:
        """The numbers of the columns of values, by component."""
        known = [name for name, _ in columns.headings]
        by_part = {}
        for part in self._components(quantity):
            names = self._names(quantity, part)
            asked = [self._headings[name] for name in names if name in self._headings]
            able = asked or [name for name in names if name in known]
            if len(able) > 1:
                both = f"'{able[0]}' and '{able[1]}' could both be '{names[0]}'"
                place = Place(str(self._path), columns.heading_line)
                self._reading.report(both, place, f"say which it is: columns: {{{names[0]}: HEADING}}")
            if able:
                by_part[part] = known.index(able[0])
        return by_part

    @property
    def _headings(self) -> Mapping[str, str]:
        headings: Mapping[str, str] = self._entry.get("columns", {})
        return headings

    def _abscissa(self, columns: CsvTable, place: Place) -> Array:
        """The times or coordinates at which the values are given, (N,); zeros over a path. Raises InputError where they
        have no column, or a time is outside the run."""
        if self._over == PATH:
            return np.zeros(len(columns.rows))
        asked = [self._headings[self._over]] if self._over in self._headings else []
        names = [name.lower() for name in asked or (TIME_NAMES if self._over == TIME else (self._over,))]
        hint = f"say which it is: columns: {{{self._over}: HEADING}}; points without a time are over: path"
        able = [k for k, (name, _) in enumerate(columns.headings) if name.lower() in names]
        if not able:
            raise InputError(Problem(f"no column is of '{self._over}'", place, hint))
        if len(able) > 1:
            both = " and ".join(f"'{columns.headings[k][0]}'" for k in able[:2])
            raise InputError(Problem(f"{both} could both be '{self._over}'", place, hint))
        (number,) = able
        if self._over != TIME:
            return columns.column(number, COORDINATES[self._over.partition(".")[2]], place)
        settings = settings_to_run(self._base, by_options=False)
        times, duration = columns.column(number, "s", place), settings.duration or np.inf
        for row in np.flatnonzero((times < 0.0) | (times > duration * (1.0 + 1e-12)))[:1]:
            message = f"{times[row]:.6g} s is outside the run, which is from 0 to {duration:.6g} s"
            hint = "make the scene's duration longer, or leave the row out"
            raise InputError(Problem(message, Place(place.file, columns.lines[row]), hint))
        return times

    def _deviation(self, unit: str) -> float:
        """The deviation that makes a residual of 1, in the quantity's unit."""
        deviation = self._entry.get("deviation")
        if deviation is None:
            return 1.0
        if not agrees(unit, deviation.dimension):
            what = f"is in {unit}" if unit else "has no unit"
            self._reading.report(f"'deviation' {what}, like the matched quantity", self._at("deviation"))
        return float(deviation.number)
