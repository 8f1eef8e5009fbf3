"""Kinds of files that mbproj writes, and tests that tell its own files from those of others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from mbproj.dataclass import dataclass
from mbproj.errors import InputError
from mbproj.sandbox import try_in_sandbox

#: The name by which mbproj marks its pictures in their metadata.
MARK = "mbproj"
#: A file's kind is recognised by this many bytes at either end: no file is read whole before it is replaced.
END = 65536
#: The first bytes of a picture and its mark, by format. PDF keeps its metadata at the end.
_PICTURES: Mapping[str, tuple[bytes, bytes]] = {
    "png": (b"\x89PNG\r\n\x1a\n", b"Software\0" + MARK.encode()),
    "pdf": (b"%PDF-", b"/Creator (" + MARK.encode() + b")"),
    "svg": (b"<?xml", b"<dc:title>" + MARK.encode() + b"</dc:title>"),
}
#: The byte at which the signature of a film begins, and the signature, by format.
_FILMS: Mapping[str, tuple[int, bytes]] = {"gif": (0, b"GIF89a"), "mp4": (4, b"ftyp")}


#: The first line of a table for LaTeX.
LATEX_MARK = "% table written by mbproj"
#: The first line of a table in Markdown.
MARKDOWN_MARK = "<!-- table written by mbproj -->"


@dataclass(frozen=True)
class FileKind:
    """A kind of file: `what` it is called, such as "a CSV table". `wrote` tells whether mbproj wrote the regular file
    at a path as one of this kind."""

    what: str
    wrote: Callable[[Path], bool]

    def is_ours(self, path: Path) -> bool:
        """Whether the file may be replaced by a new one of its kind. An empty file may, since nothing is lost."""
        try:
            return path.stat().st_size == 0 or self.wrote(path)
        except OSError:
            return False


def picture(file_format: str) -> FileKind:
    """A picture in one of the formats png, pdf and svg: its signature and our mark."""
    signature, mark = _PICTURES[file_format]

    def wrote(path: Path) -> bool:
        head, tail = _ends(path)
        return head.startswith(signature) and mark in head + tail

    return FileKind(f"a {file_format.upper()} picture", wrote)


def film(file_format: str) -> FileKind:
    """A film in one of the formats gif and mp4: its signature and our mark, a comment."""
    at, signature = _FILMS[file_format]

    def wrote(path: Path) -> bool:
        head, tail = _ends(path)
        return head[at:].startswith(signature) and MARK.encode() in head + tail

    return FileKind(f"a film in {file_format.upper()}", wrote)


def csv(headings: Sequence[str], last: Sequence[str] = ()) -> FileKind:
    """A CSV table: its first line begins with the first two of `headings`, units in brackets apart, and ends with
    `last`."""
    begin, end = _columns(",".join(headings[:2])), list(last)

    def wrote(path: Path) -> bool:
        first, _, _ = _ends(path)[0].partition(b"\n")
        columns = _columns(first.decode("utf-8", "replace"))
        return columns[: len(begin)] == begin and columns[len(columns) - len(end) :] == end

    return FileKind("a CSV table", wrote)


def latex() -> FileKind:
    """A table for LaTeX, recognised by its first line."""
    return FileKind("a table for LaTeX", _has_near_start(LATEX_MARK.encode()))


def markdown() -> FileKind:
    """A table in Markdown, recognised by its first line."""
    return FileKind("a table in Markdown", _has_near_start(MARKDOWN_MARK.encode()))


def hdf5(*file_formats: str) -> FileKind:
    """An HDF5 file whose attribute `format` is one of these."""

    def names_it(path: Path) -> bool:
        import h5py

        try:
            with h5py.File(path, "r") as file:
                return file.attrs.get("format") in file_formats
        except (OSError, RuntimeError, ValueError, KeyError, TypeError):  # h5py raises these for damaged files
            return False

    def wrote(path: Path) -> bool:
        if not _ends(path)[0].startswith(b"\x89HDF\r\n\x1a\n"):
            return False
        try:
            try_in_sandbox(lambda: names_it(path), path, "format")
        except InputError:
            return False
        return names_it(path)

    return FileKind("an HDF5 file", wrote)


def _has_near_start(text: bytes) -> Callable[[Path], bool]:
    """Return a test whether `text` stands in the first 1024 bytes of a file."""
    return lambda path: text in _ends(path)[0][:1024]


def _columns(line: str) -> list[str]:
    return [heading.strip().partition(" (")[0] for heading in line.split(",")]


def _ends(path: Path) -> tuple[bytes, bytes]:
    """The first and the last END bytes of a file."""
    with path.open("rb") as file:
        head = file.read(END)
        file.seek(max(0, path.stat().st_size - END))
        return head, file.read(END)


#: Kinds of text files, each recognised by a text that mbproj writes near the start.
PAGE = FileKind("a page", _has_near_start(b'<meta name="generator" content="mbproj">'))
JUNIT = FileKind("a JUnit report", _has_near_start(b'<testsuites name="mbproj '))
MODEL = FileKind("a model", _has_near_start(b"<!-- Written by mbproj "))
LOOPS = FileKind("a file of loops", _has_near_start(b"# Loops of "))
SCHEMA = FileKind("a schema", _has_near_start(b'"title": "mbproj '))
#: A scene is its author's, whoever wrote its first version: it is never ours to replace.
SCENE = FileKind("a scene to replace", lambda path: False)
DESIGNED = FileKind("a design that was found", _has_near_start(b"# Found by mbproj "))
DESIGN_DRAWN = FileKind("what pictures show of a design", _has_near_start(b'{"format": "mbproj design 1"'))
NOTEBOOK = FileKind("a notebook to replace", lambda path: False)
