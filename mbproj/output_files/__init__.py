"""Files that commands write: each is new and private until it is whole, and replaces nothing but its own kind.

Writers are imported when they are first used: every command escapes what it prints, few write tables.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbproj.registry import lazily

if TYPE_CHECKING:
    from mbproj.output_files.csv_table import write_csv
    from mbproj.output_files.kinds import (
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
    from mbproj.output_files.latex_table import write_latex
    from mbproj.output_files.replace import check_replaceable, check_rewritable, make_folder, replacing, write_text

__getattr__ = lazily(
    __name__,
    {
        "csv_table": "write_csv",
        "kinds": "DESIGN_DRAWN DESIGNED JUNIT LOOPS MODEL NOTEBOOK PAGE SCENE SCHEMA "
        "FileKind csv film hdf5 latex picture",
        "latex_table": "write_latex",
        "replace": "check_replaceable check_rewritable make_folder replacing write_text",
    },
)
