"""Writes the tables of the guide's pages again, from the definitions in the code.

    python scripts/write_reference.py           # writes
    python scripts/write_reference.py --check   # only says which pages are not as the code is; exit code 4

A table stands between `<!-- table: NAME -->` and `<!-- end -->`; NAME is a function of `scripts/reference`.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from reference import program_tables, scene_tables

from mbproj.guide.pages import pages

MARKED = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)


def written(text: str) -> str:
    """The text of a page with its tables made anew."""
    return MARKED.sub(lambda match: f"{match[1]}\n{tables(match[2])}\n{match[3]}", text)


def tables(name: str) -> str:
    module = scene_tables if hasattr(scene_tables, name) else program_tables
    found: str = getattr(module, name)()
    return found


def main() -> int:
    changed: list[Path] = []
    for page in pages().values():
        text = written(page.text)
        if text != page.text:
            changed.append(page.path)
            if "--check" not in sys.argv:
                page.path.write_text(text, encoding="utf-8")
    for path in changed:
        print(path)
    return 4 if changed and "--check" in sys.argv else 0


if __name__ == "__main__":
    sys.exit(main())
