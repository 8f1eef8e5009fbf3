"""From a folder of reference data to scenes and tables: mechanisms/validation/*.yaml, tests/data/validation/*.csv.

    python scripts/convert_references.py FOLDER [NAME ...]

FOLDER holds the mechanisms as JSON, beside the tables that others computed for them; the cases, what of them is
compared, and how they are simulated stand in scripts/validation. Needed only to make the files anew.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from validation.case import Case
from validation.cases import CASES
from validation.reference_table import reference_table
from validation.scene_text import scene_text


def convert(case: Case, folder: Path) -> None:
    """Writes the table and the scene of a case."""
    source = folder / f"{case.source}.json"
    mechanism = json.loads(source.read_text(encoding="utf-8"))
    _write(case.table, reference_table(case, mechanism, source.parent))
    _write(case.scene, scene_text(case, mechanism))  # which takes what it expects from the table


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    print(path)


def main() -> None:
    """Converts the cases that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="FOLDER")
    parser.add_argument("names", nargs="*", metavar="NAME", help="cases; all where none is named")
    given = parser.parse_args()
    for name in given.names or CASES:
        convert(CASES[name], given.folder)


if __name__ == "__main__":
    main()
