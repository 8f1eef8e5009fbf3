"""A page in a terminal: headings, lists and tables as text of at most 80 columns, in colours where there are some."""

from __future__ import annotations

import re
from io import StringIO

from mbproj.guide.pages import Page

#: Wider lines are hard to read.
WIDTH = 80


def rendered(page: Page, width: int = WIDTH, *, colours: bool = False) -> str:
    """The page as text; with escape sequences for `colours`."""
    from rich.console import Console
    from rich.markdown import Markdown

    file = StringIO()
    console = Console(
        file=file, width=min(width, WIDTH), force_terminal=colours, no_color=not colours, legacy_windows=False
    )
    console.print(Markdown(_readable(page.text), code_theme="ansi_dark", hyperlinks=False))
    return "\n".join(line.rstrip() for line in file.getvalue().splitlines()) + "\n"


def _readable(text: str) -> str:
    """Links to other pages become the command that shows them, pictures their captions."""
    text = re.sub(r"!\[([^\]]*)\]\([^)]*\)", r"*Figure (see `mbproj help --html`): \1*", text)
    text = re.sub(r"\[([^\]]+)\]\((?:\.\./\w+/)?(\w+)\.md(?:#[\w-]*)?\)", r"\1 (`mbproj help \2`)", text)
    return re.sub(r"\[([^\]]+)\]\(#[\w-]*\)", r"\1", text)
