"""Options of an MJCF model: flags that switch parts of the physics off act, and each other option gets a row of the
table.

MuJoCo's own list of options and flags is gone through, so that one of a later version has its row, too."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from mbproj.errors import Place
from mbproj.formats.mechanism import ImportedMechanism, Same
from mbproj.formats.mjcf.compiled import CompiledMjcf
from mbproj.formats.mjcf.flags import SWITCHES, disabled, enabled, is_unlifted

SOLVER, CONTACTS, SENSORS = "of MuJoCo's numerical method", "of contacts", "of sensors and reports"
#: What the other flags and options belong to. Flags are in capitals: those that are disabled, and that are enabled.
OTHERS: Mapping[str, str] = MappingProxyType(
    dict.fromkeys(("WARMSTART", "REFSAFE", "EULERDAMP", "AUTORESET", "ISLAND", "INVDISCRETE", "DIAGEXACT"), SOLVER)
    | dict.fromkeys(("timestep", "integrator", "solver", "jacobian", "iterations", "tolerance"), SOLVER)
    | dict.fromkeys(("ls_iterations", "ls_tolerance", "noslip_iterations", "noslip_tolerance"), SOLVER)
    | dict.fromkeys(("FILTERPARENT", "MIDPHASE", "NATIVECCD", "MULTICCD", "OVERRIDE", "SPECULATIVE", "IPC"), CONTACTS)
    | dict.fromkeys(("cone", "impratio", "ccd_iterations", "ccd_tolerance", "sdf_initpoints"), CONTACTS)
    | dict.fromkeys(("sdf_iterations", "o_margin", "o_solref", "o_solimp", "o_friction"), CONTACTS)
    | dict.fromkeys(("SENSOR", "ENERGY", "FWDINV", "magnetic"), SENSORS)
)
#: The options that act in the scene, or that get their rows where other parts do.
ELSEWHERE = (
    *("gravity", "density", "viscosity", "wind", "sleep_tolerance"),
    *("disableflags", "enableflags", "disableactuator"),
)


def say_options(compiled: CompiledMjcf, mechanism: ImportedMechanism) -> None:
    """Add a row on each flag that switches something off, on other options by what they belong to, and on a medium."""
    model, off, place = compiled.given, disabled(compiled.given), _place(compiled, "flag")
    for name in sorted(off & SWITCHES.keys()):
        mechanism.say(f"flag {name.lower()}", place, f"acts: the model turns {SWITCHES[name].what} off", Same.YES)
    if off >= {"SPRING", "DAMPER"} and (compiled.given.ngravcomp or model.opt.density or model.opt.viscosity):
        what = "act: without both MuJoCo computes no compensation of gravity and no medium either"
        mechanism.say("flags spring and damper", place, what, Same.YES)
    by_kind: dict[str, list[str]] = {}
    for name in _changed(model, off):
        by_kind.setdefault(OTHERS.get(name, ""), []).append(f"flag {name.lower()}" if name.isupper() else name)
    for kind, names in by_kind.items():
        _say_others(compiled, mechanism, kind, names)
    if "SLEEP" in enabled(model):
        what = "left out: bodies that move slowly come to rest in MuJoCo"
        mechanism.say("flag sleep", place, what, Same.UNTIL)
    _say_medium(compiled, mechanism)
    if is_unlifted(compiled.model):
        what = "left out: it has no effect without actuators, and the scene compensates gravity along all joints"
        mechanism.say("actuatorgravcomp of some joints", None, what, Same.NO)


def _changed(model: Any, off: frozenset[str]) -> Iterator[str]:
    """Yield the names of the flags and options that are not MuJoCo's own and do not act."""
    import mujoco

    usual = mujoco.MjOption()
    yield from sorted(off - SWITCHES.keys())
    yield from sorted(enabled(model) - {"SLEEP"})
    for name in dir(usual):
        if name.startswith("_") or name in ELSEWHERE or callable(getattr(usual, name)):
            continue
        if not np.array_equal(getattr(usual, name), getattr(model.opt, name)):
            yield name


def _say_others(compiled: CompiledMjcf, mechanism: ImportedMechanism, kind: str, names: list[str]) -> None:
    """Add the row on options of one kind; those of no known kind may affect the motion."""
    place, shown = _place(compiled, "option"), ", ".join(names)
    touch = bool(compiled.model.npair or (compiled.model.geom_contype | compiled.model.geom_conaffinity).any())
    rows = {
        SOLVER: ("left out: a scene has a numerical method of its own", Same.YES),
        CONTACTS: ("left out, as contacts are", Same.UNTIL if touch else Same.YES),
        SENSORS: ("left out: they do not act on the motion", Same.YES),
        "": ("left out: mbproj does not know their effect", Same.NO),
    }
    mechanism.say(f"options {kind}: {shown}" if kind else f"options {shown}", place, *rows[kind])


def _say_medium(compiled: CompiledMjcf, mechanism: ImportedMechanism) -> None:
    option, place = compiled.model.opt, _place(compiled, "option")
    if option.density or option.viscosity:
        wind = ", and its wind" if option.wind.any() else ""
        mechanism.say(f"medium with density or viscosity{wind}", place, "left out: a scene has none", Same.NO)
    elif option.wind.any():
        mechanism.say("option wind", place, "left out: it has no force without density and viscosity", Same.YES)


def _place(compiled: CompiledMjcf, tag: str) -> Place | None:
    """The place of the first <option>, or of the first <flag> in one."""
    options = compiled.source.root.all("option")
    elements = options if tag == "option" else [each for option in options for each in option.all(tag)]
    return next((each.place for each in elements), None)
