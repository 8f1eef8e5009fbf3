"""Runs all blocks of the guide's pages, those marked `slow` too, and the long examples of the commands' help; says
what does not hold. Exit code 4 then.

    python scripts/run_guide.py              # everything
    python scripts/run_guide.py TOPIC ...    # these pages alone
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from mbproj.guide.pages import pages
from tests.cli.commands import mbproj
from tests.cli.examples import examples, fill
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
    if not sys.argv[1:]:
        failed += failed_examples()
    return 4 if failed else 0


def failed_examples() -> int:
    """Runs the long examples of the commands' help; how many fail."""
    failed = 0
    for name, arguments in examples(long=True):
        if name == "watch":  # ends with Ctrl-C
            continue
        with tempfile.TemporaryDirectory() as folder:
            fill(Path(folder))
            done = mbproj(*arguments, folder=Path(folder))
        failed += done.returncode != 0
        line = f"mbproj {' '.join(arguments)}"
        print(f"{line}: holds" if done.returncode == 0 else f"{line}: {done.stdout}{done.stderr}")
    return failed


if __name__ == "__main__":
    sys.exit(main())
