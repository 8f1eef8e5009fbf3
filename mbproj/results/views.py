"""`Table`: rows under headings, for a prompt, a notebook, pandas. `Tabled`: objects that are shown as such a table."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import choose_from, shortened
from mbproj.base.text import text_of
from mbproj.results.layout import ALL_NAMES, Dataset
from mbproj.results.report_schema.runs import RECORDED

# --- Results as tables of other libraries, which are optional ---------------------------------------------------------
# A DataFrame of pandas, a Dataset of xarray.


Names = Callable[[str], tuple[str, ...]]
Read = Callable[[str], npt.NDArray[Any]]
#: The kind of the names of columns, and the name of their dimension, by symbol.
AXES = {
    "n": ("bodies", "body"),
    "k": ("markers", "marker"),
    "nj": ("joints", "joint"),
    "nc": ("coordinates", "coordinate"),
    "nf": ("forces", "force"),
    "na": ("applied", "applied"),
    "nm": ("motions", "motion"),
    "ns": ("stops", "stop"),
    "nr": ("frictions", "friction"),
    "nx": ("states", "state"),
    "nu": ("signals", "signal"),
    "nt": ("tensions", "tension"),
    "nv": ("touching", "touching"),
}
#: The name of the dimension and the names of components, by the number of components.
COMPONENTS = {3: ("axis", ("x", "y", "z")), 4: ("euler_parameter", ("0", "1", "2", "3"))}


class TableColumn(NamedTuple):
    """A column of a table: its kind, name and quantity, its unit, its values (T,)."""

    kind: str
    name: str
    quantity: str
    unit: str
    values: npt.NDArray[Any]


def columns(datasets: Sequence[Dataset], names: Names, read: Read) -> Iterator[TableColumn]:
    """All columns but time, in the order of the layout."""
    for dataset in datasets:
        group, _, quantity = dataset.path.partition("/")
        if dataset.path == "time":
            continue
        if dataset.symbol is None:
            yield TableColumn(group, "", quantity, dataset.unit, read(dataset.path))
            continue
        kind, _ = AXES[dataset.symbol]
        for number, name in enumerate(names(kind)):
            values = read(dataset.path)[:, number]
            if values.ndim == 1:
                yield TableColumn(kind, name, quantity, dataset.unit, values)
                continue
            _, components = COMPONENTS[values.shape[1]]
            for component, part in zip(components, values.T, strict=True):
                yield TableColumn(kind, name, f"{quantity}_{component}", dataset.unit, part)


def to_pandas(datasets: Sequence[Dataset], names: Names, read: Read) -> Any:
    """The DataFrame that `Results.to_pandas` describes."""
    pandas = needed("pandas")
    listed = list(columns(datasets, names, read))
    header = pandas.MultiIndex.from_tuples([each[:3] for each in listed], names=["kind", "name", "quantity"])
    index = pandas.Index(read("time"), name="time")
    frame = pandas.DataFrame(np.column_stack([each.values for each in listed]), index, header)
    frame.attrs["units"] = {each[:3]: each.unit for each in listed}
    return frame


def to_xarray(datasets: Sequence[Dataset], names: Names, read: Read, about: Mapping[str, str]) -> Any:
    """The Dataset that `Results.to_xarray` describes."""
    xarray = needed("xarray")
    coordinates: dict[str, Any] = {"time": ("time", read("time"), {"units": "s"})}
    variables: dict[str, Any] = {}
    for dataset in datasets:
        if dataset.path == "time":
            continue
        dimensions = ["time"]
        for size in dataset.shape:
            kind, axis = AXES[size] if isinstance(size, str) else ("", COMPONENTS[size][0])
            labels = names(kind) if isinstance(size, str) else COMPONENTS[size][1]
            coordinates.setdefault(axis, (axis, np.array(labels, dtype=str)))
            dimensions.append(axis)
        attributes = {"units": dataset.unit, "long_name": dataset.description}
        attributes |= {"frame": dataset.frame} if dataset.frame else {}
        variables[dataset.path.replace("/", "_")] = (dimensions, read(dataset.path), attributes)
    for kind, entry in ALL_NAMES.items():
        units = names(kind) if kind.endswith("_units") else ()
        if units:
            axis = AXES[entry.symbol][1]
            coordinates[f"{axis}_unit"] = (axis, np.array(units, dtype=str))
    return xarray.Dataset(variables, coordinates, dict(about))


def needed(name: str) -> Any:
    """Import an optional library. Raises ImportError that says what to install where it is missing."""
    try:
        return import_module(name)
    except ImportError as error:
        raise ImportError(f"{name} is not installed, which makes this table: pip install 'mbproj[tables]'") from error


# --- The summary of results that a prompt or a notebook shows ---------------------------------------------------------
# The scene, the times, the recorded items.


KINDS = ("bodies", "joints", "markers", "forces", "motions", "stops", "frictions", "states", "signals")
#: The attributes whose numbers the summary shows.
NUMBERS = ("position_violation_max", "velocity_violation_max", "energy_drift")
#: The most names of a kind that are shown.
MOST_ITEMS = 6


def rows(
    status: str, time: Array, names: Callable[[str], tuple[str, ...]], attributes: Mapping[str, Any]
) -> list[tuple[str, str]]:
    """The lines of the summary, as (word, text)."""
    span = f"{len(time)} from {time[0]:g} to {time[-1]:g} s" if len(time) else "none"
    lines = [("status", status), ("samples", span)]
    lines += [(kind, shortened(names(kind), MOST_ITEMS)) for kind in KINDS if names(kind)]
    for fact in RECORDED:
        if fact.key in NUMBERS and fact.key in attributes:
            word = fact.key.removesuffix("_max").replace("_", " ")
            lines.append((word, f"{float(attributes[fact.key]):.2g} {fact.unit}"))
    return lines


def as_text(title: str, lines: Sequence[tuple[str, str]]) -> str:
    """The summary as lines of text."""
    return "\n".join([f"Results: {title or 'untitled'}", *(f"  {word:18} {what}" for word, what in lines)])


def as_html(title: str, lines: Sequence[tuple[str, str]]) -> str:
    """The summary as an HTML table; titles and names are escaped, since a file may come from anybody."""
    cells = (f"<tr><th>{escaped(word)}</th><td>{escaped(what)}</td></tr>" for word, what in lines)
    return f"<table><caption>{escaped(title)}</caption>{''.join(cells)}</table>"


def escaped(text: str) -> str:
    """The text with the special characters of HTML escaped."""
    from html import escape  # its table of entities takes 2 ms, which only a notebook needs

    return escape(text)


# --- `Table`: rows under headings, for a prompt, a notebook, pandas ---------------------------------------------------


#: The most rows that a prompt or a notebook shows.
SHOWN = 20


@dataclass(frozen=True)
class Table:
    """A table with `headings`, and `rows` that have None where a cell has no value."""

    headings: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]

    @classmethod
    def of(cls, rows: Iterable[Mapping[str, Any]], *headings: str) -> Table:
        """The table of rows that all have the same keys, which become its headings; without rows it has `headings`."""
        records = [dict(row) for row in rows]
        return Table(tuple(records[0]) if records else headings, tuple(tuple(row.values()) for row in records))

    @property
    def records(self) -> list[dict[str, Any]]:
        """The rows by heading."""
        return [dict(zip(self.headings, row, strict=True)) for row in self.rows]

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, heading: str) -> npt.NDArray[Any]:
        """The column with this heading, with or without its unit; NaN where a cell has no value. Raises KeyError with
        the nearest heading."""
        known = {name.partition(" (")[0]: k for k, name in enumerate(self.headings)}
        known.update({name: k for k, name in enumerate(self.headings)})
        if text_of(heading, "a heading") not in known:
            raise KeyError(f"the table has no column '{heading}'; {choose_from(heading, known)}")
        values = [row[known[heading]] for row in self.rows]
        if all(isinstance(value, bool) for value in values):
            return np.array(values, dtype=bool)
        is_text = any(isinstance(value, str) for value in values)
        return np.array(values, dtype=object) if is_text else np.array(values, dtype=float)

    def to_pandas(self) -> Any:
        """The table as a DataFrame. Raises ImportError where pandas is not installed."""
        return needed("pandas").DataFrame(list(self.rows), columns=list(self.headings))

    def __repr__(self) -> str:
        lines = [self.headings, *(tuple(map(_cell_text, row)) for row in self.rows[:SHOWN])]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        text = ["  ".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() for row in lines]
        return "\n".join([*text, *([] if self._rows_left == 0 else [f"... and {self._rows_left} more"])])

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escaped(name)}</th>" for name in self.headings)
        body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in self.rows[:SHOWN])
        more = f"<caption>the first {SHOWN} of {len(self.rows)} rows</caption>" if self._rows_left else ""
        return f"<table>{more}<tr>{head}</tr>{body}</table>"

    @property
    def _rows_left(self) -> int:
        """The number of rows that are not shown."""
        return max(len(self.rows) - SHOWN, 0)


class Tabled(ABC):
    """An object with a table and a line that describes it: a prompt and a notebook show these two."""

    @property
    @abstractmethod
    def table(self) -> Table:
        """The table of the object."""

    @property
    @abstractmethod
    def line(self) -> str:
        """The description of the object, in one line."""

    def to_pandas(self) -> Any:
        """The table as a DataFrame. Raises ImportError where pandas is not installed."""
        return self.table.to_pandas()

    def __repr__(self) -> str:
        return f"{type(self).__name__}: {self.line}\n{self.table!r}"

    def _repr_html_(self) -> str:
        return f"<p>{escaped(self.line)}</p>{self.table._repr_html_()}"


def _cell_text(value: object) -> str:
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)


def _cell(value: object) -> str:
    return f"<td>{escaped(_cell_text(value))}</td>"
