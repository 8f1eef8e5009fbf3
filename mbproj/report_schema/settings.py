"""The facts of settings: those of a run, with all defaults, and those of the runs of a study."""

from __future__ import annotations

from dataclasses import replace

from mbproj.report_schema import Fact
from mbproj.settings import HOW, SettingEntry
from mbproj.settings import SETTINGS as ENTRIES

_KINDS = {"str": "string", "float": "number", "int": "integer", "bool": "boolean"}
APPLIES = "where it applies"


def _fact(entry: SettingEntry) -> Fact:
    """What a report of a run says of a setting."""
    kind = "array of number" if entry.kind.startswith("tuple") else _KINDS[entry.kind]
    words = entry.help[:1].lower() + entry.help[1:].rstrip(".")
    if entry.type != entry.kind:
        kind, words = f"{kind} | null", f"{words}; null: {entry.null}"
    unit = {"int": "1", "str": ""}.get(entry.kind, entry.takes)
    return Fact(entry.key, kind, unit, words)


def _option(entry: SettingEntry) -> Fact:
    """The setting as an option of `mbproj run`, which is left out where it is null."""
    fact = _fact(entry)
    kind = fact.kind.removesuffix(" | null")
    words = fact.words.partition("; null: ")[0]
    return replace(fact, key=entry.name, kind=kind, words=words, when=fact.when if kind == fact.kind else APPLIES)


_TOP, _PROJECTION = (tuple(_fact(each) for each in ENTRIES.values() if len(each.path) == depth) for depth in (1, 2))
#: The settings of a run.
SETTINGS = (*_TOP, Fact("projection", "object", "", "options of the projection", fields=_PROJECTION))
#: The setting of a run of a study, by the options of `mbproj run`.
SETTING = tuple(_option(each) for each in ENTRIES.values() if each.decides == HOW)
