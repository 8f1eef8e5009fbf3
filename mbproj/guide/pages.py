"""The pages of the guide: which there are, what each is about, and where words stand in them."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from io import StringIO
from pathlib import Path
from types import MappingProxyType

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError
from mbproj.base.version import __version__

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


# --- The guide as static pages that work from the disk, made by Sphinx (the extra `docs`) -----------------------------


CONFIGURATION = f"""
project, release = "mbproj", {__version__!r}
extensions = ["myst_parser"]
myst_heading_anchors = 3
html_theme, html_title = "furo", "mbproj {__version__}"
html_show_sourcelink = html_show_copyright = html_copy_source = False
suppress_warnings = ["misc.highlighting_failure"]
smartquotes = False  # "--step" stays as it is typed
"""


def write_site(folder: Path) -> Path:
    """Writes the pages below a folder; the page to begin with. Raises InputError where the generator is not installed
    or a page is at fault."""
    try:
        from sphinx.cmd.build import build_main
    except ImportError as error:
        raise InputError("the pages are made by Sphinx, which is not installed: pip install 'mbproj[docs]'") from error
    with tempfile.TemporaryDirectory() as temporary:
        source = Path(temporary)
        for kind in [*KINDS, "figures"]:
            shutil.copytree(ROOT / kind, source / kind)
        (source / "conf.py").write_text(CONFIGURATION, encoding="utf-8")
        (source / "index.md").write_text(_contents(), encoding="utf-8")
        said = StringIO()
        with redirect_stdout(said), redirect_stderr(said):
            failed = build_main(["-q", "-W", "--keep-going", "-b", "html", str(source), str(folder)])
        if failed:
            raise InputError(f"the guide could not be written to {folder}:\n{said.getvalue().strip()}")
    return folder / "index.html"


def _contents() -> str:
    """The first page: a list of every page below the heading of its kind, and the same for the side bar."""
    parts = ["# mbproj", "Constrained spatial mechanisms, simulated with joints that stay closed."]
    for kind, title in KINDS.items():
        listed = [page for page in pages().values() if page.kind == kind]
        parts += [f"## {title}", "\n".join(f"- [{page.title}]({kind}/{page.topic}.md)" for page in listed)]
        side_bar = "\n".join(f"{kind}/{page.topic}" for page in listed)
        parts.append(f"```{{toctree}}\n:hidden:\n:caption: {title.partition(':')[0]}\n\n{side_bar}\n```")
    return "\n\n".join(parts) + "\n"


# --- A page in a terminal ---------------------------------------------------------------------------------------------
# Headings, lists and tables as text of at most 80 columns, in colours where there are some.


#: Wider lines are hard to read.
WIDTH = 80
#: The escape sequences that begin a style, by its mark in Markdown, and the one that ends all.
STYLES, PLAIN = {"`": "\33[36m", "**": "\33[1m", "*": "\33[3m"}, "\33[0m"
STYLED = re.compile(r"(`+)(.+?)\1|(?<![\w*])(\*\*|\*)(?=\S)(.+?)\3", re.DOTALL)
ITEM = re.compile(r"( *)(- |\* |\d+\. )(.*)")
#: The space between two columns of a table.
GAP = "  "


def rendered(page: GuidePage, width: int = WIDTH, *, colours: bool = False) -> str:
    """The page as text; with escape sequences for `colours`."""
    lines = _blocks(_readable(page.text).splitlines(), min(width, WIDTH), colours)
    return "\n".join(line.rstrip() for line in lines) + "\n"


def _readable(text: str) -> str:
    """Links to other pages become the command that shows them, pictures their captions. Comments go."""
    text = re.sub(r"<!--.*?-->\n\n?", "", text, flags=re.DOTALL)
    text = re.sub(r"!\[([^\]]*)\]\([^)]*\)", r"*Figure (see `mbproj help --html`): \1*", text)
    text = re.sub(r"\[([^\]]+)\]\((?:\.\./\w+/)?(\w+)\.md(?:#[\w-]*)?\)", r"\1 (`mbproj help \2`)", text)
    return re.sub(r"\[([^\]]+)\]\(#[\w-]*\)", r"\1", text)


def _blocks(source: Sequence[str], width: int, colours: bool) -> Iterator[str]:
    """Yield the lines of all blocks: a heading, a fence, a table, an item of a list or a paragraph."""
    at = 0
    while at < len(source):
        line, begin = source[at], at
        at += 1
        if line.startswith("```"):
            while source[at] != "```":
                at += 1
            yield from ("  " + code for code in source[begin + 1 : at])
            at += 1
        elif line.startswith("|"):
            while at < len(source) and source[at].startswith("|"):
                at += 1
            yield from _table(source[begin:at], width, colours)
        elif line.startswith("#"):
            level, _, heading = line.partition(" ")
            yield from _wrapped(f"**{heading}**", width, colours)
            yield from ["=" * min(len(heading), width)] if level == "#" else []
        elif line.strip():
            while at < len(source) and source[at].strip() and not re.match(r"\||#|```", source[at]):
                if ITEM.match(source[at]):
                    break
                at += 1
            item = ITEM.match(line)
            first = "" if item is None else item[1] + item[2]
            text = " ".join(source[begin:at]).strip() if item is None else " ".join([item[3], *source[begin + 1 : at]])
            yield from _wrapped(text, width, colours, first)
        else:
            yield ""


def _styled(text: str, colours: bool) -> str:
    """The text with styles in place of their marks. Each word has its own, so that a line may end between any two."""

    def style(found: re.Match[str]) -> str:
        mark, inner = (found[1][0], found[2]) if found[1] else (found[3], _styled(found[4], colours))
        return re.sub(r"\S+", lambda word: f"{STYLES[mark]}{word[0]}{PLAIN}", inner) if colours else inner

    return STYLED.sub(style, text)


def _length(text: str) -> int:
    """The number of columns that the text takes."""
    return len(re.sub("\33\\[\\d*m", "", text))


def _wrapped(text: str, width: int, colours: bool, first: str = "") -> list[str]:
    """The lines of a text. The first one begins with `first`, the others with as much space. A word that is longer than
    a line is broken."""
    lines, rest = [first], " " * len(first)
    for word in _styled(text, colours).split():
        if _length(lines[-1]) > len(rest):
            if _length(lines[-1]) + 1 + _length(word) <= width:
                lines[-1] += " " + word
                continue
            lines.append(rest)
        while _length(word) > width - len(rest):
            lines[-1:], word = [lines[-1] + word[: width - len(rest)], rest], word[width - len(rest) :]
        lines[-1] += word
    return lines


def _table(source: Sequence[str], width: int, colours: bool) -> Iterator[str]:
    """Yield the lines of a table. Words stay whole where they fit; the first column too, where it holds names."""
    rows = [re.split(r"(?<!\\)\|", line.strip().strip("|")) for line in source]
    cells = [[cell.strip().replace("\\|", "|") for cell in row] for at, row in enumerate(rows) if at != 1]
    plain = [[_styled(cell, False) for cell in column] for column in zip(*cells, strict=True)]
    wanted = [max(map(len, column)) for column in plain]
    room = width - len(GAP) * (len(wanted) - 1)
    least = [max((len(word) for cell in column for word in cell.split()), default=1) for column in plain]
    names, *others = least
    names = wanted[0] if wanted[0] <= width // 2 else min(names, room // len(wanted))
    least = [names, *(min(longest, (room - names) // max(len(others), 1)) for longest in others)]
    spare, more = max(0, room - sum(least)), sum(wanted) - sum(least)
    widths = [
        few + (most - few) * min(spare, more) // more if more else few for few, most in zip(least, wanted, strict=True)
    ]
    for at, row in enumerate(cells):
        columns = [
            _wrapped(cell if at else f"**{cell}**" * bool(cell), size, colours)
            for cell, size in zip(row, widths, strict=True)
        ]
        for line in range(max(map(len, columns))):
            parts = [column[line] if line < len(column) else "" for column in columns]
            yield GAP.join(part + " " * (size - _length(part)) for part, size in zip(parts, widths, strict=True))
        if at == 0:
            yield GAP.join("-" * size for size in widths)
