"""The table of differences between a scene and a model: each element, what becomes of it, and whether the motion is the
same."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbproj.cli.report.text import json_text
from mbproj.report_schema import report_of
from mbproj.report_schema.models import SAID

if TYPE_CHECKING:
    from mbproj.errors import Place
    from mbproj.formats.mechanism import Said, Same


def table_lines(said: Sequence[Said], all_said: str) -> list[str]:
    """The rows of the table, equal ones combined. Where there are none, the line `all_said`."""
    if not said:
        return [all_said]
    alike: dict[tuple[str, str, Same], list[Said]] = {}
    for row in said:
        alike.setdefault((row.element.partition(" '")[0], row.what, row.same), []).append(row)
    lines = ["same motion  element, and what happens with it"]
    for (kind, what, same), entries in alike.items():
        place = "" if entries[0].place is None else f", {_place(entries[0].place)}"
        shown = entries[0].element if len(entries) == 1 else f"{len(entries)} times {kind}"
        lines += [f"{same.value:13}{shown}{place}", f"{'':15}{what}"]
    return lines


def _place(place: Place) -> str:
    return f"{Path(place.file).name}:{place.line or 1}"


def table_json(said: Sequence[Said], **facts: Any) -> str:
    """The table as one JSON object, after these facts."""
    rows = [report_of(SAID.fields, row, place=str(row.place or "")) for row in said]
    return json_text(facts | {SAID.key: rows})
