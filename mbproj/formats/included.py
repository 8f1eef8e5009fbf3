"""Files that a model names: they must exist in the model's folder, and must not include each other in a circle."""

from __future__ import annotations

from pathlib import Path

from mbproj.errors import InputError, Place, Problem
from mbproj.formats.xml import XmlElement, parse, read_text

#: The most levels of files that include others.
MOST_INCLUDES = 50


def is_missing(name: str, folder: Path, base: Path) -> bool:
    """Whether a file belongs into the folder, but does not exist."""
    try:
        file = (base / name).resolve()
        return file.is_relative_to(folder) and not file.exists()
    except (OSError, ValueError, RuntimeError):
        return False


def inside(name: str, place: Place, folder: Path, base: Path) -> Path:
    """The file that an element names from `base`. Raises InputError where it is missing or outside of `folder`."""
    try:
        file = (base / name).resolve()
        there = file.is_file()
    except (OSError, ValueError, RuntimeError):
        file, there = base, False
    if not file.is_relative_to(folder):
        hint = f"copy it to '{folder.name or folder}'"
        raise InputError(Problem(f"the file '{name}' is outside of the model's folder", place, hint))
    if not there:
        raise InputError(Problem(f"the file '{name}' is not there", place, "its path begins at the model's folder"))
    return file


def include(file: Path, place: Place, above: tuple[Path, ...], shown: str) -> XmlElement:
    """The root of a file that the files `above` include. Raises InputError at a circle, or where they are too many."""
    if file in above:
        names = " -> ".join(each.name for each in (*above, file))
        raise InputError(Problem(f"the files include each other in a circle: {names}", place, "break it"))
    if len(above) > MOST_INCLUDES:
        raise InputError(Problem(f"files include each other more than {MOST_INCLUDES} deep", place, "join them"))
    return parse(read_text(file, shown), shown)
