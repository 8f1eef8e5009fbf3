"""three.js from the package trimesh: a classic script in the template of trimesh's own viewer."""

from __future__ import annotations

import re
import zipfile
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from mbproj.errors import InputError, Problem

HINT = "install it with: pip install 'mbproj[animate]'"
TEMPLATE = Path("resources", "templates", "viewer.zip")
#: The pattern of the script: its licence, and one line that defines the global name THREE. Loaders and the viewer
#: follow it.
SCRIPT = re.compile(r"(/\*\*\s*\* @license\s[^/]*Three\.js Authors[^/]*\*/\s*!function[^\n]*\}\)\);)\n")


def three_js() -> str:
    """The text of three.js with its licence. Raises InputError where trimesh is missing, or has no such script."""
    spec = find_spec("trimesh")
    place = None if spec is None or spec.origin is None else Path(spec.origin).parent / TEMPLATE
    if place is None or not place.is_file():
        raise InputError(Problem("a page needs three.js, which comes with trimesh", hint=HINT))
    return _script(place)


@cache
def _script(place: Path) -> str:
    with zipfile.ZipFile(place) as archive:
        template = archive.read(archive.namelist()[0]).decode("utf-8")
    script = SCRIPT.search(template)
    if script is None:
        raise InputError(Problem("this version of trimesh has no three.js in its viewer", hint=HINT))
    return script[1]
