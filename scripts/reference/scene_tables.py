"""Tables of the scene file: its blocks, joints, forces, motions, units, functions, expectations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbproj.base import registry
from mbproj.base.settings import SETTINGS, SettingEntry, option_name
from mbproj.joints.table import JOINTS
from mbproj.scene.blocks.control_blocks import BLOCKS
from mbproj.scene.blocks.forces import FORCE_RECORDS
from mbproj.scene.blocks.motions import KINDS
from mbproj.scene.blocks.observables import COMPONENTS, MOMENTS, OBSERVABLES, OF_BUSHINGS
from mbproj.scene.blocks.signals import CONTROLLER_KEYS, SIGNAL_KEYS, STATE_KEYS
from mbproj.scene.expressions.evaluate import FUNCTIONS
from mbproj.scene.expressions.units import SYMBOLS
from mbproj.scene.fields.fields import Field
from mbproj.scene.grammar import JOINT, MARKER, OF_PROJECTION, SCENE, SIMULATION

from .markdown import code, codes, table


def scene_keys() -> str:
    """The blocks of a scene."""
    return keys_of(SCENE.keys, SCENE.required)


def simulation_keys() -> str:
    return settings(SIMULATION.keys, 1)


def projection_keys() -> str:
    return settings(OF_PROJECTION, 2)


def settings(fields: Mapping[str, Field[Any]], depth: int) -> str:
    """The settings whose paths have this length: what they take, their defaults, their options."""
    rows = [
        [code(entry.key), fields[entry.key].expects, _usual(entry), code(option_name(name)), entry.help]
        for name, entry in SETTINGS.items()
        if len(entry.path) == depth
    ]
    if depth == 1:
        method = SETTINGS["projection"]
        way = "a method, or [a mapping](#projection-methods)"
        rows.append([code("projection"), way, method.usual, code("--projection"), method.help])
    return table(["key", "value", "default", "option", "what it does"], rows)


def _usual(entry: SettingEntry) -> str:
    """The default of a setting, as a scene writes it."""
    value = entry.where_taken if entry.usual is None and entry.where_taken else entry.usual
    if isinstance(value, tuple):
        return ", ".join(f"{each:g}" for each in value) or "none"
    return entry.null if value is None else str(value).lower() if isinstance(value, bool) else f"{value}"


def marker_keys() -> str:
    return keys_of(MARKER.keys, MARKER.required)


def joints() -> str:
    """Every type: its rows, the keys that it needs, those that it may have, its coordinates."""
    rows = []
    for name, kind in JOINTS.items():
        record = JOINT.variants[name]
        needed = [key for key in record.required if key not in ("type", "bodies")]
        optional = [key for key in record.keys if key not in (*record.required, *kind.coordinates)]
        rows.append([code(name), str(rows_of(name)), codes(needed), codes(optional), codes(kind.coordinates)])
    return table(["joint", "rows", "needs", "may have", "coordinates"], rows)


def rows_of(joint: str) -> int:
    """How many rows of C a type of joint has."""
    return sum(3 if row[0] == "coincident" else 1 for row in JOINTS[joint].rows)


def forces() -> str:
    rows = [
        [
            code(name),
            codes(key for key in record.required if key != "type"),
            codes(key for key in record.keys if key not in (*record.required, "type")),
        ]
        for name, record in FORCE_RECORDS.items()
    ]
    return table(["force", "needs", "may have"], rows)


def motions() -> str:
    return ", ".join(code(kind) for kind in KINDS) + "\n"


def signals() -> str:
    kinds = {
        "signals": ({key: each for key, each in SIGNAL_KEYS.items() if key not in BLOCKS}, 1),
        "states": (STATE_KEYS, 1),
        "controllers": (CONTROLLER_KEYS, 2),
    }
    rows = [[code(block), codes([*keys][:needed]), codes([*keys][needed:])] for block, (keys, needed) in kinds.items()]
    return table(["block", "needs", "may have"], rows)


def signal_blocks() -> str:
    rows = [
        [code(name), codes(record.required), codes(key for key in record.keys if key not in record.required)]
        for name, record in BLOCKS.items()
    ]
    return table(["block", "needs", "may have"], rows)


def units() -> str:
    return " ".join(code(unit) for unit in SYMBOLS) + "\n"


def functions() -> str:
    return " ".join(code(name) for name in FUNCTIONS) + "\n"


def projection_methods() -> str:
    rows = [
        [code(name), entry.equations, entry.summary, codes(entry.options), "yes" if entry.compiled else "no"]
        for name, entry in registry.PROJECTIONS.items()
    ]
    return table(["method", "equations", "what it does", "options of its own", "compiled"], rows)


def integrators() -> str:
    rows = [
        [code(name), str(entry.order), entry.summary, "yes" if entry.embedded else "no"]
        for name, entry in registry.integrators().items()
    ]
    return table(["integrator", "order", "what it is", "error control"], rows)


def observables() -> str:
    rows = []
    for of, names in OBSERVABLES.items():
        rows.append([code(of), codes(names)])
        if of == "force":
            rows.append([f"{code(of)}, a `bushing`", codes(OF_BUSHINGS)])
    return table(["of", "quantity"], rows)


def moments() -> str:
    return f"`at`: a time, {codes(MOMENTS)}. `component`: {codes(COMPONENTS)}.\n"


def keys_of(keys: Mapping[str, object], required: tuple[str, ...]) -> str:
    """What belongs to each key, and whether it is required."""
    rows = [
        [code(name), field.expects, "yes" if name in required else ""]  # type: ignore[attr-defined]
        for name, field in keys.items()
    ]
    return table(["key", "value", "required"], rows)
