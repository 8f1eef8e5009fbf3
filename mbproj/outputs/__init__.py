"""Files that commands write: each is new and private until it is whole, and replaces nothing but its own kind.

Writers are imported when they are first used: every command escapes what it prints, few write tables.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbproj.outputs.csv_table import write_csv
    from mbproj.outputs.kinds import (
        DESIGN_DRAWN,
        DESIGNED,
        JUNIT,
        LOOPS,
        MODEL,
        NOTEBOOK,
        PAGE,
        SCENE,
        SCHEMA,
        FileKind,
        csv,
        film,
        hdf5,
        latex,
        picture,
    )
    from mbproj.outputs.latex_table import write_latex
    from mbproj.outputs.replace import check_replaceable, make_folder, replacing, write_text

_NAMES_IN = {
    "csv_table": ("write_csv",),
    "kinds": (
        "DESIGN_DRAWN",
        "DESIGNED",
        "JUNIT",
        "LOOPS",
        "MODEL",
        "NOTEBOOK",
        "PAGE",
        "SCENE",
        "SCHEMA",
        "FileKind",
        "csv",
        "film",
        "hdf5",
        "latex",
        "picture",
    ),
    "latex_table": ("write_latex",),
    "replace": ("check_replaceable", "make_folder", "replacing", "write_text"),
}

__all__ = [
    "DESIGNED",
    "DESIGN_DRAWN",
    "JUNIT",
    "LOOPS",
    "MODEL",
    "NOTEBOOK",
    "PAGE",
    "SCENE",
    "SCHEMA",
    "FileKind",
    "check_replaceable",
    "csv",
    "film",
    "hdf5",
    "latex",
    "make_folder",
    "picture",
    "replacing",
    "write_csv",
    "write_latex",
    "write_text",
]


def __getattr__(name: str) -> Any:
    home = next((module for module, names in _NAMES_IN.items() if name in names), None)
    if home is None:
        raise AttributeError(f"module 'mbproj.outputs' has no attribute '{name}'")
    return getattr(import_module(f"mbproj.outputs.{home}"), name)
