"""`Table`: rows under headings, for a prompt, a notebook, pandas. `Tabled`: objects that are shown as such a table."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.dataclass import dataclass
from mbproj.errors import choose_from
from mbproj.results.views.frames import needed
from mbproj.results.views.summary_text import escaped

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
        if heading not in known:
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
