"""The tables of facts: what each command with --json says, each fact with its key, type, unit, words and condition.

The attributes of results files, --json, the schema of what it prints, `info` and the guide read it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mbproj.dataclass import dataclass

ALWAYS, COMPLETE = "always", "when complete"
#: What stands in a key for the name of a point, a body or the like.
ANY_NAME = "NAME"


@dataclass(frozen=True)
class Fact:
    """One fact of a report.

    `key`: its name in --json, where "NAME" stands for any name. `kind`: its type in JSON, or several as in
    "number | null". "array of number" has numbers as items, "map of number" is an object with a number by name; "or" is
    for alternatives inside. `unit`: "" where it has none, "1" for a ratio or a count. `words` say what it is, `when`
    under which condition it is said. `at` is the attribute of the run's report that holds it, where that has another
    name than the key. `fields` are the facts of the object in `kind`, where these are always the same."""

    key: str
    kind: str
    unit: str
    words: str
    when: str = ALWAYS
    at: str = ""
    fields: tuple[Fact, ...] = ()


def shared(table: Sequence[Fact], *keys: str, when: str = ALWAYS, unknown: bool = False) -> tuple[Fact, ...]:
    """The facts of a table with these keys, as another report says them: under another condition, and null where a
    value is `unknown`."""
    rows = {fact.key: fact for fact in table}
    null = " | null" if unknown else ""
    return tuple(replace(rows[key], kind=rows[key].kind + null, when=when) for key in keys)
