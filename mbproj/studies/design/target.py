"""The `match` of a design: the quantity, and the columns of a file with its wanted values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.blocks.expectations import Given
from mbproj.scene.blocks.measures import complaints, measures_of
from mbproj.scene.blocks.observables import OBSERVABLES, OF_BUSHINGS, Observable, coordinates_of
from mbproj.scene.fields.quantities import agrees
from mbproj.scene.fields.reading import Reading
from mbproj.scene.read import Scene
from mbproj.scene.settings import settings_to_run
from mbproj.studies.design.target import PATH, TIME, Target
from mbproj.studies.inverse.columns import TIME_NAMES, CsvTable, factor_of, read_columns

#: The quantity that is matched by default, by the kind of object.
USUAL = {"marker": "position", "body": "position"}
AXES = ("x", "y", "z")


class Match:
    """A match under `name` with the keys `given`, for the scene `base`. Its files are relative to `folder`. Problems
    are reported at their places."""

    def __init__(self, name: str, given: Given, base: Scene, folder: Path, reading: Reading) -> None:
        self._name, self._given, self._base, self._reading = name, given, base, reading
        self._of = next(key for key in OBSERVABLES if key in given)
        self._path = folder / given["through"]
        self._over: str = given.get("over", TIME)
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
            values = np.stack([_values(columns, number, unit, place) for number in numbers.values()], axis=1)
            abscissa = self._abscissa(columns, place)
        except InputError as error:
            self._reading.problems += error.problems
            return None
        if unit and not any(columns.headings[number][1] for number in numbers.values()):
            self.notes.append(f"'{self._given['through']}' has no unit for '{quantity}': it is read in {unit}")
        deviation, weight = self._deviation(unit), self._given.get("weight", 1.0)
        if len(self._reading.problems) > before:
            return None
        return Target(self._name, chosen, unit, self._over, abscissa, values, deviation, weight, self._given["through"])

    @property
    def _item(self) -> str:
        return str(self._given[self._of])

    def _at(self, *keys: str) -> Place:
        """The place of a key of this match, or of the match itself."""
        return self._reading.places.get(("match", self._name, *keys)) or self._reading.places[("match", self._name)]

    def _quantity(self) -> str | None:
        usual = self._item if self._of == "diagnostic" else USUAL.get(self._of, "")
        quantity, able = self._given.get("quantity", usual), self._able
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
        own = [name for part in self._components(quantity) for name in self._names(quantity, part)]
        for what, heading in self._headings.items():
            if what not in (*own, self._over):
                message = f"'{what}' is no column of this match"
                self._reading.report(message, self._at("columns", what), choose_from(what, [*own, self._over]))
            elif heading not in known and (what != self._over or heading.lower() not in lower):
                message = f"'{self._given['through']}' has no column '{heading}'"
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
        headings: Mapping[str, str] = self._given.get("columns", {})
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
            return _values(columns, number, COORDINATES[self._over.partition(".")[2]], place)
        settings = settings_to_run(self._base, by_options=False)
        times, duration = _values(columns, number, "s", place), settings.duration or np.inf
        for row in np.flatnonzero((times < 0.0) | (times > duration * (1.0 + 1e-12)))[:1]:
            message = f"{times[row]:.6g} s is outside the run, which is from 0 to {duration:.6g} s"
            hint = "make the scene's duration longer, or leave the row out"
            raise InputError(Problem(message, Place(place.file, columns.lines[row]), hint))
        return times

    def _deviation(self, unit: str) -> float:
        """The deviation that makes a residual of 1, in the quantity's unit."""
        given = self._given.get("deviation")
        if given is None:
            return 1.0
        if not agrees(unit, given.dimension):
            what = f"is in {unit}" if unit else "has no unit"
            self._reading.report(f"'deviation' {what}, like the matched quantity", self._at("deviation"))
        return float(given.number)


def _values(columns: CsvTable, number: int, unit: str, place: Place) -> Array:
    name, written = columns.headings[number]
    return np.asarray(columns.rows[:, number] * factor_of(name, written, unit, place))
