"""The pages of the guide: which there are, what each is about, and where words stand in them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from types import MappingProxyType

from mbproj.dataclass import dataclass

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
class GuidePage:
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
    """A section of a page with words that were looked for: how many of them, and its first line with one."""

    page: GuidePage
    section: str
    line: str
    words: int


@cache
def pages() -> Mapping[str, GuidePage]:
    """Every page by its topic: tutorials first, each kind in alphabetical order."""
    listed = [GuidePage(path.stem, kind, path) for kind in KINDS for path in sorted((ROOT / kind).glob("*.md"))]
    return MappingProxyType({page.topic: page for page in listed})


def page_of(words: Sequence[str]) -> GuidePage | None:
    """The page that the words are the topic of: "getting started", "joints", "reference/joints", "joints/reference"."""
    parts = "_".join(words).replace("-", "_").removesuffix(".md").split("/")
    topics = [part for part in parts if part not in KINDS]
    page = pages().get("_".join(topics))
    return page if page is not None and set(parts) <= {page.topic, page.kind} else None


def search(words: Sequence[str]) -> list[Hit]:
    """The sections that hold all words, as they are written or as parts of words, or else those that hold most of them.
    First come those with the words in their heading or topic. Pages that say how come before those that say why, and
    sections in which the words stand more often before the others."""
    wanted = {word.casefold() for word in words}
    hits: list[tuple[tuple[int, bool, int], Hit]] = []
    for page in pages().values():
        for section in re.split(r"^(?=#+ )", _without_fences(page.text), flags=re.MULTILINE):
            text = section.casefold()
            present = {word for word in wanted if word in text or word in page.topic}
            if not present:
                continue
            heading, _, body = section.partition("\n")
            lines = (line for line in body.splitlines() if any(word in line.casefold() for word in present))
            hit = Hit(page, heading.lstrip("# "), _plain(next(lines, "")), len(present))
            named = sum(word in f"{page.topic} {hit.section}".casefold() for word in present)
            hits.append(((named, page.kind != "explanation", sum(map(text.count, present))), hit))
    most = max((hit.words for _, hit in hits), default=0)
    best = sorted((each for each in hits if each[1].words == most), key=lambda each: each[0], reverse=True)
    return [hit for _, hit in best]


def _plain(line: str) -> str:
    """A line of Markdown as text: the cells of a table apart, no marks of code and emphasis, no targets of links."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)?", r"\1", line.replace("\\|", "/"))
    return re.sub(r" *\| *", "  ", re.sub(r"[`*]", "", text)).strip()


def _without_fences(text: str) -> str:
    """Comments in code are no headings."""
    lines, inside = [], False
    for line in text.splitlines():
        inside ^= line.startswith("```")
        lines.append(f" {line}" if inside else line)
    return "\n".join(lines)
