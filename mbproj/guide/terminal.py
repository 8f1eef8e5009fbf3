"""A page in a terminal: headings, lists and tables as text of at most 80 columns, in colours where there are some.

Importing this imports Rich.
"""

from __future__ import annotations

import re
from io import StringIO

from rich.console import Console, ConsoleOptions, RenderResult
from rich.markdown import Markdown, TableElement
from rich.table import Table

from mbproj.guide.pages import GuidePage

#: Wider lines are hard to read.
WIDTH = 80


class WholeTable(TableElement):
    """A table whose first column stays whole where it holds names. Words of other columns stay whole where they fit; a
    longer one is broken, not cut."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        for made in super().__rich_console__(console, options):
            if isinstance(made, Table):
                names, *others = made.columns
                length = max(len(str(cell)) for cell in (names.header, *names.cells))
                names.no_wrap = length <= options.max_width // 2
                left = options.max_width - 2 * len(made.columns) - (length if names.no_wrap else 0)
                for column in others:
                    cells = " ".join(str(cell) for cell in (column.header, *column.cells))
                    column.min_width = min(max(map(len, cells.split()), default=1), left // len(made.columns))
                    column.overflow = "fold"
            yield made


class TerminalPage(Markdown):
    """Markdown with such tables."""

    elements = Markdown.elements | {"table_open": WholeTable}


def rendered(page: GuidePage, width: int = WIDTH, *, colours: bool = False) -> str:
    """The page as text; with escape sequences for `colours`."""
    file = StringIO()
    console = Console(
        file=file, width=min(width, WIDTH), force_terminal=colours, no_color=not colours, legacy_windows=False
    )
    console.print(TerminalPage(_readable(page.text), code_theme="ansi_dark", hyperlinks=False))
    return "\n".join(line.rstrip() for line in file.getvalue().splitlines()) + "\n"


def _readable(text: str) -> str:
    """Links to other pages become the command that shows them, pictures their captions."""
    text = re.sub(r"!\[([^\]]*)\]\([^)]*\)", r"*Figure (see `mbproj help --html`): \1*", text)
    text = re.sub(r"\[([^\]]+)\]\((?:\.\./\w+/)?(\w+)\.md(?:#[\w-]*)?\)", r"\1 (`mbproj help \2`)", text)
    return re.sub(r"\[([^\]]+)\]\(#[\w-]*\)", r"\1", text)
