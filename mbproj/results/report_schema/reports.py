"""The reports that commands print with --json, each with its facts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from mbproj.base.dataclass import dataclass
from mbproj.results.report_schema.facts import ALWAYS, ANY_NAME, COMPLETE, Fact
from mbproj.results.report_schema.files import (
    ACTUATORS,
    ATTRIBUTES,
    BUILD,
    COMPARISON,
    ENERGY,
    INFO,
    LARGEST_LOADS,
    SOUNDNESS,
    STEPS,
    THRESHOLD_ROWS,
)
from mbproj.results.report_schema.runs import RUN
from mbproj.results.report_schema.scenes import BRANCHES, CHECK, CURVE, EQUILIBRIUM, EXPORT, IMPORT, LINEAR, MODES
from mbproj.results.report_schema.studies import (
    BATCH,
    COMPARE,
    DESIGN,
    EVERY_STUDY,
    RECOMMEND,
    SENSITIVITY,
    STABILITY,
    SWEEP,
    THRESHOLD,
    TOPOLOGIES,
    TRADEOFF,
    VERIFY,
)
from mbproj.scene.fields.fields import DIALECT


@dataclass(frozen=True)
class JsonReport:
    """The facts that `commands` print, an option of a command included, and what the report is of, in `words`. It is of
    the `kind` "object", or else has many objects."""

    words: str
    facts: tuple[Fact, ...]
    commands: tuple[str, ...]
    kind: str = "object"


#: The reports by their name, which is that of the first command, with the option that asks for another report.
REPORTS: Mapping[str, JsonReport] = MappingProxyType(
    {
        "run": JsonReport(
            "A run. One that fails or is interrupted has what is said always.", RUN, ("run", "rerun", "continue")
        ),
        "check": JsonReport("A scene at its assembled start.", CHECK, ("check",)),
        "branches": JsonReport("The assemblies of a scene.", BRANCHES, ("branches",)),
        "curve": JsonReport("A curve of a scene.", CURVE, ("curve",)),
        "equilibrium": JsonReport("Where a scene rests.", EQUILIBRIUM, ("equilibrium",)),
        "modes": JsonReport("The modes of small motions.", MODES, ("modes",)),
        "linearize": JsonReport("A linear model: x' = A x + B u, y = C x + D u.", LINEAR, ("linearize",)),
        "info": JsonReport("A results file.", INFO, ("info",)),
        "info-loads": JsonReport("The largest loads of a run.", LARGEST_LOADS, ("info --loads",)),
        "info-steps": JsonReport("What limits the steps of a run.", STEPS, ("info --steps",)),
        "info-energy": JsonReport("The energy of a run.", ENERGY, ("info --energy",)),
        "info-check": JsonReport("A check of a results file or a sweep.", SOUNDNESS, ("info --check",)),
        "info-thresholds": JsonReport(
            "Every threshold, by name.", THRESHOLD_ROWS, ("info --thresholds",), "map of object"
        ),
        "build": JsonReport("mbproj itself.", BUILD, ("info --build",)),
        "compare-results": JsonReport("Two results files.", COMPARISON, ("compare-results",)),
        "loads": JsonReport("The forces of actuators along a motion.", ACTUATORS, ("loads",)),
        "compare": JsonReport("A comparison of methods.", (*COMPARE, *EVERY_STUDY), ("compare",)),
        "tradeoff": JsonReport("Accuracy against cost.", (*TRADEOFF, *EVERY_STUDY), ("tradeoff",)),
        "recommend": JsonReport("The cheapest setting for an error.", (*RECOMMEND, *EVERY_STUDY), ("recommend",)),
        "threshold": JsonReport("Thresholds of the projection.", (*THRESHOLD, *EVERY_STUDY), ("threshold",)),
        "stability": JsonReport("Where methods hold, degrade and fail.", (*STABILITY, *EVERY_STUDY), ("stability",)),
        "verify": JsonReport("A verification.", (*VERIFY, *EVERY_STUDY), ("verify",)),
        "sensitivity": JsonReport("How numbers change results.", (*SENSITIVITY, *EVERY_STUDY), ("sensitivity",)),
        "fit": JsonReport("A design.", (*DESIGN, *EVERY_STUDY), ("fit", "optimise")),
        "optimise-topologies": JsonReport(
            "The topologies of a design.", (*TOPOLOGIES, *EVERY_STUDY), ("optimise --topologies",)
        ),
        "sweep": JsonReport("The cases of a sweep.", (*SWEEP, *EVERY_STUDY), ("sweep",)),
        "batch": JsonReport("A batch of scenes.", (*BATCH, *EVERY_STUDY), ("batch",)),
        "import": JsonReport("What becomes of a model as a scene.", IMPORT, ("import",)),
        "export": JsonReport("What becomes of a scene as a model.", EXPORT, ("export",)),
    }
)


# --- What --json prints as a JSON Schema, from the tables of facts ----------------------------------------------------


def report_schema(name: str) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a report of `REPORTS`. Facts that are said under a condition are optional; a
    run that is complete has all that every complete one has."""
    report = REPORTS[name]
    schema = {
        "$schema": DIALECT,
        "title": f"mbproj {report.commands[0]} --json",
        "description": report.words,
        **_shape(report.kind, report.facts),
    }
    if name == "run":
        schema["if"] = {"properties": {"status": {"const": "complete"}}}
        schema["then"] = {"required": _keys_when(report.facts, COMPLETE)}
    if name == "info":
        schema["properties"]["attributes"]["properties"] = _object(ATTRIBUTES)["properties"]
    return schema


def _shape(kind: str, fields: Sequence[Fact]) -> dict[str, Any]:
    """The schema of a value of this kind, whose object has these fields."""
    types, schema = [], {}
    for each in kind.split(" | "):
        outer, _, inner = each.partition(" of ")
        types.append("object" if outer == "map" else outer)
        if inner:
            within = "additionalProperties" if outer == "map" else "items"
            schema[within] = _shape(inner.replace(" or ", " | "), fields)
        elif outer == "object" and fields:
            schema |= _object(fields)
    return {"type": types if len(types) > 1 else types[0], **schema}


def _object(fields: Sequence[Fact]) -> dict[str, Any]:
    schema: dict[str, Any] = {"properties": {}, "required": _keys_when(fields, ALWAYS), "additionalProperties": False}
    for fact in fields:
        shape = {**_shape(fact.kind, fact.fields), "description": _description(fact)}
        if ANY_NAME in fact.key:
            schema.setdefault("patternProperties", {})[f"^{fact.key.replace(ANY_NAME, '.+')}$"] = shape
        else:
            schema["properties"][fact.key] = shape
    return schema


def _keys_when(facts: Sequence[Fact], when: str) -> list[str]:
    return [fact.key for fact in facts if fact.when == when and ANY_NAME not in fact.key]


def _description(fact: Fact) -> str:
    unit = f" ({fact.unit})" if fact.unit not in ("", "1") else ""
    when = "" if fact.when == ALWAYS else f"; {fact.when}"
    return f"{fact.words}{unit}{when}"
