"""The signature of scenes that differ only in numbers. They are compiled and assembled as one scene whose numbers are
Lanes. Each decision of the code must be the same for all of them; where it is not, Parted divides them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.integrate.events.law_switches import switches_of
from mbproj.integrate.formulations.choice import Choice, choose, obstacle_to_kernel
from mbproj.integrate.formulations.kinematic import settings_along
from mbproj.kernel import core
from mbproj.lanes import Lanes, OfLanes, Parted, restacked
from mbproj.linear.equilibrium.started import start_state
from mbproj.model import compile_system
from mbproj.registry import AUTOMATIC, EQUILIBRIUM
from mbproj.scene.records import Scene, Settings
from mbproj.several import same_bits
from mbproj.studies.measure.mechanism import Mechanism


class OneByOne(Exception):
    """The block needs something that arrays cannot do: its cases run one by one."""


@dataclass(frozen=True, eq=False)
class Signature:
    """The mechanism, settings and formulation of all cases of a block, with their numbers as Lanes."""

    mechanism: Mechanism
    settings: Settings
    choice: Choice


def values_of(cases: Sequence[Sequence[float | str]]) -> list[Any]:
    """The values of B cases, (B, k), as k values of one scene. Numbers that differ become Lanes, as 0.0 and -0.0 do.
    Raises OneByOne where texts differ."""
    columns = []
    for column in zip(*cases, strict=True):
        if all(same_bits(each, column[0]) for each in column):
            columns.append(column[0])
        elif all(isinstance(each, float) for each in column):
            columns.append(Lanes(np.array(column)))
        else:
            raise OneByOne
    return columns


def as_one(records: Sequence[Any]) -> Any:
    """One record for several that differ in numbers alone, which are Lanes of it. Raises Parted where they differ in
    other things."""
    first = records[0]
    if all(each is first for each in records):
        return first
    if len({type(each) for each in records}) > 1:
        raise Parted([type(each) for each in records])
    if is_dataclass(first) and not isinstance(first, type):
        names = [
            each.name
            for each in fields(first)
            if any(getattr(one, each.name) is not getattr(first, each.name) for one in records)
        ]
        return replace(first, **{name: as_one([getattr(each, name) for each in records]) for name in names})
    if isinstance(first, Mapping):
        return {key: as_one([each[key] for each in records]) for key in first}
    if isinstance(first, tuple):
        return tuple(as_one(each) for each in zip(*records, strict=True))
    return first if all(same_bits(each, first) for each in records) else restacked(records)


def signature_of(scene: Scene, settings: Settings) -> Signature:
    """The signature of the cases whose numbers a scene has. Raises Parted where a decision differs between cases, and
    OneByOne where arrays cannot compute the run."""
    if settings.start == EQUILIBRIUM or settings.integrator == AUTOMATIC or core() is None:
        raise OneByOne
    system = compile_system(scene)
    if system.has_contacts or switches_of(system) is not None or system.actions.size:
        raise OneByOne
    if settings.formulation == "full" or obstacle_to_kernel(system, settings):
        raise OneByOne
    state = start_state(scene, system)
    choice = choose(system, state, settings, OfLanes(core()))
    if choice.compiled is None:
        raise OneByOne
    own = settings_along(system, settings) if choice.kinematic else settings
    return Signature(Mechanism(scene, system, state), own, choice)
