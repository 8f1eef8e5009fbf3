"""Whether what --json prints is as the tables of facts say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

from jsonschema import Draft202012Validator

from mbproj.results.report_schema.facts import ALWAYS, Fact
from mbproj.results.report_schema.reports import REPORTS, report_schema
from mbproj.results.report_schema.runs import APPLIES

#: The reports by the command and the option that print them; the longest that fits counts.
PRINTED_BY = {tuple(command.split()): name for name, report in REPORTS.items() for command in report.commands}


@cache
def validator(name: str) -> Draft202012Validator:
    return Draft202012Validator(report_schema(name))


def report_of(words: Sequence[str]) -> str:
    """The report that a command prints."""
    return PRINTED_BY[max((key for key in PRINTED_BY if key[0] == words[0] and {*key} <= {*words}), key=len)]


def refuse_what_no_table_says(words: Sequence[str], printed: Any) -> None:
    """Raise ValidationError where a command printed what the table does not say, or not what it says."""
    name = report_of(words)
    validator(name).validate(printed)
    list(said_in(printed, REPORTS[name].kind, REPORTS[name].facts))
    if name == "info":
        assert printed["attributes"].keys() <= report_schema(name)["properties"]["attributes"]["properties"].keys()


def said_in(value: Any, kind: str, fields: Sequence[Fact]) -> Iterator[Fact]:
    """Yield the facts that a value of this kind says, and those inside them. Facts under one condition are said
    together, or the condition is not theirs."""
    for each in kind.split(" | "):
        outer, _, inner = each.partition(" of ")
        if outer == "object" and isinstance(value, dict):
            for when in {fact.when for fact in fields} - {ALWAYS, APPLIES}:
                own = {fact.key for fact in fields if fact.when == when}
                assert own.isdisjoint(value) or own <= value.keys(), (when, own - value.keys())
            for fact in fields:
                if fact.key in value:
                    yield fact
                    yield from said_in(value[fact.key], fact.kind, fact.fields)
        elif outer in ("array", "map") and isinstance(value, (list, dict)):
            for item in value.values() if isinstance(value, dict) else value:
                yield from said_in(item, inner, fields)


def all_of(facts: Sequence[Fact]) -> Iterator[Fact]:
    """Yield these facts, and those inside them."""
    for fact in facts:
        yield fact
        yield from all_of(fact.fields)
