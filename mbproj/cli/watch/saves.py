"""The detection of saves: by a file's time, size and place on the disk, checked ten times a second."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from time import sleep

#: The time between two checks, s. A save is over when two checks agree: some editors write in pieces.
LOOK = 0.05


class Saves:
    """The state of some files. `moved` tells whether it has changed since it was last taken."""

    def __init__(self, files: Iterable[Path]) -> None:
        self.files = tuple(files)
        self._taken = self._now()

    def take(self) -> None:
        """Take the current state of the files as known."""
        self._taken = self._now()

    def follow(self, files: Iterable[Path]) -> None:
        """Watch these files from now on. The known state of files already watched stays."""
        known = dict(zip(self.files, self._taken, strict=True))
        self.files = tuple(files)
        self._taken = tuple(known.get(path) or _state(path) for path in self.files)

    @property
    def moved(self) -> bool:
        """Whether a file has been saved since."""
        return self._now() != self._taken

    def wait(self) -> None:
        """Wait until a file is saved, and take its new state."""
        before = self._taken
        while True:
            sleep(LOOK)
            now = self._now()
            if now != self._taken and now == before:
                self._taken = now
                return
            before = now

    def _now(self) -> tuple[tuple[int, ...], ...]:
        return tuple(map(_state, self.files))


def _state(path: Path) -> tuple[int, ...]:
    """The state of a file; empty where it is missing, as an editor may be about to replace it."""
    try:
        found = path.stat()
    except OSError:
        return ()
    return found.st_mtime_ns, found.st_size, found.st_ino
