"""A real browser for the tests: Chromium without a window, its graphics in software, driven by playwright."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
#: Where the browser is; MBPROJ_BROWSER may say it.
PATH = os.environ.get("MBPROJ_BROWSER") or next(filter(None, map(shutil.which, NAMES)), None)
#: Why the tests cannot run here; empty where they can.
MISSING = "" if PATH and find_spec("playwright") else "needs playwright and Chromium (apt install chromium)"
OPTIONS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
LAPTOP, PHONE = {"width": 1280, "height": 720}, {"width": 390, "height": 844}
#: Enough to see pixels move, and quick to draw without graphics hardware.
SMALL = {"width": 720, "height": 480}


@contextmanager
def browser() -> Iterator[Any]:
    """The browser, until the block ends."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as player:
        opened = player.chromium.launch(executable_path=PATH, args=OPTIONS)
        try:
            yield opened
        finally:
            opened.close()


class Opened:
    """A page in a browser, with all that it asked for and complained of."""

    def __init__(self, browser: Any, path: Any, size: dict[str, int] = SMALL, touch: bool = False) -> None:
        self.context = browser.new_context(viewport=size, has_touch=touch, device_scale_factor=1)
        self.page = self.context.new_page()
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(path.as_uri())
        self.page.wait_for_function("() => window.mbproj")
        self.settle()

    def run(self, script: str, argument: Any = None) -> Any:
        """The value of a function of JavaScript; `page` is the page's own object."""
        return self.page.evaluate(f"(given) => {{ const page = window.mbproj; {script} }}", argument)

    def at(self, time: float) -> None:
        """Sets the time, and waits until it is drawn."""
        self.run("page.player.playing = false; page.player.set(given);", time)
        self.settle()

    def settle(self) -> None:
        """Waits until two pictures were drawn."""
        self.page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def pixels(self) -> bytes:
        """The scene's pixels, small: 160 by 90, three bytes each."""
        script = """
            const small = Object.assign(document.createElement("canvas"), { width: 160, height: 90 });
            const pen = small.getContext("2d");
            pen.drawImage(document.getElementById("scene"), 0, 0, 160, 90);
            const data = pen.getImageData(0, 0, 160, 90).data;
            return Array.from(data).filter((_, i) => i % 4 < 3);
        """
        return bytes(self.run(script))

    def close(self) -> None:
        """Closes the page."""
        self.context.close()
