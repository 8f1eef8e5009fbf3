"""A journal: a file of JSON lines that keeps what a study has done, so that it resumes where it was interrupted."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mbproj.errors import InputError, Problem


class Journal:
    """Records by key. The first line of the file says what study it belongs to; without a path all is in memory."""

    def __init__(self, path: Path | None, study: Mapping[str, Any]) -> None:
        """Reads what is there. Raises InputError where the file belongs to another study, or cannot be written."""
        self.path, self._records = path, dict[str, Any]()
        head = json.dumps(study, sort_keys=True)
        try:
            if path is not None and not self._read(path, head):
                path.write_text(head + "\n", encoding="utf-8")
        except OSError as error:
            raise _unwritable(path, error) from error

    def _read(self, path: Path, head: str) -> bool:
        """Takes in the records; False where there is no such file. A last line that was cut short is dropped."""
        if not path.exists():
            return False
        lines = path.read_text(encoding="utf-8").split("\n")
        if lines[0] != head:
            message = f"'{path}' belongs to another study: another scene, version, span or grid"
            raise InputError(Problem(message, hint="begin anew with --fresh, or choose another place with -o"))
        for line in lines[1:-1]:
            key, record = json.loads(line)
            self._records[key] = record
        if lines[-1]:
            path.write_text("\n".join(lines[:-1]) + "\n", encoding="utf-8")
        return True

    def __contains__(self, key: str) -> bool:
        return key in self._records

    def __getitem__(self, key: str) -> Any:
        return self._records[key]

    def add(self, key: str, record: Any) -> None:
        """Keeps a record; it is on the disk when this returns."""
        self._records[key] = record
        try:
            if self.path is not None:
                with self.path.open("a", encoding="utf-8") as file:
                    file.write(json.dumps([key, record]) + "\n")
        except OSError as error:
            raise _unwritable(self.path, error) from error


def _unwritable(path: Path | None, error: OSError) -> InputError:
    return InputError(Problem(f"cannot write '{path}': {error.strerror}", hint="choose another place"))
