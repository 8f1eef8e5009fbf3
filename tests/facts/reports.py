"""Whether what --json prints is as the table of facts says."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

from jsonschema import Draft202012Validator

from mbproj.facts.schema import report_schema

#: The report that a command prints where none of these options asks for another.
PRINTED_BY = {"run": "run", "rerun": "run", "continue": "run", "info": "info", "check": "check"}
OTHERS = {"--check", "--steps", "--energy", "--loads", "--thresholds"}


@cache
def validator(name: str) -> Draft202012Validator:
    return Draft202012Validator(report_schema(name))


def report_of(words: Sequence[str]) -> str | None:
    """The report that a command prints, None where the table has none."""
    if "--build" in words:
        return "build"
    return None if OTHERS & {*words} and words[0] == "info" else PRINTED_BY.get(words[0])


def refuse_what_no_table_says(words: Sequence[str], printed: Any) -> None:
    """Raise ValidationError where a command printed what the table does not say, or not what it says."""
    name = report_of(words)
    if name is None:
        return
    validator(name).validate(printed)
    if name == "info":
        assert printed["attributes"].keys() <= report_schema(name)["properties"]["attributes"]["properties"].keys()
