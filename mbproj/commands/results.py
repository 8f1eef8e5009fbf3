"""`mbproj.open_results`: a run's results, with the pictures and the page of the commands."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, final

from mbproj.results import record
from mbproj.results.reader import opened

if TYPE_CHECKING:
    from mbproj.commands.pictures import Page, Plots


@final
class Results(record.Results):
    """A run's results: `results["bodies/position"]`, `results.time`, `results.marker("tip").position`, ...; and their
    pictures."""

    @property
    def plot(self) -> Plots:
        """The pictures by kind, as `results.plot.reactions("A")`."""
        from mbproj.commands.pictures import Plots

        return Plots(self)

    def animate(self) -> Page:
        """The page of `mbproj animate`, which a notebook shows."""
        from mbproj.commands.pictures import page

        return page(self)


def open_results(path: Path | str) -> Results:
    """Open the results at `path`, or those at `path`.part where a run was killed or still goes on (then `.partial`).

    Raises InputError where there is no file, or it is no results file, of another schema version, cut short or damaged.
    """
    return opened(path, Results)
