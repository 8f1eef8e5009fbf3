"""Writes a file: a new private one in the same folder replaces the old one when it is complete."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.sandbox import try_in_sandbox

# --- Kinds of files that mbproj writes, and tests that tell its own files from those of others ------------------------


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


# --- Writes a file ----------------------------------------------------------------------------------------------------


ELSEWHERE = "choose another with -o"
#: Endings of the files that mbproj writes: no directory is made with such a name.
ENDINGS = (".csv", ".h5", ".html", ".json", ".pdf", ".png", ".svg", ".yaml")


@contextmanager
def replacing(path: Path, kind: FileKind, *, force: bool = False, hint: str = ELSEWHERE) -> Iterator[Path]:
    """Yield a new empty file beside `path`, to write into. Where the block ends well it becomes `path`; else it is
    removed.

    Before that, no other user can read or write it. Raises InputError where `path` must not be replaced (see
    `check_replaceable`), or cannot be written; `hint` is the advice for this case.
    """
    target = check_replaceable(path, kind, force=force, hint=hint)
    try:
        draft, mode = _new_file(target)
    except OSError as error:
        raise cannot_write(path, error, hint) from error
    try:
        yield draft
        draft.chmod(mode)
        draft.replace(target)
    except OSError as error:
        raise cannot_write(path, error, hint) from error
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def write_text(path: Path, text: str, kind: FileKind, *, force: bool = False, hint: str = ELSEWHERE) -> Path:
    """Write `text` in UTF-8 by means of `replacing`, with its line ends unchanged; return `path`."""
    with replacing(path, kind, force=force, hint=hint) as draft:
        draft.write_bytes(text.encode())
    return path


def check_replaceable(path: Path, kind: FileKind, *, force: bool = False, hint: str = ELSEWHERE) -> Path:
    """Return where a file for `path` is to be written: `path`, or the target where that is a link.

    Raises InputError where its folder takes no new files, or `path` is no regular file. Unless `force`, it is also
    raised for a file that mbproj did not write as one of this `kind`."""
    try:
        target = Path(os.path.realpath(path)) if path.is_symlink() else path
        _check_folder(target, hint)
        mode = target.stat().st_mode
    except FileNotFoundError:
        if path.is_symlink():
            raise InputError(Problem(f"'{path}' is a link to nothing", hint=f"remove it, or {hint}")) from None
        return target
    except OSError as error:
        raise cannot_write(path, error, hint) from error
    if stat.S_ISDIR(mode):
        raise InputError(Problem(f"'{path}' is a directory", hint=f"give a file in it, or {hint}"))
    if not stat.S_ISREG(mode):
        raise InputError(Problem(f"'{path}' is a pipe or a device, not a file", hint=hint))
    if not (force or kind.is_ours(target)):
        message = f"'{path}' exists and is not {kind.what} of mbproj, so it is not replaced"
        raise InputError(Problem(message, hint=f"remove it, give --force, or {hint}"))
    return target


def check_rewritable(path: Path | None) -> Path:
    """Return the path of a scene that is to be written into. Raises InputError where the scene is no file, or its file
    cannot be replaced."""
    if path is None:
        raise InputError("the scene is not a file, so nothing can be written into it")
    check_replaceable(path, SCENE, force=True, hint="write by hand")
    return path


def _check_folder(target: Path, hint: str) -> None:
    """Raises InputError where no new file can be made beside `target`. May raise OSError."""
    folder = target.parent
    if not folder.exists():
        problem = f"the directory '{folder}' of '{target}' does not exist"
        raise InputError(Problem(problem, hint=f"create it, or {hint}"))
    if not folder.is_dir():
        raise InputError(Problem(f"'{folder}' is a file, not a directory", hint=hint))
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(Problem(f"cannot write '{target}': its directory takes no new files", hint=hint))


def make_folder(folder: Path, hint: str = ELSEWHERE) -> Path:
    """Make the folder where it is missing, and return it. Raises InputError where it cannot be made, or where its name
    is that of a file."""
    if folder.suffix in ENDINGS and not folder.is_dir():
        message = f"'{folder}' has the name of a file, but several files are written: a directory is asked for"
        raise InputError(Problem(message, hint=f"give a directory; '{folder.parent}' would do"))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"cannot make the directory '{folder}': {error.strerror or error}"
        raise InputError(Problem(message, hint=hint)) from error
    return folder


def cannot_write(path: Path, error: OSError, hint: str) -> InputError:
    """The InputError for a file that the operating system does not let mbproj write."""
    return InputError(Problem(f"cannot write '{path}': {error.strerror or error}", hint=hint))


def _new_file(target: Path) -> tuple[Path, int]:
    """Make a file beside `target` that its owner alone can read. Return it, and the permissions that it is to have in
    the end: those of the file that it replaces, or those that a new file gets here."""
    draft = target.with_name(f".mbproj-{os.urandom(8).hex()}{target.suffix[:8]}")
    descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    try:
        mode = stat.S_IMODE(os.fstat(descriptor).st_mode)
        draft.chmod(0o600)
    finally:
        os.close(descriptor)
    with suppress(OSError):
        mode = stat.S_IMODE(target.stat().st_mode)
    return draft, mode
