"""The message and the exit code for an exception that ends a command, or one scene of a batch."""

from __future__ import annotations

import errno
import traceback

from mbproj.errors import ExitCode, InputError, MbprojError

#: Errors of the operating system on a path that the user gave, which the user can mend.
WRONG_PATH = frozenset({
    errno.ENOENT, errno.EACCES, errno.EPERM, errno.ENAMETOOLONG, errno.ELOOP, errno.ENOTDIR, errno.EISDIR, errno.EROFS,
    errno.EEXIST, errno.ENXIO, errno.ENODEV, errno.ENOTEMPTY, errno.EXDEV,
})  # fmt: skip
#: Errors of the operating system where it is out of space, memory or open files, or where a device fails.
NO_MORE = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.ENOMEM, errno.EMFILE, errno.ENFILE,
                     errno.EAGAIN})  # fmt: skip
OUR_FAULT = "error: this is a fault of mbproj, not of your input; please report it with the lines above"


def ending(error: Exception) -> tuple[str, ExitCode]:
    """Return the message and the exit code for an exception that nobody caught. An exception that neither the input nor
    the state of the machine explains is a fault of mbproj. Its message has the traceback, for a report."""
    if isinstance(error, InputError):
        return str(error), error.exit_code
    if isinstance(error, MbprojError):
        return f"error: {error}", error.exit_code
    if isinstance(error, MemoryError):
        return "error: out of memory; record less (a longer --output-step), or use a larger machine", ExitCode.FAILED
    if isinstance(error, OSError) and error.errno in NO_MORE:
        return f"error: {_refused(error)}; make room, or use another place", ExitCode.FAILED
    if isinstance(error, OSError) and error.errno in WRONG_PATH and error.filename is not None:
        return f"error: {_refused(error)}; give another path", ExitCode.BAD_INPUT
    return f"{''.join(traceback.format_exception(error))}{OUR_FAULT}", ExitCode.INTERNAL


def _refused(error: OSError) -> str:
    where = "" if error.filename is None else f"'{error.filename}': "
    return f"{where}{error.strerror}"
