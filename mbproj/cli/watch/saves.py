"""When a file was saved: by its time, size and place on the disk, looked at ten times a second."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from time import sleep

#: Seconds between two looks. A save that two looks see alike is over: some editors write in pieces.
LOOK = 0.05


class Saves:
    """The state of some files; `moved` tells whether it has changed since it was `taken` last."""

    def __init__(self, files: Iterable[Path]) -> None:
        self.files = tuple(files)
        self._taken = self._now()

    def take(self) -> None:
        """What stands there now is known from here on."""
        self._taken = self._now()

    def follow(self, files: Iterable[Path]) -> None:
        """Looks at these files from now on. What was known of those that it has looked at stays known."""
        known = dict(zip(self.files, self._taken, strict=True))
        self.files = tuple(files)
        self._taken = tuple(known.get(path) or _state(path) for path in self.files)

    @property
    def moved(self) -> bool:
        """Whether a file has been saved since."""
        return self._now() != self._taken

    def wait(self) -> None:
        """Returns when a file was saved, and takes what stands there then."""
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
    """Nothing of a file that is not there: an editor may be about to replace it."""
    try:
        found = path.stat()
    except OSError:
        return ()
    return found.st_mtime_ns, found.st_size, found.st_ino
