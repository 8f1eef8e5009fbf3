"""The HTML of a page, from what it shows."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from typing import Any

from mbproj.pages.data.packing import Packer
from mbproj.pages.page.three_js import three_js
from mbproj.version import __version__

#: The page's own scripts in the order in which they need each other.
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


def html(title: str, data: Mapping[str, Any], packer: Packer) -> str:
    """The whole page. What comes from files is data in it, never markup: `<` is escaped wherever it stands."""
    pieces = {
        "title": escape(title),
        "style": _ours("style.css"),
        "made": escape(f"Made with mbproj {__version__}, drawn with three.js (MIT licence)."),
        "data": as_json(data),
        "motion": packer.text(),
        "three": three_js(),
        "script": "\n".join(_ours(f"{name}.js") for name in SCRIPTS),
    }
    text = _ours("page.html")
    before, *rest = text.split("{{")
    found = [before]
    for piece in rest:
        name, _, after = piece.partition("}}")
        found += [pieces[name], after]
    return "".join(found)


def as_json(data: Mapping[str, Any]) -> str:
    """JSON that no parser of HTML takes for its own: nothing in it can end the script that holds it."""
    text = json.dumps(data, ensure_ascii=True, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _ours(name: str) -> str:
    """A file of the page's own script and style."""
    return (files("mbproj.pages") / "browser" / name).read_text(encoding="utf-8")
