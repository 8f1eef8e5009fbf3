"""Draws the README's first figure: the page of the Stewart platform, as a browser shows it.

    python scripts/draw_page.py           # writes mechanisms/pictures/stewart_platform_page.png

It needs the extra `test` and Chromium, as the tests of the page do.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from mbproj import read_scene
from mbproj.results.reader import open_results
from mbproj.show.page.pages import page_of
from mbproj.show.page.write import html
from tests.pages.browser import LAPTOP, MISSING, Opened, browser
from tests.pages.runs import recorded
from tests.support import ROOT

PICTURE = ROOT / "mechanisms" / "pictures" / "stewart_platform_page.png"
SERIES, TIME = "position violation", 0.175


def main() -> int:
    if MISSING:
        print(f"nothing was drawn: {MISSING}")
        return 4
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        path = recorded(read_scene(ROOT / "mechanisms" / "stewart_platform.yaml"), folder / "stewart.h5")
        with open_results(path) as results:
            page = page_of([results], ["run"])
        (folder / "stewart.html").write_text(html(page.title, page.data, page.packer), encoding="utf-8")
        with browser() as chromium:
            opened = Opened(chromium, folder / "stewart.html", LAPTOP)
            opened.page.locator("#series").select_option(SERIES)
            opened.at(TIME)
            opened.page.screenshot(path=str(PICTURE))
    print(PICTURE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
