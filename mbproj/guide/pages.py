"""The pages of the guide: which there are, what each is about, and where words stand in them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType

ROOT = Path(__file__).parent
#: The kinds of pages in the order of reading, each with what it is for.
KINDS: Mapping[str, str] = MappingProxyType(
    {
        "tutorial": "Tutorial: learn mbproj by using it",
        "how_to": "How to: one question, one answer",
        "reference": "Reference: look things up",
        "explanation": "Explanation: why things are as they are",
    }
)


@dataclass(frozen=True)
class Page:
    """A page: the topic by which it is asked for, its kind, its file."""

    topic: str
    kind: str
    path: Path

    @property
    def text(self) -> str:
        """The Markdown of the page."""
        return self.path.read_text(encoding="utf-8")

    @property
    def title(self) -> str:
        """The heading of the page."""
        return self.text.partition("\n")[0].removeprefix("# ")


@dataclass(frozen=True)
class Hit:
    """A section of a page in which all words stand that were looked for, and its first line with one of them."""

    page: Page
    section: str
    line: str


@cache
def pages() -> Mapping[str, Page]:
    """Every page by its topic: tutorials first, each kind in alphabetical order."""
    found = [Page(path.stem, kind, path) for kind in KINDS for path in sorted((ROOT / kind).glob("*.md"))]
    return MappingProxyType({page.topic: page for page in found})


def search(words: Sequence[str]) -> list[Hit]:
    """The sections that hold all words, as they are written or as parts of words; those whose heading has one first."""
    wanted = [word.casefold() for word in words]
    hits = []
    for page in pages().values():
        for section in re.split(r"^(?=#+ )", _without_fences(page.text), flags=re.MULTILINE):
            heading, _, body = section.partition("\n")
            if all(word in section.casefold() for word in wanted):
                line = next((line for line in body.splitlines() if any(word in line.casefold() for word in wanted)), "")
                hits.append(Hit(page, heading.lstrip("# "), line.strip()))

    def is_elsewhere(hit: Hit) -> bool:
        return not any(word in f"{hit.page.topic} {hit.section}".casefold() for word in wanted)

    return sorted(hits, key=is_elsewhere)


def _without_fences(text: str) -> str:
    """Comments in code are no headings."""
    lines, inside = [], False
    for line in text.splitlines():
        inside ^= line.startswith("```")
        lines.append(f" {line}" if inside else line)
    return "\n".join(lines)
