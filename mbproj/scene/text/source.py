"""A scene file's bytes -> its text and lines, or the one reason why it cannot be read."""

from __future__ import annotations

import io
import os
import re
import stat
from pathlib import Path

from mbproj.errors import InputError, Place, Problem, did_you_mean

MAX_BYTES = 10_000_000
#: The characters that YAML does not allow in a file.
_UNPRINTABLE = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
#: The line ends of YAML.
_LINE_BREAK = re.compile("\r\n|[\r\n\x85\u2028\u2029]")
#: The formats of models, by the tag with which they begin.
_MODELS = {b"<mujoco": "MJCF", b"<robot": "URDF", b"<sdf": "SDF"}


def read_text(path: Path) -> str:
    """The text of the file, without byte order mark. Raises InputError with one problem."""
    place = Place(str(path))
    try:
        data = _bytes_of(path)
    except FileNotFoundError:
        raise InputError(Problem("there is no such file", place, _similar_file(path))) from None
    except IsADirectoryError:
        raise InputError(Problem("this is a directory, not a scene file", place)) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(Problem(f"cannot be read: {reason}", place)) from None
    if len(data) > MAX_BYTES:
        raise InputError(Problem(f"the file is larger than {MAX_BYTES // 1_000_000} MB", place))
    return _decode(data, place)


def _bytes_of(path: Path) -> bytes:
    """The bytes of the file or of a pipe (`<(...)` of a shell), at most one more than allowed.

    Raises InputError where nobody writes into a pipe, which mbproj would wait for without end.
    """
    opened = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    with os.fdopen(opened, "rb", buffering=0) as file, io.BufferedReader(file) as buffered:
        if hasattr(os, "set_blocking") and stat.S_ISFIFO(os.fstat(file.fileno()).st_mode):
            first = file.read(1)
            if first == b"":
                raise InputError(Problem("this is a pipe that nobody writes into", Place(str(path))))
            os.set_blocking(file.fileno(), True)
            return (first or b"") + buffered.read(MAX_BYTES)
        return buffered.read(MAX_BYTES + 1)


def lines_of(text: str, file: str) -> list[str]:
    """The lines of the text as YAML counts them. Raises InputError at a character that YAML does not allow."""
    lines = _LINE_BREAK.split(text)
    if _UNPRINTABLE.search(text) is not None:
        number, line = next((number, line) for number, line in enumerate(lines, 1) if _UNPRINTABLE.search(line))
        match = _UNPRINTABLE.search(line)
        assert match is not None
        problem = f"the character U+{ord(match[0]):04X} is not allowed in a scene file"
        raise InputError(Problem(problem, Place(file, number, match.start() + 1)))
    return lines


def _model_in(head: bytes) -> str | None:
    """The format of a model whose file begins with `head`; None where `mbproj import` reads no such format."""
    if not head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        return None
    return next((kind for tag, kind in _MODELS.items() if tag in head), None)


def _decode(data: bytes, place: Place) -> str:
    if data.startswith(b"\x89HDF"):
        raise InputError(Problem("this is a results file, not a scene", place, "'mbproj rerun' repeats its run"))
    if (kind := _model_in(data[:4096])) is not None:
        hint = f"'mbproj import {place.file} -o scene.yaml' makes a scene of it"
        raise InputError(Problem(f"this is a model in {kind}, not a scene", place, hint))
    if b"\0" in data:
        raise InputError(Problem("this is a binary file, not a scene", place, "a scene is YAML text in UTF-8"))
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        problem = f"the byte 0x{data[error.start]:02x} is not UTF-8 text"
        raise InputError(Problem(problem, Place(place.file, line), "save the file as UTF-8")) from None


def _similar_file(path: Path) -> str | None:
    try:
        return did_you_mean(path.name, (other.name for other in path.parent.iterdir()))
    except (OSError, ValueError):
        return None
