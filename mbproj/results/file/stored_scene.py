"""The /scene group of a file: the text that the scene can be read from again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from mbproj.results.file.contents import Contents


def text(contents: Contents, name: str) -> str:
    """A text of the group."""
    return contents.text(f"scene/{name}")


def as_json(contents: Contents, name: str) -> Any:
    """What the JSON in a text of the group says."""
    try:
        return json.loads(text(contents, name))
    except (ValueError, RecursionError) as error:
        raise contents.damaged(f"scene/{name}", "is not JSON") from error


def path(contents: Contents) -> Path | None:
    """Where the scene file stood; None for text from elsewhere."""
    found = text(contents, "path")
    if "\0" in found:
        raise contents.damaged("scene/path", "is not a path")
    return Path(found) if found else None


def overrides(contents: Contents) -> dict[str, str]:
    """Parameters that --set changed."""
    values = as_json(contents, "overrides")
    if not (isinstance(values, dict) and all(isinstance(value, str) for value in values.values())):
        raise contents.damaged("scene/overrides", "is not text by parameter")
    return values
