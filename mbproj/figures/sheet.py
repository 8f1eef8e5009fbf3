"""Matplotlib's style sheets, read with errors that give the place. Matplotlib's own reader only warns of a wrong
key."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib import style

from mbproj.errors import InputError, Place, Problem, choose_from, did_you_mean

#: A comment begins at a # outside quotes.
COMMENT = re.compile(r'^((?:[^"#]|"[^"]*")*)#.*$')
#: Keys that a sheet may not set, and the reason.
REFUSED = {
    "text.usetex": "names of a scene are no LaTeX; --font sets the document's font, in mathematics too",
    "savefig.format": "--format says it",
}
#: The beginnings of keys that concern programs that show pictures, not the look.
FOREIGN = ("backend", "interactive", "toolbar", "webagg", "tk.", "macosx", "keymap", "savefig.directory", "timezone")
#: The largest size of a sheet, bytes.
MOST_BYTES = 100_000


def read_sheet(sheet: str | Path) -> Iterator[tuple[str, Any]]:
    """Yield the settings of a sheet: a file, or one of Matplotlib's own by its name. Raises InputError with all
    problems."""
    path = Path(sheet)
    if not path.suffix and not path.is_file():
        names = [name for name in style.library if not name.startswith("_")]
        if str(sheet) not in names:
            raise InputError(Problem(f"there is no style '{sheet}'", hint=choose_from(str(sheet), names)))
        yield from _without_size(style.library[str(sheet)])
        return
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(Problem(f"it is larger than {MOST_BYTES} bytes", Place(str(path)), "it is no style sheet"))
        lines = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise InputError(Problem("it is no text", Place(str(path)), "give a style sheet of Matplotlib")) from error
    problems: list[Problem] = []
    pairs = [pair for number, line in enumerate(lines, 1) for pair in _pair(line, Place(str(path), number), problems)]
    if problems:
        raise InputError(problems)
    yield from pairs


def _without_size(settings: Any) -> Iterator[tuple[str, Any]]:
    """The settings without the figure's size, which in Matplotlib's own styles is for screens."""
    yield from ((key, value) for key, value in settings.items() if key != "figure.figsize")


def _pair(line: str, place: Place, problems: list[Problem]) -> Iterator[tuple[str, Any]]:
    text = COMMENT.sub(r"\1", line).strip()
    if not text:
        return
    key, colon, value = (part.strip() for part in text.partition(":"))
    if not colon:
        problems.append(Problem(f"'{text}' is not KEY: VALUE", place))
    elif key in REFUSED or key.startswith(FOREIGN):
        problems.append(Problem(f"a sheet cannot set '{key}'", place, REFUSED.get(key, "leave it out")))
    elif key not in mpl.rcParams:
        alike = [known for known in mpl.rcParams if known[0] == key[0]]
        problems.append(
            Problem(f"unknown key '{key}'", place, did_you_mean(key, alike) or "keys are those of a matplotlibrc file")
        )
    else:
        try:
            yield key, mpl.rcParams.validate[key](value.strip('"') if value.startswith('"') else value)
        except ValueError as error:
            problems.append(Problem(f"'{key}': {error}", place))
