"""The guide as web pages: complete, with its figures, and without a request to a network."""

from __future__ import annotations

import re
from importlib.util import find_spec

import pytest

from mbproj.guide.pages import ROOT, pages, write_site

pytestmark = pytest.mark.skipif(find_spec("furo") is None, reason="the extra `docs` is not installed")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    assert write_site(folder) == folder / "index.html"
    return folder


def test_every_page_is_written_and_linked_from_the_first(site):
    first = (site / "index.html").read_text(encoding="utf-8")
    for page in pages().values():
        assert (site / page.kind / f"{page.topic}.html").is_file()
        assert f'href="{page.kind}/{page.topic}.html"' in first


def test_figures_are_copied_and_shown(site):
    figures = {path.name for path in (ROOT / "figures").glob("*.png")}
    assert {path.name for path in (site / "_images").iterdir()} == figures
    shown = {name for path in site.glob("*/*.html") for name in re.findall(r"_images/([\w.-]+)", path.read_text())}
    assert shown == figures


def test_pages_work_from_the_disk(site):
    """Links to other sites are for the reader to follow; nothing is loaded from there."""
    for path in (*site.rglob("*.html"), *site.rglob("*.css")):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r'\bsrc="(https?:)?//', text), path
        assert not re.search(r'<link[^>]*rel="(stylesheet|preload|icon)"[^>]*href="(https?:)?//', text), path
        assert not re.search(r"(url\(|@import )[\"']?(https?:)?//", text), path


def test_options_keep_their_two_hyphens(site):
    text = (site / "reference" / "commands.html").read_text(encoding="utf-8")
    assert "With --certify: say" in text
