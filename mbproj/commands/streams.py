"""Safe stdout and stderr for commands. Names from files cannot control the terminal, and every encoding takes every
text. A stream that is closed, full or no longer read causes no traceback."""

from __future__ import annotations

import codecs
import errno
import io
import os
import sys
import unicodedata
from typing import Any, TextIO, cast

from mbproj.base.errors import ExitCode, MbprojError
from mbproj.base.text import escaped_text

#: Replacements for mbproj's own characters that an encoding lacks. Greek letters are replaced by their names.
PLAIN = {"≤": "<=", "≥": ">=", "√": "sqrt ", "→": "->", "·": "*", "×": "x", "∞": "infinity", "–": "-", "—": "-"}
#: The name of this replacement among Python's error handlers.
IN_OTHER_WORDS = "mbproj.in_other_words"


class StreamError(MbprojError):
    """The error where a command's output cannot be written, for example to a full disk."""

    exit_code = ExitCode.FAILED


class Stream(io.TextIOWrapper):
    """A stream that escapes control characters for a terminal. `descriptor` is the file descriptor of its bytes."""

    def __init__(self, binary: Any, encoding: str, name: str, descriptor: int) -> None:
        super().__init__(binary, encoding=encoding, errors=IN_OTHER_WORDS, line_buffering=binary.isatty())
        self._called, self._descriptor = name, descriptor

    def write(self, text: str, /) -> int:
        """Write the text, escaped. A file name that is no text keeps its bytes when a program reads it."""
        text = escaped_text(text)
        return self.command(_without_bytes(text) if self.isatty() else text)

    def command(self, text: str) -> int:
        """Write the text unescaped, for example to move the cursor of a terminal."""
        try:
            return super().write(text)
        except OSError as error:
            return self._fail(error)

    def flush(self) -> None:
        """Write the buffered text."""
        try:
            super().flush()
        except OSError as error:
            self._fail(error)

    def _fail(self, error: OSError) -> int:
        """Stop writing. The work goes on where nobody reads any more (`| head`), and where messages cannot be written.
        Otherwise raise StreamError."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._descriptor)
        os.close(nowhere)
        if error.errno != errno.EPIPE and self._called == "stdout":
            raise StreamError(f"cannot write to {self._called}: {error.strerror}") from error
        return 0


def commanding(stream: TextIO) -> TextIO:
    """The stream for text that may control the terminal: progress that overwrites itself."""
    return cast("TextIO", _Commands(stream))


class _Commands:
    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.flush, self.isatty = stream.flush, stream.isatty

    def write(self, text: str) -> int:
        """Writes the text as it is."""
        return self._stream.command(text) if isinstance(self._stream, Stream) else self._stream.write(text)


def protect_streams() -> None:
    """Replace stdout and stderr by a `Stream`."""
    _open_missing()
    sys.stdout = _protected(sys.stdout, "stdout", 1)
    sys.stderr = _protected(sys.stderr, "stderr", 2)


def _open_missing() -> None:
    """Open stdin, stdout and stderr where they are closed, without input or output. Otherwise the next file opened, a
    results file, would get their number, and messages would be written into it. stderr stays silent."""
    for descriptor, mode in enumerate((os.O_WRONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(descriptor)
        except OSError:
            os.set_inheritable(os.open(os.devnull, mode), True)


def _protected(stream: Any, name: str, descriptor: int) -> Stream:
    if stream is None:  # the stream was closed when Python started
        return Stream(open(descriptor, "wb", closefd=False), "utf-8", name, descriptor)
    encoding = codecs.lookup(stream.encoding).name
    stream.flush()
    return Stream(stream.detach(), "utf-8" if encoding == "ascii" else encoding, name, descriptor)


def _without_bytes(text: str) -> str:
    return "".join(f"\\x{ord(letter) - 0xDC00:02x}" if _is_byte(letter) else letter for letter in text)


def _is_byte(letter: str) -> bool:
    """Whether Python uses this letter for a byte of a file name that is no text."""
    return "\udc80" <= letter <= "\udcff"


def _replacement(error: UnicodeError) -> tuple[str | bytes, int]:
    """Return a replacement for characters that an encoding lacks: the bytes of file names, or words for mbproj's own
    characters."""
    assert isinstance(error, UnicodeEncodeError)
    letters = error.object[error.start : error.end]
    count = next((place for place, letter in enumerate(letters) if not _is_byte(letter)), len(letters))
    if count:
        return bytes(ord(letter) - 0xDC00 for letter in letters[:count]), error.start + count
    return _plain(letters[0]), error.start + 1


def _plain(letter: str) -> str:
    if letter in PLAIN:
        return PLAIN[letter]
    words = unicodedata.name(letter, "").split(" ")
    if words[0] == "GREEK" and words[2:3] == ["LETTER"] and len(words) == 4:
        return words[3].capitalize() if words[1] == "CAPITAL" else words[3].lower()
    return f"\\u{ord(letter):04x}"


codecs.register_error(IN_OTHER_WORDS, _replacement)
