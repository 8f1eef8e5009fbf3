"""A page in a terminal: headings, lists and tables as text of at most 80 columns, in colours where there are some."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from mbproj.guide.pages import GuidePage

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
