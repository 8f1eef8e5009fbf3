"""Reads XML from others as a tree whose elements know their lines: no entities, no network, bounded size and depth."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import field
from pathlib import Path
from xml.parsers import expat

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem

#: The most bytes of a file, and the most elements and levels of its tree.
MOST_BYTES, MOST_ELEMENTS, MOST_DEPTH = 32_000_000, 500_000, 200

#: A comment. One without an end goes on to the end of the file, so that the search reads each byte once.
_COMMENT = re.compile(rb"<!--.*?(?:-->|\Z)", re.DOTALL)


@dataclass(eq=False)
class XmlElement:
    """An element with its attributes, the elements in it, its text, and its place."""

    tag: str
    attributes: dict[str, str]
    place: Place
    children: list[XmlElement] = field(default_factory=list)
    text: str = ""

    def get(self, name: str, default: str = "") -> str:
        """The value of an attribute, or `default`."""
        return self.attributes.get(name, default)

    def all(self, *tags: str) -> list[XmlElement]:
        """The children with one of these tags."""
        return [child for child in self.children if child.tag in tags]

    def first(self, tag: str) -> XmlElement | None:
        """The first child with this tag; None where there is none."""
        return next((child for child in self.children if child.tag == tag), None)

    def walk(self) -> Iterator[XmlElement]:
        """Yield this element and all below it, in the order of the text."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting.extend(reversed(element.children))


def read_text(path: Path, shown: str) -> bytes:
    """The bytes of a model's file. Raises InputError where it cannot be read or is too large."""
    try:
        size = path.stat().st_size
        if not path.is_file():
            raise InputError(Problem("is no file", Place(shown), "give the path of a model"))
        if size > MOST_BYTES:
            what = f"has {size / 1e6:.0f} MB, and at most {MOST_BYTES / 1e6:.0f} MB are read"
            raise InputError(Problem(f"the file {what}", Place(shown), "a model's meshes stand in files of their own"))
        return path.read_bytes()
    except OSError as error:
        hint = "look at its path and its permissions"
        raise InputError(Problem(f"cannot be read: {error.strerror}", Place(shown), hint)) from error


def parse(data: bytes, file: str) -> XmlElement:
    """The root element. Raises InputError with the line where the text is no XML, declares entities, or is too deep."""
    try:
        return _XmlParser(file).parse(data)
    except InputError:
        plain = _COMMENT.sub(_blank, data)  # XML forbids "--" in comments, but readers of robots' formats accept it
        if plain == data:
            raise
    return _XmlParser(file).parse(plain)


def _blank(comment: re.Match[bytes]) -> bytes:
    """The line ends of a comment, so that later lines keep their numbers."""
    return b"\n" * comment[0].count(b"\n")


class _XmlParser:
    def __init__(self, file: str) -> None:
        self._file, self._count = file, 0
        self._open: list[XmlElement] = []
        self._texts: list[list[str]] = []
        self._root: XmlElement | None = None
        self._expat = expat.ParserCreate()
        self._expat.buffer_text = True
        self._expat.StartElementHandler = self._start
        self._expat.EndElementHandler = self._end
        self._expat.CharacterDataHandler = self._characters
        self._expat.StartDoctypeDeclHandler = self._doctype
        self._expat.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)

    def parse(self, data: bytes) -> XmlElement:
        try:
            self._expat.Parse(data, True)
        except expat.ExpatError as error:
            place = Place(self._file, error.lineno, error.offset + 1)
            problem = Problem(f"no well-formed XML: {expat.ErrorString(error.code)}", place, "repair the file there")
            raise InputError(problem) from None
        except (ValueError, LookupError) as error:  # an encoding that Python does not know
            raise InputError(
                Problem(f"no XML that can be read: {error}", Place(self._file, 1), "save it as UTF-8")
            ) from None
        assert self._root is not None
        return self._root

    def _place(self) -> Place:
        return Place(self._file, self._expat.CurrentLineNumber)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if self._count > MOST_ELEMENTS or len(self._open) >= MOST_DEPTH:
            what = (
                f"more than {MOST_ELEMENTS} elements"
                if self._count > MOST_ELEMENTS
                else f"more than {MOST_DEPTH} levels"
            )
            raise InputError(Problem(f"the file has {what}", self._place(), "split the model"))
        element = XmlElement(tag, attributes, self._place())
        if self._open:
            self._open[-1].children.append(element)
        else:
            self._root = element
        self._open.append(element)
        self._texts.append([])

    def _end(self, tag: str) -> None:
        self._open.pop().text = "".join(self._texts.pop()).strip()

    def _characters(self, text: str) -> None:
        if self._texts:
            self._texts[-1].append(text)

    def _doctype(self, name: str, system: str | None, public: str | None, internal: bool) -> None:
        what = "a document type, which may hide entities, is not read"
        raise InputError(Problem(what, self._place(), "take out <!DOCTYPE ..>"))


# --- Files that a model names -----------------------------------------------------------------------------------------
# They must exist in the model's folder, and must not include each other in a circle.


#: The most levels of files that include others, and the most files that a model includes.
MOST_INCLUDES, MOST_FILES = 50, 1000


def is_missing(name: str, folder: Path, base: Path) -> bool:
    """Whether a file belongs into the folder, but does not exist."""
    try:
        file = (base / name).resolve()
        return file.is_relative_to(folder) and not file.exists()
    except (OSError, ValueError, RuntimeError):
        return False


def inside(name: str, place: Place, folder: Path, base: Path) -> Path:
    """The file that an element names from `base`. Raises InputError where it is missing or outside of `folder`."""
    try:
        file = (base / name).resolve()
        there = file.is_file()
    except (OSError, ValueError, RuntimeError):
        file, there = base, False
    if not file.is_relative_to(folder):
        hint = f"copy it to '{folder.name or folder}'"
        raise InputError(Problem(f"the file '{name}' is outside of the model's folder", place, hint))
    if not there:
        raise InputError(Problem(f"the file '{name}' is not there", place, "its path begins at the model's folder"))
    return file


@dataclass(eq=False)
class Includes:
    """Reads the files that a model includes, which together have the bounds of one file."""

    files: int = 0
    size: int = 0
    elements: int = 0

    def read(self, file: Path, place: Place, above: tuple[Path, ...], name: str) -> XmlElement:
        """The root of a file that the last of the files `above` includes by this name. Raises InputError at a circle,
        or where they are too many or too large."""
        if file in above:
            names = " -> ".join(each.name for each in (*above, file))
            raise InputError(Problem(f"the files include each other in a circle: {names}", place, "break it"))
        if len(above) > MOST_INCLUDES:
            raise InputError(Problem(f"files include each other more than {MOST_INCLUDES} deep", place, "join them"))
        if self.files < MOST_FILES and self.size <= MOST_BYTES and self.elements <= MOST_ELEMENTS:
            shown = str(Path(place.file).parent / name)
            data = read_text(file, shown)
            root = parse(data, shown)
            self.files, self.size = self.files + 1, self.size + len(data)
            self.elements += sum(1 for _ in root.walk())
            return root
        bounds = f"{MOST_FILES} files, {MOST_BYTES / 1e6:.0f} MB or {MOST_ELEMENTS} elements"
        raise InputError(Problem(f"the model includes more than {bounds}", place, "include fewer"))
