"""A page on which designs move beside what was wanted of them."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

from mbproj.pages.page.write import POLICY, as_json, filled, ours
from mbproj.version import __version__


def designs_page(title: str, data: Mapping[str, Any]) -> str:
    """The page with this data, as `mbproj.studies.synthesis.shown` has it."""
    pieces = {
        "title": escape(title),
        "policy": POLICY,
        "made": escape(f"Made with mbproj {__version__}. Orange: what is wanted."),
        "data": as_json(data),
        "script": ours("designs.js"),
    }
    return filled("designs.html", pieces)
