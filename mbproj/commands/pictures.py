"""`results.plot` and `results.animate`: the pictures and the page of the commands, which a notebook shows."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from html import escape
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from mbproj.base.errors import InputError, Problem, choose_from
from mbproj.results.output_files import PAGE, check_replaceable, write_text
from mbproj.results.record import ACTING, Results
from mbproj.show.figures.kinds import KINDS, draw, why_not
from mbproj.show.figures.style import save

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: The height of a page in a notebook, in pixels.
HEIGHT = 560


@final
class Picture:
    """A picture, which a notebook shows. `figure` and `axes` are Matplotlib's; `save` writes a file."""

    def __init__(self, figure: Figure) -> None:
        self.figure = figure

    @property
    def axes(self) -> Sequence[Axes]:
        """The panels, from top to bottom."""
        return tuple(self.figure.axes)

    def save(self, path: str | Path, *, force: bool = False) -> Path:
        """Writes the picture in the format of the name's ending. Raises InputError where a file of another kind exists,
        unless `force`."""
        return save(self.figure, Path(path), force=force)

    def __repr__(self) -> str:
        panels = [axes.get_ylabel() for axes in self.axes if axes.get_visible() and axes.get_ylabel()]
        return f"Picture: {'; '.join(panels)}\n.save(path) writes it, .figure and .axes are Matplotlib's"

    def _repr_png_(self) -> bytes:
        image = BytesIO()
        self.figure.savefig(image, format="png", dpi=100)
        return image.getvalue()


@final
class Plots:
    """The pictures of one run, by kind: `plot.energy()`, `plot.reactions("A", "B")`, `plot.markers("tip")`. Names are
    those of joints, markers or forces, by default all. `dir(plot)` lists the kinds."""

    def __init__(self, results: Results) -> None:
        self._results = results

    def __dir__(self) -> list[str]:
        return list(KINDS)

    def __call__(self, kind: str = "", *names: str, **window: float | None) -> Picture:
        """Draws the picture of a kind: `plot("energy")` is `plot.energy()`."""
        if kind not in KINDS:
            what = f"there is no picture '{kind}'," if kind else "which picture?"
            raise InputError(Problem(f"{what} plot.energy() is one", hint=choose_from(kind, KINDS)))
        return self._draw(kind, *names, **window)

    def __getattr__(self, kind: str) -> Any:
        if kind not in KINDS:
            raise AttributeError(f"there is no picture '{kind}'; {choose_from(kind, KINDS)}")
        return partial(self._draw, kind)

    def _draw(self, kind: str, *names: str, start: float | None = None, stop: float | None = None) -> Picture:
        """Draw the picture of a kind for the named joints, markers or forces, between two times in s. Raises InputError
        where the kind does not apply to the run, or a name is unknown."""
        needs = KINDS[kind].needs
        window = {key: value for key, value in {"start": start, "stop": stop}.items() if value is not None}
        chosen: dict[str, Any] = dict(window)
        if names:
            words = dict.fromkeys(ACTING, "acting") | {
                "markers": "markers",
                "joints": "joints",
                "coordinates": "joints",
            }
            if needs not in words:
                raise InputError(Problem(f"the picture '{kind}' takes no names", hint="leave them out"))
            chosen[words[needs]] = names
        results = self._results.select(**chosen)
        reason = why_not(kind, [results]) or (None if len(results.time) else "there is no sample in this window")
        if reason is not None:
            raise InputError(Problem(f"no picture '{kind}': {reason}"))
        return Picture(draw(kind, [results], [results.title or "run"]))


@final
class Page:
    """A page on which a mechanism moves. `html` is its whole text. A notebook shows it in a frame of its own."""

    def __init__(self, html: str) -> None:
        self.html = html

    def __repr__(self) -> str:
        return f"Page of {len(self.html) / 1e6:.1f} MB\n.save(path) writes it; a notebook shows it"

    def save(self, path: str | Path, *, force: bool = False) -> Path:
        """Writes the page, which any browser opens offline."""
        check_replaceable(Path(path), PAGE, force=force)
        write_text(Path(path), self.html, PAGE, force=force)
        return Path(path)

    def _repr_html_(self) -> str:
        source = escape(self.html, quote=True)
        return f'<iframe srcdoc="{source}" style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'


def page(results: Results) -> Page:
    """The page of a run. Raises InputError where the extra `animate` is not installed."""
    from mbproj.show.page.pages import page_of
    from mbproj.show.page.write import html

    built = page_of([results], [results.title or "run"], False, None)
    return Page(html(built.title, built.data, built.packer))
