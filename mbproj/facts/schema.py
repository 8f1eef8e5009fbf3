"""What --json prints as a JSON Schema, from the table of facts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from mbproj.facts import ALWAYS, COMPLETE, Fact
from mbproj.facts.check import CHECK
from mbproj.facts.info import ATTRIBUTES, BUILD, INFO
from mbproj.facts.run import RUN

DIALECT = "https://json-schema.org/draft/2020-12/schema"
#: The reports that have a schema, with the command that prints each.
REPORTS: Mapping[str, tuple[str, tuple[Fact, ...]]] = MappingProxyType(
    {"run": ("run", RUN), "info": ("info", INFO), "check": ("check", CHECK), "build": ("info --build", BUILD)}
)


def report_schema(name: str) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a report of `REPORTS`. Facts that are said under a condition are optional; a
    run that is complete has all that every complete one has."""
    command, facts = REPORTS[name]
    made: dict[str, Any] = {
        "$schema": DIALECT,
        "title": f"mbproj {command} --json",
        "type": "object",
        "properties": _properties(facts),
        "required": _said(facts, ALWAYS),
        "additionalProperties": False,
    }
    if name == "run":
        made["if"] = {"properties": {"status": {"const": "complete"}}}
        made["then"] = {"required": _said(facts, COMPLETE)}
    if name == "info":
        made["properties"]["attributes"]["properties"] = _properties(ATTRIBUTES)
    return made


def _said(facts: Sequence[Fact], when: str) -> list[str]:
    return [fact.key for fact in facts if fact.when == when]


def _properties(facts: Sequence[Fact]) -> dict[str, dict[str, Any]]:
    return {fact.key: {"type": _types(fact), "description": _description(fact)} for fact in facts}


def _types(fact: Fact) -> str | list[str]:
    kinds = fact.kind.split(" | ")
    return kinds if len(kinds) > 1 else kinds[0]


def _description(fact: Fact) -> str:
    unit = f" ({fact.unit})" if fact.unit not in ("", "1") else ""
    when = "" if fact.when == ALWAYS else f"; {fact.when}"
    return f"{fact.words}{unit}{when}"
