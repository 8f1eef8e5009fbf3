"""What the commands that run many simulations share: tables, files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mbproj import outputs
from mbproj.outputs import check_replaceable, make_folder

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.results.views.table import Table

OTHER_FOLDER = "choose another folder with -o"


def number(value: float, form: str = ".1e") -> str:
    """A number of a table; a dash where there is none."""
    return "-" if value != value else format(value, form)


def milliseconds(seconds: float) -> str:
    """Three digits of a time in ms; a dash where there is none."""
    value = 1e3 * seconds
    return "-" if not seconds < float("inf") else f"{value:.3g}" if value < 1000.0 else f"{value:.0f}"


class StudyFiles:
    """The table DIR/<stem>.csv and the figure DIR/<stem>.<ending> of a study; `first` are the first columns of the
    table. Raises InputError before the work begins if they cannot be written."""

    def __init__(self, folder: Path, stem: str, ending: str, first: tuple[str, str], force: bool) -> None:
        self.stem = make_folder(folder, OTHER_FOLDER) / stem
        self.force = force
        self._figure = Path(f"{self.stem}.{ending}")
        self._table = Path(f"{self.stem}.csv")
        check_replaceable(self._table, outputs.csv(first), force=force, hint=OTHER_FOLDER)
        check_replaceable(self._figure, outputs.picture(ending), force=force, hint=OTHER_FOLDER)

    def table(self, rows: Table) -> Path:
        """Writes the rows."""
        return outputs.write_csv(self._table, rows.headings, rows.rows, force=self.force, hint=OTHER_FOLDER)

    def figure(self, drawn: Figure) -> Path:
        """Writes the figure."""
        from mbproj.figures.save import save

        return save(drawn, self._figure, force=self.force)
