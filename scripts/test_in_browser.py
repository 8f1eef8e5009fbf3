"""Runs the tests of `mbproj animate` in a real browser, and fails where there is none: the suite only skips them.

python scripts/test_in_browser.py           # exit code 4 where a test fails or nothing could be tested
MBPROJ_BROWSER=/path/to/chromium python scripts/test_in_browser.py
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.pages.browser import MISSING, PATH
from tests.support import ROOT


def main() -> int:
    if MISSING:
        print(f"NOTHING WAS TESTED IN A BROWSER: {MISSING}")
        return 4
    print(f"testing in {PATH}")
    options = ["-n", "0", "-m", "full", "-p", "no:cacheprovider"]
    tests = [sys.executable, "-m", "pytest", *options, "tests/pages/test_browser.py"]
    return 4 if subprocess.run(tests, check=False, cwd=ROOT).returncode else 0


if __name__ == "__main__":
    sys.exit(main())
