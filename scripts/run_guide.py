"""Runs all blocks of the guide's pages, those marked `slow` too, and says which page does not hold. Exit code 4 then.

    python scripts/run_guide.py [TOPIC ...]
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from mbproj.guide.pages import pages
from tests.guide.fences import run_page


def main() -> int:
    failed = 0
    for topic in sys.argv[1:] or pages():
        with tempfile.TemporaryDirectory() as folder:
            try:
                run_page(pages()[topic], Path(folder), slow=True)
            except AssertionError as error:
                failed += 1
                print(f"{topic}: {error}")
            else:
                print(f"{topic}: holds")
    return 4 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
