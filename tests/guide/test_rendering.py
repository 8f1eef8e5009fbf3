"""A page in a terminal: what Markdown means, in lines of at most the asked width."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from mbproj.guide.pages import GuidePage
from mbproj.guide.terminal import rendered

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
