"""The schema of reports: what each command with --json says, each fact with its key, type, unit, words and condition.

The attributes of results files, --json, the schema of what it prints, `info` and the guide read it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Any

from mbproj.base.dataclass import dataclass

ALWAYS, COMPLETE = "always", "when complete"
#: What stands in a key for the name of a point, a body or the like.
ANY_NAME = "NAME"


@dataclass(frozen=True)
class Fact:
    """One fact of a report.

    `key`: its name in --json, where "NAME" stands for any name. `kind`: its type in JSON, or several as in
    "number | null". "array of number" has numbers as items, "map of number" is an object with a number by name; "or" is
    for alternatives inside. `unit`: "" where it has none, "1" for a ratio or a count. `words` say what it is, `when`
    under which condition it is said. `at` is the attribute of the source that holds it, where that has another name
    than the key, or is there under this condition alone. `fields` are the facts of the object in `kind`, where these
    are always the same."""

    key: str
    kind: str
    unit: str
    words: str
    when: str = ALWAYS
    at: str = ""
    fields: tuple[Fact, ...] = ()


def facts_of(table: Sequence[Fact], *keys: str, when: str = ALWAYS, unknown: bool = False) -> tuple[Fact, ...]:
    """The facts of a table with these keys, as another report says them: under another condition, and null where a
    value is `unknown`."""
    rows = {fact.key: fact for fact in table}
    null = " | null" if unknown else ""
    return tuple(replace(rows[key], kind=rows[key].kind + null, when=when) for key in keys)


def report_of(facts: Sequence[Fact], source: object, /, **known: Any) -> dict[str, Any]:
    """The report of a source, by key: the values that are `known`, else its attributes, and objects in these by their
    `fields`. A fact under a condition is in it where it is known, or names its attribute.

    Raises TypeError for a known key that is no fact."""
    unknown = known.keys() - {fact.key for fact in facts}
    if unknown:
        raise TypeError(f"no fact is called {sorted(unknown)}")
    said = (fact for fact in facts if fact.key in known or fact.at or fact.when in (ALWAYS, COMPLETE))
    values = {fact: known[fact.key] if fact.key in known else attrgetter(fact.at or fact.key)(source) for fact in said}
    return {fact.key: _in_json(fact.kind, fact.fields, value) for fact, value in values.items()}


def _in_json(kind: str, fields: Sequence[Fact], value: Any) -> Any:
    """The value, with dictionaries in place of the objects in it."""
    if not fields or value is None:
        return value
    outer, _, inner = next(each for each in kind.split(" | ") if "object" in each).partition(" of ")
    if outer == "map":
        return {name: _in_json(inner, fields, each) for name, each in value.items()}
    if outer == "array":
        return [_in_json(inner, fields, each) for each in value]
    return value if isinstance(value, (Mapping, str, int, float)) else report_of(fields, value)
