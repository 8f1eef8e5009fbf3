"""Writes a file: a new private one in the same folder replaces the old one when it is complete."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from mbproj.errors import InputError, Problem
from mbproj.output_files.kinds import SCENE, FileKind

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
