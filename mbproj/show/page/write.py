"""The HTML of a page, made from its data. A page is one file: it loads nothing, so that it opens anywhere."""

from __future__ import annotations

import json
import re
import zipfile
from collections.abc import Mapping
from functools import cache
from html import escape
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from mbproj.base.errors import InputError, Problem
from mbproj.base.version import __version__
from mbproj.show.page.series import Packer

#: The page's own scripts, in the order in which they need each other.
SCRIPTS = (
    "unpack",
    "run",
    "modes",
    "solids",
    "figure",
    "stretched",
    "trails",
    "colours",
    "camera",
    "pointer",
    "player",
    "chart",
    "timeline",
    "corner",
    "panel",
    "overlay",
    "controls",
    "main",
)
#: The script of a page that `mbproj watch` serves.
WATCH = "watch"
#: The policy of a page: it may load nothing. A served page may connect to its server.
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
SERVED = f"{POLICY}; connect-src 'self'"


def html(title: str, data: Mapping[str, Any], packer: Packer, watched: int | None = None) -> str:
    """The whole page that moves, with the arrays of `packer`. `watched` is the number of its version, where `mbproj
    watch` serves it. Contents of files are data in the page, never markup: `<` is escaped everywhere."""
    scripts = SCRIPTS if watched is None else (*SCRIPTS[:-1], WATCH, SCRIPTS[-1])
    pieces = {
        "title": escape(title),
        "policy": POLICY if watched is None else SERVED,
        "style": page_source("style.css"),
        "made": escape(f"Made with mbproj {__version__}, drawn with three.js (MIT licence)."),
        "data": as_json(data if watched is None else {**data, "watched": watched}),
        "motion": packer.text(),
        "three": three_js(),
        "script": "\n".join(page_source(f"{name}.js") for name in scripts),
    }
    return filled("page.html", pieces)


def waiting(title: str) -> str:
    """The page that `mbproj watch` serves while the scene gives no page."""
    pieces = {
        "title": escape(title),
        "policy": SERVED,
        "style": page_source("style.css"),
        "script": page_source(f"{WATCH}.js"),
    }
    return filled("waiting.html", pieces)


def designs_page(title: str, data: Mapping[str, Any]) -> str:
    """The page of designs with this data, which `mbproj.studies.synthesis.synthesise` makes."""
    pieces = {
        "title": escape(title),
        "policy": POLICY,
        "made": escape(f"Made with mbproj {__version__}. Orange: what is wanted."),
        "data": as_json(data),
        "script": page_source("designs.js"),
    }
    return filled("designs.html", pieces)


def filled(name: str, pieces: Mapping[str, str]) -> str:
    """The template of this name with its pieces filled in, at `{{key}}` each."""
    text = page_source(name)
    before, *rest = text.split("{{")
    texts = [before]
    for piece in rest:
        key, _, after = piece.partition("}}")
        texts += [pieces[key], after]
    return "".join(texts)


def as_json(data: Mapping[str, Any]) -> str:
    """JSON that can stand in a script of an HTML page: nothing in it can end the script."""
    text = json.dumps(data, ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def page_source(name: str) -> str:
    """The text of a file of the page's own scripts and style."""
    return (files("mbproj.show.page") / "browser" / name).read_text(encoding="utf-8")


# --- three.js from the package trimesh --------------------------------------------------------------------------------
# A classic script in the template of trimesh's own viewer: no package of JavaScript has to be installed.

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
