"""What --json prints as a JSON Schema, from the tables of facts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mbproj.report_schema import ALWAYS, ANY_NAME, COMPLETE, Fact
from mbproj.report_schema.info import ATTRIBUTES
from mbproj.report_schema.reports import REPORTS
from mbproj.scene.fields.fields import DIALECT


def report_schema(name: str) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a report of `REPORTS`. Facts that are said under a condition are optional; a
    run that is complete has all that every complete one has."""
    report = REPORTS[name]
    made = {
        "$schema": DIALECT,
        "title": f"mbproj {report.commands[0]} --json",
        "description": report.words,
        **_shape(report.kind, report.facts),
    }
    if name == "run":
        made["if"] = {"properties": {"status": {"const": "complete"}}}
        made["then"] = {"required": _keys_when(report.facts, COMPLETE)}
    if name == "info":
        made["properties"]["attributes"]["properties"] = _object(ATTRIBUTES)["properties"]
    return made


def _shape(kind: str, fields: Sequence[Fact]) -> dict[str, Any]:
    """The schema of a value of this kind, whose object has these fields."""
    types, made = [], {}
    for each in kind.split(" | "):
        outer, _, inner = each.partition(" of ")
        types.append("object" if outer == "map" else outer)
        if inner:
            within = "additionalProperties" if outer == "map" else "items"
            made[within] = _shape(inner.replace(" or ", " | "), fields)
        elif outer == "object" and fields:
            made |= _object(fields)
    return {"type": types if len(types) > 1 else types[0], **made}


def _object(fields: Sequence[Fact]) -> dict[str, Any]:
    made: dict[str, Any] = {"properties": {}, "required": _keys_when(fields, ALWAYS), "additionalProperties": False}
    for fact in fields:
        shape = {**_shape(fact.kind, fact.fields), "description": _description(fact)}
        if ANY_NAME in fact.key:
            made.setdefault("patternProperties", {})[f"^{fact.key.replace(ANY_NAME, '.+')}$"] = shape
        else:
            made["properties"][fact.key] = shape
    return made


def _keys_when(facts: Sequence[Fact], when: str) -> list[str]:
    return [fact.key for fact in facts if fact.when == when and ANY_NAME not in fact.key]


def _description(fact: Fact) -> str:
    unit = f" ({fact.unit})" if fact.unit not in ("", "1") else ""
    when = "" if fact.when == ALWAYS else f"; {fact.when}"
    return f"{fact.words}{unit}{when}"
