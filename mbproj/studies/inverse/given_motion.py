"""Given motions: columns of a CSV file, or the joint coordinates of a results file."""

from __future__ import annotations

import csv
import re
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.base.text import plain_number
from mbproj.model.system import System
from mbproj.results.record import Results
from mbproj.scene.expressions.units import unit_of
from mbproj.scene.fields.quantities import agrees

# --- Reading a CSV table of measurements ------------------------------------------------------------------------------
# Headings such as `time (s)`, then lines of numbers.


#: The largest CSV file that is read, bytes.
MOST_BYTES = 2**28
_HEADING = re.compile(r"\s*(?P<name>.*?)\s*(?:[(\[]\s*(?P<unit>[^)\]]*?)\s*[)\]])?\s*")
TIME_NAMES = ("time", "t")


@dataclass(frozen=True, eq=False)
class CsvTable:
    """A table with c columns. `headings` are pairs of a name and a unit ("" where there is none), from the line
    `heading_line`. `rows` (T, c) are the numbers as written; `lines` are their line numbers."""

    headings: tuple[tuple[str, str], ...]
    heading_line: int
    rows: Array
    lines: tuple[int, ...]

    def column(self, number: int, unit: str, place: Place) -> Array:
        """The numbers of a column in an SI unit, (T,). Raises InputError as `factor_of` does."""
        return np.asarray(self.rows[:, number] * factor_of(*self.headings[number], unit, place))


def read_columns(path: Path, asked: str) -> CsvTable:
    """Read the table in a file. `asked` is the option that named the file. Raises InputError with file and line where
    the file is no table, two columns have one name, or a cell is no finite number."""
    lines = _lines(path, asked)
    if not lines:
        raise InputError(Problem("it is empty", Place(str(path)), "give a line of names, then a line for each sample"))
    first, cells = lines[0]
    headings = tuple(_heading(cell) for cell in cells)
    names = [name for name, _ in headings]
    for name in names:
        if name and names.count(name) > 1:
            at = Place(str(path), first)
            raise InputError(Problem(f"two columns are of '{name}'", at, "leave one of them out, or rename it"))
    rows = np.array([_numbers(path, line, row, len(cells)) for line, row in lines[1:]], dtype=float)
    return CsvTable(headings, first, rows.reshape(-1, len(cells)), tuple(line for line, _ in lines[1:]))


def factor_of(name: str, unit: str, wanted: str, place: Place) -> float:
    """The factor from `unit` to the SI unit `wanted`; 1 where the column has no unit. Raises InputError where the unit
    is unknown, or of another quantity."""
    if not unit:
        return 1.0
    hint = f"give it in {wanted}" if wanted else "give it without a unit"
    try:
        unit_read = unit_of(unit)
    except ValueError as error:
        raise InputError(Problem(f"column '{name}': unknown unit '{unit}'", place, hint)) from error
    if not agrees(wanted, unit_read.dimension):
        what = f"is in {wanted}" if wanted else "has no unit"
        raise InputError(Problem(f"column '{name}' {what}, and '{unit}' is not", place, hint))
    return unit_read.multiply / unit_read.divide


def _heading(cell: str) -> tuple[str, str]:
    match = _HEADING.fullmatch(cell)
    return (match["name"], match["unit"] or "") if match else (cell.strip(), "")


def _lines(path: Path, asked: str) -> list[tuple[int, list[str]]]:
    """The lines that are neither empty nor comments, split into cells, with their numbers."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(Problem(f"it has more than {MOST_BYTES >> 20} MB", Place(str(path)), "thin it out"))
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        problem = Problem(f"cannot read '{path}': {error.strerror or error}", Place(asked))
        raise InputError(problem) from error
    except UnicodeDecodeError as error:
        raise InputError(Problem("it is not a text in UTF-8", Place(str(path)), "give a CSV file")) from error
    first = next((line for line in text.splitlines() if line.strip() and not line.startswith("#")), "")
    separator = next((mark for mark in (",", ";", "\t") if mark in first), ",")
    reader = csv.reader(text.splitlines(), delimiter=separator)
    try:
        rows = [(reader.line_num, cells) for cells in reader]
    except csv.Error as error:
        raise InputError(Problem(f"it is no CSV table: {error}", Place(str(path), reader.line_num))) from error
    return [(line, cells) for line, cells in rows if "".join(cells).strip() and not cells[0].startswith("#")]


def _numbers(path: Path, line: int, cells: list[str], count: int) -> list[float]:
    place = Place(str(path), line)
    if len(cells) != count:
        raise InputError(Problem(f"it has {len(cells)} cells, and the first line has {count}", place))
    try:
        numbers = [plain_number(cell) for cell in cells]
    except ValueError:
        wrong = next(cell for cell in cells if not _is_number(cell))
        raise InputError(Problem(f"'{wrong.strip()}' is not a number", place, "give every sample a number")) from None
    if not np.isfinite(numbers).all():
        raise InputError(Problem("a number is not finite", place, "leave this sample out"))
    return numbers


def _is_number(cell: str) -> bool:
    try:
        plain_number(cell)
    except ValueError:
        return False
    return True


# --- Given motions ----------------------------------------------------------------------------------------------------


#: The fewest samples for a spline of degree 5.
FEWEST = 6
_MARKER = re.compile(r"(?P<marker>.+)\.(?:position_)?(?P<axis>[xyz])")


@dataclass(frozen=True, eq=False)
class GivenMotion:
    """Samples at the times (T,) in s. `values` (T, c) are joint coordinates such as "crank.angle" and positions of
    markers such as "tip.x". `units` are rad or m."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    time: Array
    values: Array


def known_columns(system: System) -> dict[str, str]:
    """The names of all coordinates whose motion can be given, with their SI units."""
    names = system.names
    units = dict(zip(names.coordinates, names.coordinate_units, strict=True))
    return units | {f"{marker}.{axis}": "m" for marker in names.markers for axis in "xyz"}


def from_csv(system: System, path: Path) -> GivenMotion:
    """Read a motion from a CSV file. Its first line names the columns: `time (s), crank.angle (deg), tip.x (mm)`.
    Without a unit they are in s, rad and m. Raises InputError with file and line where a cell is no number, a column is
    unknown to the scene, or times do not ascend."""
    table = read_columns(path, "--given")
    place = Place(str(path), table.heading_line)
    columns = [_column(system, name, unit, place) for name, unit in table.headings]
    names = [name for name, _, _ in columns]
    for name in names:
        if names.count(name) > 1:
            raise InputError(Problem(f"two columns are of '{name}'", place, "leave one of them out"))
    if "time" not in names or len(names) < 2:
        raise InputError(Problem("it needs a column 'time (s)' and one of the motion", place, _columns_hint(system)))
    rows = table.rows * [factor for _, _, factor in columns]
    at = names.index("time")
    motion = GivenMotion(
        tuple(name for name in names if name != "time"),
        tuple(unit for name, unit, _ in columns if name != "time"),
        rows[:, at],
        np.delete(rows, at, axis=1),
    )
    return _checked(motion, path, table)


def from_results(system: System, results: Results) -> GivenMotion:
    """The motion of all joint coordinates that the results share with the scene. Raises InputError where there are
    none."""
    shared = [name for name in system.names.coordinates if name in results.names("coordinates")]
    if not shared:
        have = choose_from("", system.names.coordinates, "the scene has")
        raise InputError(Problem(f"'{results.path}' has no joint coordinate of the scene", hint=have))
    units = dict(zip(system.names.coordinates, system.names.coordinate_units, strict=True))
    last = np.append(np.diff(results.time) > 0.0, True)  # of two samples at an event take the one after it
    values = np.stack([results.coordinate(name).value for name in shared], axis=1)
    motion = GivenMotion(tuple(shared), tuple(units[name] for name in shared), results.time[last], values[last])
    return _checked(motion, results.path, None)


def _column(system: System, name: str, unit: str, place: Place) -> tuple[str, str, float]:
    """The name of a column's coordinate, its SI unit, and the factor from the column's unit to it."""
    known = known_columns(system)
    marker = _MARKER.fullmatch(name)
    if name not in known and marker and f"{marker['marker']}.{marker['axis']}" in known:
        name = f"{marker['marker']}.{marker['axis']}"
    if name.lower() in TIME_NAMES:
        return "time", "s", factor_of(name, unit, "s", place)
    if name not in known:
        message = f"column '{name}' is no joint coordinate and no component of a marker"
        raise InputError(Problem(message, place, f"leave it out, or rename it; {choose_from(name, known)}"))
    return name, known[name], factor_of(name, unit, known[name], place)


def _columns_hint(system: System) -> str:
    return choose_from("", known_columns(system), "columns may be")


def _checked(motion: GivenMotion, path: Path, columns: CsvTable | None) -> GivenMotion:
    if len(motion.time) < FEWEST:
        message = f"it has {len(motion.time)} samples, and a spline of degree 5 needs {FEWEST}"
        raise InputError(Problem(message, Place(str(path)), "give more samples"))
    wrong = np.flatnonzero(~(np.diff(motion.time) > 0.0))
    if len(wrong):
        place = Place(str(path), None if columns is None else columns.lines[int(wrong[0]) + 1])
        raise InputError(Problem("its time is not after the one before", place, "sort the samples by time"))
    return motion


# --- Splines of degree 5 through measured samples, whose second derivatives are smooth --------------------------------
# Only noise is smoothed, and the change is reported.
# A least-squares spline of FITPACK (Dierckx 1993) has the fewest knots for which the root mean square change is at
# most σ. Where σ is not given, it is estimated from divided differences of order 6, which vanish for polynomials of
# degree 5. Differences of noise do not become smaller with their order. Those of a smooth motion do, and such a
# motion is interpolated.


DEGREE = 5
#: The orders of differences that tell noise from a smooth motion. In a smooth motion the differences of the higher
#: order are smaller by at least this factor; in noise both are alike.
ORDERS, SMOOTH = (6, 8), 0.3
#: Noise below this part of the largest value is round-off, and is interpolated.
ROUND_OFF = 1e-13


@dataclass(frozen=True, eq=False)
class Smoothed:
    """A spline. `at` returns its value, first and second derivative at times (T,), (3, T). `noise` is σ, the largest
    root mean square change. `change` (T,) is the difference of the spline from each sample."""

    at: Callable[[Array], Array]
    noise: float
    change: Array


def smoothed(time: Array, values: Array, noise: float | None) -> Smoothed:
    """Fit a spline to samples (T,) with noise of this root mean square. None estimates the noise, 0 interpolates.
    Raises InputError where FITPACK finds no spline."""
    σ = _estimated(time, values) if noise is None else noise
    from scipy.interpolate import BSpline, make_interp_spline, splrep

    if σ == 0.0:
        spline = make_interp_spline(time, values, k=DEGREE)
    else:
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            knots, coefficients, degree = splrep(time, values, k=DEGREE, s=len(time) * σ**2)
        spline = BSpline(knots, coefficients, degree)
        if said and not np.sqrt(np.mean((spline(time) - values) ** 2)) <= 1.01 * σ:
            problem = Problem(f"no spline is as near as {σ:.3g} to the samples", Place("--smooth"), "give a larger one")
            raise InputError(problem)
    derivatives = [spline, spline.derivative(1), spline.derivative(2)]
    return Smoothed(lambda t: np.array([each(t) for each in derivatives]), σ, spline(time) - values)


def _estimated(time: Array, values: Array) -> float:
    """Estimate σ of the noise; 0 for samples of a smooth motion, or too few samples."""
    if len(time) <= 2 * ORDERS[1]:
        return 0.0
    lower, higher = (_difference_rms(time, values, order) for order in ORDERS)
    is_smooth = higher < SMOOTH * lower or lower <= ROUND_OFF * float(np.abs(values).max(initial=0.0))
    return 0.0 if is_smooth else lower


def _difference_rms(time: Array, values: Array, order: int) -> float:
    """The root mean square of divided differences of an order, weighted so that white noise of σ gives σ."""
    rows = np.lib.stride_tricks.sliding_window_view
    nodes, node_values = rows(time, order + 1), rows(values, order + 1)
    apart = nodes[:, :, None] - nodes[:, None, :]
    apart[:, np.arange(order + 1), np.arange(order + 1)] = 1.0
    span = (nodes[:, -1] - nodes[:, 0])[:, None, None]
    weights = 1.0 / np.prod(apart / span, axis=2)
    weights /= np.linalg.norm(weights, axis=1, keepdims=True)
    return float(np.sqrt(np.mean(np.sum(weights * node_values, axis=1) ** 2)))
