"""Writing a picture to a file."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from mbproj.errors import InputError, Problem
from mbproj.plot.style import styled

#: The formats, each with metadata that leaves out the date, so that the same results give the same file.
FORMATS = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}


@styled
def save(figure: Figure, path: Path) -> Path:
    """Write `figure` in the format that the suffix names. Raises InputError where the file cannot be written."""
    try:
        figure.savefig(path, metadata=FORMATS[path.suffix[1:]])
    except OSError as error:
        message = f"cannot write '{path}': {error.strerror or error}"
        raise InputError(Problem(message, hint="choose another directory with -o")) from error
    return path
