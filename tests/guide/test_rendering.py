"""The guide as web pages, and a page of it in a terminal."""

from __future__ import annotations

import re
from importlib.util import find_spec
from pathlib import Path

import pytest

from mbproj.guide.pages import ROOT, GuidePage, pages, rendered, write_site

# A page in a terminal: what Markdown means, in lines of at most the asked width.

TEXT = """# A page

A *short* paragraph with `some code` and **two words** in it, a [link](scene.md#bodies)
that goes on.

<!-- table: of nothing -->

## A list

- One item
  of two lines.
10. Another
```yaml
bodies: {a: {mass:  1}}
```
![A figure](../figures/a.png)

| name of a row | words |
|---|---|
| `a\\|b` | one two three four five six seven |
| longer_than_its_column_by_far | `x` |
"""
SHOWN = """A page
======

A short paragraph with some code and two
words in it, a link (mbproj help scene)
that goes on.

A list

- One item of two lines.
10. Another
  bodies: {a: {mass:  1}}
Figure (see mbproj help --html): A
figure

name of a row           words
----------------------  ---------------
a|b                     one two three
                        four five six
                        seven
longer_than_its_column  x
_by_far
"""


@pytest.fixture
def page(tmp_path) -> GuidePage:
    path: Path = tmp_path / "page.md"
    path.write_text(TEXT, encoding="utf-8")
    return GuidePage("page", "how_to", path)


def test_blocks_and_styles_have_their_form(page):
    assert rendered(page, 40) == SHOWN


def test_colours_change_no_letter_and_no_line(page):
    coloured = rendered(page, 40, colours=True)
    assert "\33[3mshort\33[0m" in coloured and "\33[36msome\33[0m \33[36mcode\33[0m" in coloured
    assert re.sub(r"\s+\n", "\n", re.sub("\33\\[\\d*m", "", coloured)) == re.sub(r"\s+\n", "\n", SHOWN)


# The guide as web pages: complete, with its figures, and without a request to a network.


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    assert write_site(folder) == folder / "index.html"
    return folder


@pytest.mark.skipif(find_spec("furo") is None, reason="the extra `docs` is not installed")
def test_every_page_is_written_and_linked_from_the_first(site):
    first = (site / "index.html").read_text(encoding="utf-8")
    for page in pages().values():
        assert (site / page.kind / f"{page.topic}.html").is_file()
        assert f'href="{page.kind}/{page.topic}.html"' in first


@pytest.mark.skipif(find_spec("furo") is None, reason="the extra `docs` is not installed")
def test_figures_are_copied_and_shown(site):
    figures = {path.name for path in (ROOT / "figures").glob("*.png")}
    assert {path.name for path in (site / "_images").iterdir()} == figures
    shown = {name for path in site.glob("*/*.html") for name in re.findall(r"_images/([\w.-]+)", path.read_text())}
    assert shown == figures


@pytest.mark.skipif(find_spec("furo") is None, reason="the extra `docs` is not installed")
def test_pages_work_from_the_disk(site):
    """Links to other sites are for the reader to follow; nothing is loaded from there."""
    for path in (*site.rglob("*.html"), *site.rglob("*.css")):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r'\bsrc="(https?:)?//', text), path
        assert not re.search(r'<link[^>]*rel="(stylesheet|preload|icon)"[^>]*href="(https?:)?//', text), path
        assert not re.search(r"(url\(|@import )[\"']?(https?:)?//", text), path


@pytest.mark.skipif(find_spec("furo") is None, reason="the extra `docs` is not installed")
def test_options_keep_their_two_hyphens(site):
    text = (site / "reference" / "commands.html").read_text(encoding="utf-8")
    assert "With --certify: say" in text
