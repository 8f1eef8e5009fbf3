"""Notes on a run: what its reader should know, as values that the file keeps and every interface shows alike."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Problem
from mbproj.results.faults import damaged

#: The attribute of the file with the notes (JSON); a run without notes has none.
KEY = "notes"


@dataclass(frozen=True)
class Note:
    """A note: its `text`, its `place` in the scene ("file:line:column", or ""), and whether it puts the motion in
    doubt."""

    text: str
    place: str = ""
    doubts_motion: bool = False

    @classmethod
    def on(cls, problem: Problem) -> Note:
        """The note on legal input that may be a mistake."""
        text = problem.message + (f"; {problem.hint}" if problem.hint else "")
        return cls(text, str(problem.place or ""))

    def __str__(self) -> str:
        return f"{self.place}: note: {self.text}" if self.place else f"note: {self.text}"


def as_attribute(notes: Sequence[Note]) -> str | None:
    """The notes as the attribute of a file; None where there is none."""
    return json.dumps([asdict(note) for note in notes]) if notes else None


def read(attributes: Mapping[str, Any], path: Path) -> tuple[Note, ...]:
    """The notes among the attributes of the file at `path`. Raises InputError where they are damaged."""
    try:
        notes = tuple(Note(**each) for each in json.loads(attributes.get(KEY, "[]")))
        kinds = {(type(note.text), type(note.place), type(note.doubts_motion)) for note in notes}
    except (ValueError, TypeError, RecursionError) as error:
        raise damaged(path, f"its attribute '{KEY}' holds no notes") from error
    if not kinds <= {(str, str, bool)}:
        raise damaged(path, f"its attribute '{KEY}' holds no notes")
    return notes
